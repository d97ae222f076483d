"""The order in which drones are read, when a swarm reads many of them at once.

cflib asks every drone for its tables of contents, some 800 questions, calls it connected, and goes on with the values
of all its parameters, 284 questions more. The clients of a swarm share one interpreter. Thirty that read side by side
take twice the processor time of thirty that read one after the other, for handing the interpreter around; and those
that have finished take it for their values from those that have not.

So drones are read in turns, `AT_ONCE` at a time, and values only when no client waits for a table. A question is
answered after `PATIENCE_S` at the latest, in turn or not, and a turn ends when its client asks no more. Only the values
that are read right after the tables have turns; a later question is answered at once.
"""

from __future__ import annotations

import enum
from collections.abc import Hashable
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

from crazychoir_fw.crtp.packet import Port
from crazychoir_fw.crtp.services.param import MISC, READ, TOC
from crazychoir_fw.crtp.services.param_misc import EXTENDED_TYPE, EXTENDED_TYPE_V2
from crazychoir_fw.crtp.toc import ITEM

PATIENCE_S = 2.0
"""A question is held so long (s) at most."""
MAX_HELD = 16
"""Max held questions of one drone; cflib asks one after the other, and questions above the limit are answered."""
IDLE_S = 0.1
"""A turn ends after so long (s) without a question."""
LONGEST_S = 2.0
"""A turn ends after so long (s) in any case."""
SWEEP_S = 10.0
"""So long (s) after its tables a drone's values are part of connecting."""


class Reading(enum.Enum):
    """What connecting is made of."""

    TABLES = enum.auto()
    """Items of a table of contents: the client is busy all the time."""
    TYPES = enum.auto()
    """Which parameters can be stored: nothing can be sent ahead, and the client waits half of the time."""
    VALUES = enum.auto()
    """The same with values of parameters."""


AT_ONCE = {Reading.TABLES: 1, Reading.TYPES: 1, Reading.VALUES: 2}
"""So many turns of each kind at a time: more, and the threads of the client are in each other's way."""


def reading_of(datagram: bytes) -> Reading | None:
    """Return what a packet reads, None for all others."""
    if len(datagram) < 3:
        return None
    port, channel = datagram[0] >> 4, datagram[0] & 0x03
    if port in (Port.LOG, Port.PARAM) and channel == TOC:
        return Reading.TABLES if datagram[1] == ITEM else None
    if port == Port.PARAM and channel == MISC:
        return Reading.TYPES if datagram[1] in (EXTENDED_TYPE, EXTENDED_TYPE_V2) else None
    return Reading.VALUES if port == Port.PARAM and channel == READ else None


_D = TypeVar("_D", bound=Hashable)


@dataclass
class _Turn:
    reading: Reading
    began: float
    asked: float  # when the last question came


class _Held(NamedTuple):
    reading: Reading
    datagram: bytes
    since: float


class ReadScheduler(Generic[_D]):
    """Holds questions back until it is the turn of their drone. Only the radio calls it; times are of one clock (s)."""

    def __init__(self, values: int) -> None:
        """Begin without questions.

        Args:
            values: So many questions for values follow the tables.
        """
        self._values = values
        self.has_ended = False
        """Whether a turn has ended, so that another one may begin at once."""
        self._turns: dict[_D, _Turn] = {}
        self._held: dict[_D, list[_Held]] = {}  # in the order of their coming
        self._sweeps: dict[_D, tuple[int, float]] = {}  # values still to be read, and until when

    @property
    def waiting(self) -> list[_D]:
        """Drones whose clients wait for an answer; these are not silent."""
        return list(self._held)

    def hold(self, drone: _D, datagram: bytes, now: float) -> bool:
        """Take a packet that came for a drone. Returns whether it has to wait."""
        reading = reading_of(datagram)
        if reading is None or (reading is Reading.VALUES and not self._is_sweep(drone, now)):
            return False
        turn = self._turns.get(drone)
        if turn is not None and turn.reading is reading:
            turn.asked = now
            if reading is Reading.VALUES and self._sweeps[drone][0] == 0:
                self._end(drone)
            return False
        if turn is not None:
            self._end(drone)
        held = self._held.get(drone, [])
        if not held and self._may_begin(reading):
            self._begin(drone, reading, now)
            return False
        if len(held) >= MAX_HELD:
            return False
        self._held.setdefault(drone, []).append(_Held(reading, datagram, now))
        return True

    def release(self, now: float) -> list[tuple[_D, bytes]]:
        """Return the packets that need not wait any longer, in the order of their coming for each drone."""
        for drone, turn in list(self._turns.items()):
            if now - turn.asked > IDLE_S or now - turn.began > LONGEST_S:
                self._end(drone)
        self.has_ended = False
        free = []
        for drone, held in list(self._held.items()):
            is_late = now - held[0].since > PATIENCE_S
            if not is_late and self._may_begin(held[0].reading):
                self._begin(drone, held[0].reading, now)
            if is_late or drone in self._turns:
                free += self._let_go(drone)
        return free

    def release_all(self) -> list[tuple[_D, bytes]]:
        """Return all that waits, and begin again."""
        self._turns.clear()
        return [packet for drone in list(self._held) for packet in self._let_go(drone)]

    def forget(self, drone: _D) -> None:
        """Drop what a client of a drone has asked: it has gone."""
        if drone in self._turns:
            self._end(drone)
        self._sweeps.pop(drone, None)
        self._held.pop(drone, None)

    def _let_go(self, drone: _D) -> list[tuple[_D, bytes]]:
        return [(drone, held.datagram) for held in self._held.pop(drone)]

    def _is_sweep(self, drone: _D, now: float) -> bool:
        """Count a question for a value. Returns whether it belongs to connecting."""
        left, until = self._sweeps.get(drone, (0, 0.0))
        if left <= 0 or now > until:
            self._sweeps.pop(drone, None)
            return False
        self._sweeps[drone] = (left - 1, until)
        return True

    def _may_begin(self, reading: Reading) -> bool:
        turns = [turn.reading for turn in self._turns.values()]
        if turns.count(reading) >= AT_ONCE[reading]:
            return False
        waiting = (held[0].reading for held in self._held.values())
        return reading is not Reading.VALUES or all(other is reading for other in (*turns, *waiting))

    def _end(self, drone: _D) -> None:
        del self._turns[drone]
        self.has_ended = True

    def _begin(self, drone: _D, reading: Reading, now: float) -> None:
        self._turns[drone] = _Turn(reading, now, now)
        if reading is not Reading.VALUES:
            self._sweeps[drone] = (self._values, now + SWEEP_S)
