"""What a drone knows of its radio: log groups crtp and radio (docs/reference/crtp-cflib.md#20.1).

Counted over half seconds of simulated time. The numbers reach the drone through its uplink, so that they stand in the
journal: a replay, which has no client, shows the same ones.
"""

from __future__ import annotations

from crazychoir_fw.crtp.service_context import ServiceContext

PERIOD = 500
"""Ticks."""


class LinkStatistics:
    """Counts the packets of one drone."""

    def __init__(self, context: ServiceContext) -> None:
        """Begin to count."""
        self._context = context
        self._received = context.received
        self._sent = context.sent
        self._was_heard = False
        self._told: tuple[int | bool, ...] = (0, False, 0, 0, 0)
        self.rssi = 0
        """Attenuation of the radio (dB), as a Crazyflie shows it: 40 is close; 0 while nobody simulates it."""
        context.every(PERIOD, self._tell)

    def _tell(self) -> None:
        received, sent = self._context.received - self._received, self._context.sent - self._sent
        self._received += received
        self._sent += sent
        # a client pings ten times a second, and a second of silence means that it is gone
        is_connected = received > 0 or self._was_heard
        self._was_heard = received > 0
        per_second = 1000 // PERIOD
        numbers = (
            self.rssi if is_connected else 0,
            is_connected,
            self._received & 0xFFFF,
            min(received * per_second, 0xFFFF),
            min(sent * per_second, 0xFFFF),
        )
        if numbers != self._told:
            self._told = numbers
            self._context.drone.uplink.dispatch("link_statistics", *numbers)
