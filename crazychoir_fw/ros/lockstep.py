"""Who must have answered before simulated time goes on, so that results do not depend on the speed of a machine."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

Party = tuple[int, str]
"""Number of a drone, and the topic on which its node answers."""

MOURNING_S = 1.0
"""For how long nobody who has ended is believed to answer (s, wall): it is on the way since before, and whoever is
started again takes longer."""


@dataclass
class Answers:
    """Everybody who answers each odometry with a message, such as a controller with ``cmd_vel``.

    A party is waited for from its first message on. Who does not answer in time counts as silent, is waited for no
    more, and is so again as soon as it is heard.
    """

    parties: Iterable[Party]
    heard: set[Party] = field(default_factory=set)
    """Who has ever answered."""
    silent: set[Party] = field(default_factory=set)
    """Who was waited for in vain, and has not been heard since."""
    clock: Callable[[], float] = time.monotonic

    def __post_init__(self) -> None:
        self.parties = frozenset(self.parties)
        self._waiting: set[Party] = set()
        self._ended: dict[Party, float] = {}

    def expect_all(self) -> None:
        """From now on everybody is waited for, also who has not answered yet."""
        self.heard = set(self.parties)

    def ask(self) -> None:
        """A new odometry goes out: everybody who lives is waited for."""
        self._waiting = self.heard - self.silent

    def take(self, party: Party) -> bool:
        """Somebody answers. Returns whether he had been silent."""
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
        """Whether nobody is waited for."""
        return not self._waiting

    @property
    def is_anybody_there(self) -> bool:
        """Whether at least one lives."""
        return len(self.heard) > len(self.silent)

    @property
    def missing(self) -> frozenset[Party]:
        """Who has not been heard of at all."""
        return frozenset(self.parties) - self.heard

    def bury(self, party: Party) -> None:
        """Somebody is known to have ended: he is waited for no more until heard again.

        What he said before may still be under way; it must not bring him back, or everybody would wait for the dead.
        """
        self._ended[party] = self.clock()
        if party in self.heard:
            self.silent.add(party)
            self._waiting.discard(party)

    def give_up(self) -> list[Party]:
        """Wait no longer. Returns who is silent from now on."""
        late = sorted(self._waiting)
        self.silent |= self._waiting
        self._waiting = set()
        return late
