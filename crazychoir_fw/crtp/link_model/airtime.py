"""How long a Crazyradio takes for what it does.

The radio chip speaks Enhanced ShockBurst: the dongle sends a packet, the drone answers with an acknowledgment that
carries a packet of its own, and what is not acknowledged is sent again. The format of the frames is general knowledge
of that protocol; what is not is marked *typical*, and adjustable in `RadioConfig` or here.
"""

from __future__ import annotations

import math
from collections.abc import Callable

BITS_PER_SECOND = {"250K": 250e3, "1M": 1e6, "2M": 2e6}

FRAME_BITS = 8 * (1 + 5 + 2) + 9
"""Around the payload: preamble, address of 5 bytes, checksum of 2, and 9 bits of control field."""

SETTLE_S = 130e-6
"""Time of the chip from receiving to sending and back (s)."""

LARGEST_BYTES = 32
"""Max payload of a frame: the acknowledgment timeout is the airtime of a frame of this size (typical)."""

NULL_BYTES = 1
"""A null packet of the client, and the answer of a drone with nothing to say (typical: cflib finds a byte in it)."""


def transmission(payload_bytes: float, data_rate: str) -> float:
    """Return how long a frame with so many bytes is on the air (s)."""
    return (FRAME_BITS + 8 * payload_bytes) / BITS_PER_SECOND[data_rate]


def failed_try(up_bytes: float, data_rate: str) -> float:
    """Return how long a try takes that is not acknowledged (s)."""
    return transmission(up_bytes, data_rate) + SETTLE_S + transmission(LARGEST_BYTES, data_rate)


def good_try(up_bytes: float, down_bytes: float, data_rate: str) -> float:
    """Return how long a try takes that is acknowledged (s)."""
    return transmission(up_bytes, data_rate) + SETTLE_S + transmission(down_bytes, data_rate)


OPEN_S = 1.0
"""So long after its last packet a dongle goes on asking, and disturbs others on its channel (s)."""

MEMORY_S = 0.1
"""Time over which it is averaged how much a dongle is on the air (s)."""


class AirUse:
    """Counts exchanges. In between, a dongle asks with null packets, which are not counted one by one."""

    def __init__(self, null_air_s: float, polls_per_second: Callable[[], float]) -> None:
        """Begin to count.

        Args:
            null_air_s: How long one null packet is on the air (s).
            polls_per_second: Returns how many of them there are while there is nothing else to do (1/s).
        """
        self._null_air_s = null_air_s
        self._polls_per_second = polls_per_second
        self.free_at = -math.inf
        """When the last exchange ended (s)."""
        self.last_use = -math.inf
        """When there was last a packet (s)."""
        self.seconds_busy = 0.0
        """Time in exchanges that carried a packet (s)."""
        self.seconds_on_air = 0.0
        self.exchanges = 0
        self._recent_air = 0.0  # [s] on the air, within about MEMORY_S
        self._recent_count = 0.0  # transmissions within about MEMORY_S

    def activity(self, time: float) -> tuple[float, float]:
        """Return the share of the time that it is on the air, and the transmissions per second, as of lately (s)."""
        share, count = self._recent_air / MEMORY_S, self._recent_count / MEMORY_S
        idle = time - self.free_at
        if idle <= 0.0:
            return share, count
        fading = math.exp(-idle / MEMORY_S)
        asking = self._polls_per_second() if time - self.last_use < OPEN_S else 0.0
        return (
            share * fading + asking * 2.0 * self._null_air_s * (1.0 - fading),
            count * fading + asking * 2.0 * (1.0 - fading),
        )

    def count(self, start: float, end: float, on_air: float, transmissions: int, is_of_use: bool) -> None:
        """Count an exchange.

        Args:
            start: When it began (s).
            end: When it ended (s).
            on_air: How long of it a frame was on the air (s).
            transmissions: How often.
            is_of_use: Whether it carried a packet.
        """
        idle_share, idle_count = self.activity(start)
        fading = math.exp(-(end - start) / MEMORY_S)
        self._recent_air = idle_share * MEMORY_S * fading + on_air
        self._recent_count = idle_count * MEMORY_S * fading + transmissions
        self.free_at = end
        self.exchanges += 1
        self.seconds_on_air += on_air
        if is_of_use:
            self.seconds_busy += end - start
            self.last_use = end
