"""Port 6: positions from outside, what positioning decks measure, emergency stop (docs/reference/crtp-cflib.md#14)."""

from __future__ import annotations

from collections.abc import Iterable

from crazychoir_fw.crtp.packet import Port
from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.services.command_queue import CommandQueue
from crazychoir_fw.crtp.services.localization_streams import MatchedAngles, RangeStream, SweepAngles
from crazychoir_fw.crtp.services.service import Reply

POSITION, GENERIC, PACKED_POSITIONS = range(3)

EMERGENCY_STOP, EMERGENCY_WATCHDOG = 3, 4
POSE, PACKED_POSES = 8, 9
"""First byte on the generic channel."""

LOOK_EVERY = 10
"""Ticks between two looks for new measurements."""


class LocalizationService:
    """Hands positions to the drone, and streams the measurements of its decks while parameters ask for them."""

    ports = (Port.LOCALIZATION,)

    def __init__(self, context: ServiceContext) -> None:
        self._context = context
        self.positions = CommandQueue(context, newest_wins=True)
        self.packets = CommandQueue(context)
        # one that waits is as good as many, and nothing else can take its place
        self._emergencies = {request: CommandQueue(context, 1) for request in (EMERGENCY_STOP, EMERGENCY_WATCHDOG)}
        decks, stations = context.drone.struct.onboard.decks, context.drone.struct.onboard.estimator.stations
        self._streams: list[RangeStream | SweepAngles | MatchedAngles] = []
        if decks.flags.loco:
            self._streams.append(RangeStream(decks.loco))
        if decks.flags.lighthouse4:
            self._streams += [SweepAngles(decks.lighthouse, stations), MatchedAngles(decks.lighthouse, stations)]
        if self._streams:
            context.every(LOOK_EVERY, self._stream)

    def receive(self, port: int, channel: int, payload: bytes) -> Iterable[Reply]:
        """Let a packet take effect in the next step; where the drone answers, it does so then."""
        kind = payload[0] if channel == GENERIC and payload else -1
        if channel in (POSITION, PACKED_POSITIONS) or kind in (POSE, PACKED_POSES):
            self.positions.take(port, channel, payload)
        else:
            self._emergencies.get(kind, self.packets).take(port, channel, payload)
        return ()

    def _stream(self) -> None:
        for stream in self._streams:
            for payload in stream.payloads():
                self._context.send(Port.LOCALIZATION, GENERIC, payload, droppable=True)

    def end_session(self) -> None:
        """Streams go on while their parameters are set, as on the drone; nobody hears them."""
