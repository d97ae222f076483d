"""What all distributed algorithms have in common: rounds of one message to every neighbor.

A round is `begin_round` (send) and `finish_round` (use what came), so that a timer can drive it and never waits; `run`
does many of them and waits for the neighbors in between.
"""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.optimization.agent import Agent

Array = NDArray[np.float64]


class Algorithm(ABC):
    """A distributed algorithm as one agent runs it.

    Attributes:
        agent: The agent.
        rounds: Rounds that ended.
        enable_log: Remember the result of every round.
    """

    def __init__(self, agent: Agent, enable_log: bool = False) -> None:
        """Begin.

        Args:
            agent: The agent that runs it.
            enable_log: Remember the result of every round; `run` returns them.
        """
        self.agent = agent
        self.enable_log = enable_log
        self.rounds = 0
        self._log: list[Any] = []

    # ---------------------------------------------------------------- what an algorithm is

    @abstractmethod
    def _message(self) -> object:
        """Return what the neighbors get this round."""

    @abstractmethod
    def _update(self, received: Mapping[int, Any]) -> None:
        """Use messages by neighbor; those of neighbors that did not send in time are missing."""

    @abstractmethod
    def get_result(self) -> Any:
        """Return the agent's estimate of the solution."""

    @property
    def is_done(self) -> bool:
        """Whether the agent knows that nothing will change any more."""
        return False

    # ---------------------------------------------------------------- rounds

    def begin_round(self, now: float = 0.0) -> None:
        """Send to the neighbors of this round.

        Args:
            now: Time (s), for neighbors that change with it.
        """
        self.agent.turn(now)
        self.agent.neighbors_send(self._message())

    def is_complete(self) -> bool:
        """Return whether the messages of this round are all there; always so in asynchronous mode."""
        return self.agent.has_round()

    def finish_round(self) -> None:
        """Use what came, without waiting for the rest."""
        self._finish(self.agent.collect())

    def _finish(self, received: Mapping[int, Any]) -> None:
        self._update(received)
        self.rounds += 1
        if self.enable_log:
            self._log.append(self.get_result())

    def run(
        self,
        iterations: int = 100,
        verbose: bool = False,
        event: threading.Event | None = None,
        *,
        timeout: float | None = None,
        interval: float = 0.0,
    ) -> list[Any] | None:
        """Do rounds, waiting for the neighbors in each.

        Args:
            iterations: How many.
            verbose: Print the number of every round.
            event: Set by another thread, it ends the run.
            timeout: How long to wait for neighbors in a round (s); None is the deadline of the communicator.
            interval: Pause after each round (s), of use in asynchronous mode, where nothing else paces it.

        Returns:
            With `enable_log`, the results of all rounds.
        """
        for _ in range(iterations):
            if event is not None and event.is_set():
                break
            self.begin_round()
            self._finish(self.agent.receive(event, timeout))
            if verbose:
                print(f"agent {self.agent.id}: round {self.rounds}")
            if self.is_done:
                # neighbors that are behind still learn the last word
                self.agent.neighbors_send(self._message())
                break
            if interval:
                time.sleep(interval)
        return self._log if self.enable_log else None

    # ---------------------------------------------------------------- for algorithms that average

    def _mixed(self, own: Array, received: Mapping[int, Array]) -> Array:
        """Return the weighted mean of own and received values; own stands in for missing ones."""
        mean = np.zeros_like(own)
        left = 1.0
        for one in self.agent.in_neighbors:
            if one in received:
                weight = self.agent.in_weights[one]
                mean += weight * received[one]
                left -= weight
        return mean + left * own


def vector(what: str, value: ArrayLike) -> Array:
    """Return a copy of a value as numbers of 64 bits.

    Raises:
        RangeError: If there is none, or one is not finite.
    """
    array = np.array(value, dtype=np.float64)
    if array.size == 0 or not np.all(np.isfinite(array)):
        raise RangeError(f"{what} is {value!r:.60}, allowed: finite numbers")
    return array


def positive(what: str, value: float) -> float:
    """Return the value.

    Raises:
        RangeError: If it is not above zero.
    """
    if not 0.0 < value < np.inf:
        raise RangeError(f"{what} is {value}, allowed: above 0")
    return float(value)
