"""Answers that each step of simulated time waits for, so that results do not depend on the speed of the machine."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

Party = tuple[int, str]
"""Number of a drone, and the topic on which its node answers."""

MOURNING_S = 1.0
"""Time after the end of a process in which its answers are ignored (s, wall): they were sent before it ended, since a
restart takes longer."""


@dataclass
class Answers:
    """Parties that answer each odometry with a message, such as a controller with ``cmd_vel``.

    Steps wait for a party from its first message on. A party that misses the deadline counts as silent: steps do not
    wait for it until its next message.
    """

    parties: Iterable[Party]
    heard: set[Party] = field(default_factory=set)
    """Parties that have answered at least once."""
    silent: set[Party] = field(default_factory=set)
    """Parties that missed a deadline or have ended, and have not answered since."""
    clock: Callable[[], float] = time.monotonic

    def __post_init__(self) -> None:
        self.parties = frozenset(self.parties)
        self._waiting: set[Party] = set()
        self._ended: dict[Party, float] = {}

    def expect_all(self) -> None:
        """Expect answers of all parties from now on, also of those that have not answered yet."""
        self.heard = set(self.parties)

    def ask(self) -> None:
        """Begin to wait for all parties that are not silent, as an odometry goes out."""
        self._waiting = self.heard - self.silent

    def take(self, party: Party) -> bool:
        """Take the answer of a party. Returns whether it had been silent."""
        if party in self._ended:
            if self.clock() - self._ended[party] < MOURNING_S:
                return False
            del self._ended[party]
        self.heard.add(party)
        self._waiting.discard(party)
        if party in self.silent:
            self.silent.discard(party)
            return True
        return False

    @property
    def is_complete(self) -> bool:
        """Whether no answer is pending."""
        return not self._waiting

    @property
    def is_anybody_there(self) -> bool:
        """Whether at least one party is not silent."""
        return len(self.heard) > len(self.silent)

    @property
    def missing(self) -> frozenset[Party]:
        """Parties that have never answered."""
        return frozenset(self.parties) - self.heard

    def bury(self, party: Party) -> None:
        """Mark a party whose process has ended as silent, until its next message after `MOURNING_S`.

        Messages from before its end may still arrive. They must not end its silence, or each step would wait for it.
        """
        self._ended[party] = self.clock()
        if party in self.heard:
            self.silent.add(party)
            self._waiting.discard(party)

    def give_up(self) -> list[Party]:
        """Stop waiting. Returns the parties that are silent from now on."""
        late = sorted(self._waiting)
        self.silent |= self._waiting
        self._waiting = set()
        return late
