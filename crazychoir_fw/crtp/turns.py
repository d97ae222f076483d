"""Clients that connect are served a few at a time, so that a swarm is connected sooner.

A `Swarm` of cflib opens all its links at once, each with threads of its own, in one process that runs one thread at a
time. Answered all at once, some sixty threads want to go on whenever one of them waits for a packet, and the switches
between them cost more than the work. So who begins to download tables of contents waits until few others do; so does
who then begins to read all parameters, and connecting comes first. cflib has asked one question and waits for its
answer: nothing else is held back.

A turn is over when its work is done, after a second in any case, and the next one also begins when those whose turn it
is have been silent for a moment. Who asks for more while it waits is no cflib, and does not wait. Clients on other
machines wait for the network, one question after the other, and are better served all at once.
"""

from __future__ import annotations

import enum
from collections import deque
from collections.abc import Iterable

from crazychoir_fw.crtp.owner import Address
from crazychoir_fw.crtp.packet import Port
from crazychoir_fw.crtp.toc import INFO

AT_ONCE = 2
"""So many clients are served: while one works on an answer, the other one's is on its way."""
SILENCE_S = 0.01
"""After so long without a question (s) of those whose turn it is, another one begins."""
STALE_S = 0.05
"""Who has asked nothing for so long (s) does something else."""
LONGEST_S = 1.0
"""A turn (s), so that nobody keeps others waiting by asking for ever."""

_HEADER = 0xF3  # without the two reserved bits
_LINK = Port.LINK << 4
_TOC_OF_LOGS = Port.LOG << 4
_VALUES = Port.PARAM << 4 | 1


def takes_turns(client: Address) -> bool:
    """Tell whether a client is on this machine, and waits for a processor rather than for the network."""
    return client[0].startswith("127.")


class Stage(enum.Enum):
    """How far a client has come."""

    NEW = "new"
    CONNECTING = "connecting"
    READING = "reading"
    """All parameters, one after the other."""
    DONE = "done"
    """From now on, nothing waits."""


class Visit:
    """One client at one drone."""

    def __init__(self, parameters: int) -> None:
        """Expect a client.

        Args:
            parameters: So many there are to be read.
        """
        self.parameters = parameters
        self.stage = Stage.DONE
        self.kept: list[bytes] = []
        """What waits for the turn."""
        self.unread = 0
        self.began_at = self.heard_at = 0.0


class Turns:
    """Whose turn it is. Knows neither sockets nor the clock; times (s) never go back."""

    def __init__(self, at_once: int = AT_ONCE) -> None:
        self._at_once = at_once
        self._served: set[Visit] = set()
        self._queues: dict[Stage, deque[Visit]] = {Stage.CONNECTING: deque(), Stage.READING: deque()}
        self._heard_at = 0.0

    @property
    def is_anybody_waiting(self) -> bool:
        """Whether `due` is to be called, every `SILENCE_S` at least."""
        return any(self._queues.values())

    def begin(self, visit: Visit) -> None:
        """Expect a new client."""
        self.end(visit)
        visit.stage = Stage.NEW

    def end(self, visit: Visit) -> None:
        """Forget a client, and what it waits for."""
        self._served.discard(visit)
        for queue in self._queues.values():
            if visit in queue:
                queue.remove(visit)
        visit.kept.clear()
        visit.stage = Stage.DONE

    def keeps(self, visit: Visit, datagram: bytes, now: float) -> bool:
        """Take note of a packet of a client that is not done. Returns whether it waits; then `due` returns it."""
        kind = datagram[0] & _HEADER
        if kind & 0xF0 == _LINK:
            return False
        if visit.kept:
            if kind & 0xF0 != visit.kept[0][0] & 0xF0:
                return False
            visit.kept.append(datagram)
            return True
        if visit.stage is Stage.NEW and kind == _TOC_OF_LOGS and datagram[1:2] == bytes((INFO,)):
            return self._queue(visit, Stage.CONNECTING, datagram)
        if visit.stage is Stage.CONNECTING and kind == _VALUES:
            visit.unread = visit.parameters
            return self._queue(visit, Stage.READING, datagram)
        if visit in self._served:
            visit.heard_at = self._heard_at = now
            if visit.stage is Stage.READING and kind == _VALUES:
                self._count(visit)
        return False

    def _queue(self, visit: Visit, stage: Stage, datagram: bytes) -> bool:
        self._served.discard(visit)
        visit.stage = stage
        visit.kept.append(datagram)
        self._queues[stage].append(visit)
        return True

    def _count(self, visit: Visit) -> None:
        visit.unread -= 1
        if visit.unread <= 0:
            self._served.discard(visit)
            visit.stage = Stage.DONE

    def due(self, now: float) -> Iterable[tuple[Visit, list[bytes]]]:
        """Return whose turn it is now, each with the packets that have waited for it."""
        for visit in tuple(self._served):
            if now - visit.heard_at > STALE_S or now - visit.began_at > LONGEST_S:
                self._served.discard(visit)
        called = []
        for queue in self._queues.values():
            # who asks for more does not wait for one answer
            hasty = [visit for visit in queue if len(visit.kept) > 1]
            for visit in hasty:
                queue.remove(visit)
                called.append((visit, self._take(visit, Stage.DONE)))
            while queue and (len(self._served) < self._at_once or now - self._heard_at > SILENCE_S):
                visit = queue.popleft()
                visit.began_at = visit.heard_at = self._heard_at = now
                self._served.add(visit)
                called.append((visit, self._take(visit, visit.stage)))
                if visit.stage is Stage.READING:
                    self._count(visit)
        return called

    def release(self) -> Iterable[tuple[Visit, list[bytes]]]:
        """Return all that wait, because there are no turns any more."""
        waiting = [visit for queue in self._queues.values() for visit in queue]
        for queue in self._queues.values():
            queue.clear()
        return [(visit, self._take(visit, Stage.DONE)) for visit in waiting]

    @staticmethod
    def _take(visit: Visit, stage: Stage) -> list[bytes]:
        kept, visit.kept, visit.stage = visit.kept, [], stage
        return kept
