"""What becomes of waits in lock step, where simulated time stands still until everybody has answered."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from crazychoir_fw.guidance.communicator import TopicCommunicator


class WallTimeoutClock:
    """The clock of a node, plus the time on the wall for which it has been waited for in vain.

    A simulation in lock step waits for a node that waits for a neighbor that is gone: by simulated time that would last
    for ever. Waits that are shorter than the patience do not count, so that a slow machine changes nothing.
    """

    def __init__(self, clock: Callable[[], float], patience: float, wall: Callable[[], float] = time.monotonic) -> None:
        """Go with a clock.

        Args:
            clock: Returns the time of the node (s).
            patience: How long a wait may last that does not count (s, wall).
            wall: Returns the time on the wall (s).
        """
        self._clock = clock
        self._patience = patience
        self._wall = wall
        self._waited = 0.0  # [s], in vain, so far
        self._seen = clock()
        self._since = wall()

    @property
    def has_waited(self) -> bool:
        """Whether anything was ever waited for in vain."""
        return self._waited > 0.0

    def now(self) -> float:
        """Return the time (s)."""
        return self._clock() + self._waited

    def begin(self) -> float:
        """Begin to wait; returns the time (s)."""
        self._seen, self._since = self._clock(), self._wall()
        return self._seen + self._waited

    def look(self) -> None:
        """See whether the clock still goes; to be called now and then while waiting."""
        seen, wall = self._clock(), self._wall()
        if seen != self._seen:
            self._seen, self._since = seen, wall
        elif wall - self._since >= self._patience:
            self._waited += wall - self._since
            self._since = wall


class RoundResync:
    """Tells a node whether its neighbors had a round without it: then its rounds are one behind theirs.

    Who joins takes over the label that it heard last, perhaps that of the step before. From then on it finds all
    messages of its round there, and answers at once; the others wait in every step for the message that it sends in the
    next one, and give up. It hears them begin, and then nothing for a long time.
    """

    def __init__(
        self, communicator: TopicCommunicator, patience: float, wall: Callable[[], float] = time.monotonic
    ) -> None:
        """Watch the rounds of a communicator.

        Args:
            communicator: Whose rounds they are.
            patience: Between a message of a round that is not open yet and the step that opens it (s, wall); longer,
                and others have waited for this node.
            wall: Returns the time on the wall (s).
        """
        self._communicator = communicator
        self._patience = patience
        self._wall = wall
        self._since = math.inf

    def look(self) -> None:
        """Look whether others have begun a round; to be called at each message between two rounds, and after each."""
        if self._since == math.inf and self._communicator.has_begun_elsewhere:
            self._since = self._wall()

    def make_up(self) -> None:
        """Leave out a round that was missed; to be called before each round."""
        if self._wall() - self._since >= self._patience:
            self._communicator.skip()
        self._since = math.inf
