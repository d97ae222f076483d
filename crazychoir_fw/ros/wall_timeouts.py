"""Timeouts by the wall clock in lockstep, where simulated time stands still until all nodes have answered."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from crazychoir_fw.guidance.communicator import TopicCommunicator


class WallTimeoutClock:
    """The clock of a node, plus the wall time of waits in which simulated time stood still.

    In lockstep the simulation waits for a node, and the node for a neighbor that has ended: a deadline in simulated
    time alone would never pass. Waits shorter than the patience do not count, so that a slow machine changes nothing.
    """

    def __init__(self, clock: Callable[[], float], patience: float, wall: Callable[[], float] = time.monotonic) -> None:
        """Extend a clock.

        Args:
            clock: Returns the time of the node (s).
            patience: Shortest wait that counts (s, wall).
            wall: Returns the wall time (s).
        """
        self._clock = clock
        self._patience = patience
        self._wall = wall
        self._waited = 0.0  # [s], wall time added so far
        self._seen = clock()
        self._since = wall()

    @property
    def has_waited(self) -> bool:
        """Whether any wait has counted so far."""
        return self._waited > 0.0

    def now(self) -> float:
        """Return the time (s)."""
        return self._clock() + self._waited

    def begin(self) -> float:
        """Begin to wait; returns the time (s)."""
        self._seen, self._since = self._clock(), self._wall()
        return self._seen + self._waited

    def look(self) -> None:
        """Check whether the clock advances; call it periodically during a wait."""
        seen, wall = self._clock(), self._wall()
        if seen != self._seen:
            self._seen, self._since = seen, wall
        elif wall - self._since >= self._patience:
            self._waited += wall - self._since
            self._since = wall


class RoundResync:
    """Detects that the rounds of a node are one behind those of its neighbors, and skips a round.

    A node that joins takes over the label that it received last, perhaps that of the previous step. From then on all
    messages of its round are there when it begins, and it completes at once. Its neighbors wait in every step for the
    message that it sends in the next step, until their timeout. The symptom: messages of the next round come, and then
    no step for a long time.
    """

    def __init__(
        self, communicator: TopicCommunicator, patience: float, wall: Callable[[], float] = time.monotonic
    ) -> None:
        """Watch the rounds of a communicator.

        Args:
            communicator: Communicator with the rounds to watch.
            patience: Longest time from a message of the next round to the step that opens that round (s, wall); above
                it, neighbors ran into their timeouts.
            wall: Returns the wall time (s).
        """
        self._communicator = communicator
        self._patience = patience
        self._wall = wall
        self._since = math.inf

    def look(self) -> None:
        """Check whether neighbors have begun the next round; call it at each message between rounds, and after each."""
        if self._since == math.inf and self._communicator.has_begun_elsewhere:
            self._since = self._wall()

    def make_up(self) -> None:
        """Skip a round that was missed; call it before each round."""
        if self._wall() - self._since >= self._patience:
            self._communicator.skip()
        self._since = math.inf
