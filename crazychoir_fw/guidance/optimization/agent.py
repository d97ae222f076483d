"""One agent of a distributed algorithm: its neighbors, their weights, its part of the problem, its messages."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from crazychoir_fw.common.errors import RangeError, StateError

if TYPE_CHECKING:
    from crazychoir_fw.guidance.communicator import TopicCommunicator
    from crazychoir_fw.guidance.graph import NeighborSchedule

Weights = Sequence[float] | Mapping[int, float]
"""A row of the weight matrix, or weights by neighbor."""

_SLACK = 1e-9  # by which weights may miss [0, 1] after their sum was rounded


class Agent:
    """An agent with the attributes and methods that DISROPT's has (docs/reference/crazychoir.md#18).

    Attributes:
        id: Number of the agent, its communicator's rank.
        in_neighbors: Agents that it receives from.
        out_neighbors: Agents that receive from it.
        in_weights: Weight by agent, of received values, itself included.
        out_weights: Weight by agent, of sent values, itself included.
        problem: Its part of the problem.
    """

    def __init__(
        self,
        in_neighbors: Iterable[int] | None = None,
        out_neighbors: Iterable[int] | None = None,
        communicator: TopicCommunicator | None = None,
        in_weights: Weights | None = None,
        out_weights: Weights | None = None,
        auto_local: bool = True,
        *,
        schedule: NeighborSchedule | None = None,
    ) -> None:
        """Take part.

        Args:
            in_neighbors: Agents that it receives from; None: all in-neighbors of its communicator.
            out_neighbors: Agents that receive from it; None: all out-neighbors of its communicator.
            communicator: How it talks to them.
            in_weights: Of what it hears: a row of the weight matrix (length N), or a dictionary by neighbor. None:
                equal shares of the neighbors, none for itself.
            out_weights: Of what it says, likewise.
            auto_local: Its own weight is what the others leave of 1; otherwise it is given as well.
            schedule: Neighbors that change with the rounds, with Metropolis-Hastings weights; the arguments above are
                then the largest graph.

        Raises:
            RangeError: If there is no communicator, a neighbor has no weight, or weights are not in [0, 1].
        """
        if communicator is None:
            raise RangeError("agent: there is no communicator, allowed: one of crazychoir_fw.guidance")
        self.communicator = communicator
        self.id = communicator.rank
        self.problem: Any = None
        self.set_neighbors(
            communicator.in_neighbors if in_neighbors is None else in_neighbors,
            communicator.out_neighbors if out_neighbors is None else out_neighbors,
        )
        self.all_in_neighbors, self.all_out_neighbors = self.in_neighbors, self.out_neighbors
        self.set_weights(in_weights, out_weights, auto_local)
        self._schedule = schedule

    def set_neighbors(self, in_neighbors: Iterable[int], out_neighbors: Iterable[int]) -> None:
        """Change in-neighbors and out-neighbors; weights stay until they are set."""
        self.in_neighbors = tuple(sorted({int(one) for one in in_neighbors}))
        self.out_neighbors = tuple(sorted({int(one) for one in out_neighbors}))
        if self.id in self.in_neighbors or self.id in self.out_neighbors:
            raise RangeError(f"agent {self.id}: its neighbors hold itself, allowed: other agents")

    def set_weights(
        self, in_weights: Weights | None = None, out_weights: Weights | None = None, auto_local: bool = True
    ) -> None:
        """Change the weights; arguments and errors are those of the constructor."""
        self.in_weights = self._weights("in_weights", in_weights, self.in_neighbors, auto_local)
        self.out_weights = self._weights("out_weights", out_weights, self.out_neighbors, auto_local)

    def _weights(
        self, what: str, given: Weights | None, neighbors: tuple[int, ...], auto_local: bool
    ) -> dict[int, float]:
        if given is None:
            share = 1.0 / len(neighbors) if neighbors else 0.0
            return {**dict.fromkeys(neighbors, share), self.id: 0.0 if neighbors else 1.0}
        known = dict(given) if isinstance(given, Mapping) else dict(enumerate(given))
        if missing := [one for one in (*neighbors, *(() if auto_local else (self.id,))) if one not in known]:
            raise RangeError(f"agent {self.id}: {what} has no weight for agent {missing[0]}")
        weights = {one: float(known[one]) for one in neighbors}
        weights[self.id] = 1.0 - sum(weights.values()) if auto_local else float(known[self.id])
        for one, weight in weights.items():
            if not -_SLACK <= weight <= 1.0 + _SLACK:
                whose = "its own weight" if one == self.id else f"the weight of agent {one}"
                raise RangeError(f"agent {self.id}: {what}: {whose} is {weight:.6g}, allowed: [0, 1]")
        return weights

    def set_problem(self, problem: Any) -> None:
        """Give it its part of the problem; it may be changed between rounds."""
        self.problem = problem

    # ---------------------------------------------------------------- messages, as those of DISROPT's agent

    def neighbors_send(self, obj: object) -> None:
        """Send an object to all out-neighbors."""
        self.communicator.neighbors_send(obj, self.out_neighbors)

    def neighbors_receive_asynchronous(self) -> dict[int, Any]:
        """Return what came since the last call, the latest of each in-neighbor, without waiting."""
        return self.communicator.neighbors_receive_asynchronous(self.in_neighbors)

    def neighbors_exchange(
        self,
        obj: object,
        dict_neigh: bool = False,
        event: threading.Event | None = None,
        timeout: float | None = None,
    ) -> dict[int, Any]:
        """Send, then wait for the same round of all in-neighbors.

        Args:
            obj: What to send; with `dict_neigh`, a dictionary by receiver.
            dict_neigh: Something else for each receiver; the communicator needs differentiated topics.
            event: Set by another thread, it ends the wait.
            timeout: How long to wait at most (s); None is the deadline of the communicator.

        Returns:
            Messages by neighbor, without neighbors that did not send in time.
        """
        return self.communicator.neighbors_exchange(
            obj, self.in_neighbors, self.out_neighbors, dict_neigh=dict_neigh, stop_event=event, timeout=timeout
        )

    # ---------------------------------------------------------------- one round, without waiting

    @property
    def is_asynchronous(self) -> bool:
        """Whether its communicator hands out the latest messages rather than rounds."""
        return not getattr(self.communicator, "synchronous_mode", True)

    def turn(self, now: float = 0.0) -> None:
        """Take the neighbors of the open round from the schedule, where there is one."""
        if self._schedule is None:
            return
        label = self.communicator.current_label
        into, out = self._schedule.neighbors_at(self.id, now, label)
        self.set_neighbors(into, out)
        degrees = {one: len(self._schedule.neighbors_at(one, now, label)[0]) for one in into}
        own = len(into)
        self.set_weights(
            {one: 1.0 / (1.0 + max(own, degree)) for one, degree in degrees.items()},
            dict.fromkeys(out, 1.0 / (1.0 + len(out))),
        )

    def has_round(self) -> bool:
        """Return whether messages of all in-neighbors are there; in asynchronous mode always True."""
        return self.is_asynchronous or self.communicator.has_round(self.in_neighbors)

    def collect(self) -> dict[int, Any]:
        """End the round: return what is there of it, by neighbor."""
        if self.is_asynchronous:
            return self.neighbors_receive_asynchronous()
        complete = self.communicator.has_round(self.in_neighbors)
        data = self.communicator.collect(self.in_neighbors)
        if not complete:
            # others may have gone on without this agent
            self.communicator.catch_up()
        return data

    def receive(self, event: threading.Event | None = None, timeout: float | None = None) -> dict[int, Any]:
        """End the round, waiting for it where rounds are in lock step."""
        if self.is_asynchronous:
            return self.neighbors_receive_asynchronous()
        return self.communicator.neighbors_receive(self.in_neighbors, stop_event=event, timeout=timeout)

    def needed_problem(self, who: str) -> Any:
        """Return the problem.

        Raises:
            StateError: If there is none.
        """
        if self.problem is None:
            raise StateError(f"agent {self.id}: {who} needs its part of the problem: call set_problem before")
        return self.problem
