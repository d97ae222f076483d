"""Port 6: positions from outside, emergency stop, and what positioning decks measure.

docs/reference/crtp-cflib.md#14. Streams are asked a hundred times a second; one whose parameter is off costs one look.
Angles are those of cflib's `LighthouseBsVector`: to the left and upward from where the base station looks. Not
established is what makes the firmware send angles. Here every turn of a base station that all four sensors have seen
makes one packet.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable
from typing import Any

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.crtp.packet import Port
from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.services.service import CommandQueue, Reply

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
        """Streams go on while their parameters are set, as on the drone; without a client they are dropped."""


RANGES, ANGLES, MATCHED_ANGLES = 0, 10, 12
"""First byte."""

RANGES_PER_PACKET = 5
LONGEST_TURN = 12
"""Ticks between the two planes of a turn, at most."""

_ALL_SENSORS = (1 << lib.CF_LIGHTHOUSE_SENSORS) - 1
_TICKS = 1 << 32


class RangeStream:
    """Distances to the anchors of the loco system, five per packet; there are some in two-way ranging only."""

    def __init__(self, deck: Any) -> None:
        self._deck = deck
        self._seen = 0
        self._ranges: list[tuple[int, float]] = []

    def payloads(self) -> list[bytes]:
        """Return the packets that are due."""
        if not self._deck.streams:
            self._ranges.clear()
            self._seen = self._deck.streamed.written
            return []
        ring = self._deck.streamed
        seen, self._seen = self._seen, ring.written
        # after a return to another time, they are not the next ones
        if not 0 <= ring.written - seen <= lib.CF_STREAMED_RANGES:
            self._ranges.clear()
            return []
        for number in range(seen, ring.written):
            at = number % lib.CF_STREAMED_RANGES
            self._ranges.append((ring.anchors[at], ring.distances[at]))
        payloads = []
        while len(self._ranges) >= RANGES_PER_PACKET:
            packet, self._ranges = self._ranges[:RANGES_PER_PACKET], self._ranges[RANGES_PER_PACKET:]
            payloads.append(bytes((RANGES,)) + b"".join(struct.pack("<Bf", *item) for item in packet))
        return payloads


class _Turns:
    """Notices turns of base stations."""

    def __init__(self, deck: Any, stations: Any) -> None:
        self._deck = deck
        self._stations = stations
        self._seen = [0] * lib.CF_LIGHTHOUSE_STATIONS
        self._ray = ffi.new("float[3]")
        self._upright = ffi.new("cf_station_data_t *")  # with the calibration of another, but the world's axes
        for i in range(3):
            self._upright.rotation[i][i] = 1.0

    def new(self) -> list[tuple[int, int]]:
        """Return base stations with a whole turn since the last look, and when it ended (ms)."""
        found = []
        for station in range(lib.CF_LIGHTHOUSE_STATIONS):
            turn = self._deck.turns[station]
            first, end = turn.ticks[0], turn.ticks[1]
            if end == self._seen[station] or (end - first) % _TICKS > LONGEST_TURN:
                continue
            self._seen[station] = end
            if turn.sensors[0] & turn.sensors[1] == _ALL_SENSORS:
                found.append((station, end))
        return found

    def angles(self, station: int) -> bytes:
        """Return the angles of the latest turn: that of sensor 0, and how far the others are below it."""
        turn = self._deck.turns[station].angles
        self._upright.calibration = self._stations.list[station].calibration
        lefts, ups = zip(*(self._left_and_up(turn[sensor]) for sensor in range(lib.CF_LIGHTHOUSE_SENSORS)), strict=True)
        return bytes((station,)) + b"".join(
            struct.pack("<f3e", angles[0], *(angles[0] - other for other in angles[1:])) for angles in (lefts, ups)
        )

    def _left_and_up(self, angles: Any) -> tuple[float, float]:
        """Return the angles (rad) of a sensor that the planes met at these angles (rad) of the rotor, corrected."""
        lib.cf_lighthouse_ray(self._upright, angles, self._ray)
        return math.atan2(self._ray[1], self._ray[0]), math.atan2(self._ray[2], self._ray[0])


class SweepAngles:
    """The angles of every turn of every base station."""

    def __init__(self, deck: Any, stations: Any) -> None:
        self._deck = deck
        self._turns = _Turns(deck, stations)

    def payloads(self) -> list[bytes]:
        """Return the packets that are due."""
        if not self._deck.streams_angles:
            return []
        return [bytes((ANGLES,)) + self._turns.angles(station) for station, _ in self._turns.new()]


class MatchedAngles:
    """The angles of turns of several base stations that belong together."""

    def __init__(self, deck: Any, stations: Any) -> None:
        self._deck = deck
        self._turns = _Turns(deck, stations)
        self._group = 0
        self._waiting: dict[int, tuple[int, bytes]] = {}  # tick and angles by base station

    def payloads(self) -> list[bytes]:
        """Return the packets that are due: those of a whole group, or none."""
        if not self._deck.streams_matched:
            self._waiting.clear()
            return []
        new = self._turns.new()
        for station, tick in new:
            self._waiting[station] = (tick, self._turns.angles(station))
        if not new:
            return []
        newest = max(tick for _, tick in new)
        self._waiting = {
            station: (tick, angles)
            for station, (tick, angles) in self._waiting.items()
            if (newest - tick) % _TICKS <= self._deck.matched_time
        }
        if len(self._waiting) < max(1, self._deck.matched_stations):
            return []
        self._group = (self._group + 1) % 16
        ending = bytes((self._group << 4 | len(self._waiting),))
        payloads = [bytes((MATCHED_ANGLES,)) + angles + ending for _, angles in self._waiting.values()]
        self._waiting.clear()
        return payloads
