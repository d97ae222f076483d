"""Aggregative gradient tracking in lock step that stays right when agents leave, and when they come back.

The tracked means are right as long as what one agent takes from another, the other gives. So two agents mix only in
rounds in which both say that they hear each other, and each remembers what it has taken from each neighbor: when one
leaves, its neighbors take back what they had exchanged with it, and the means are those of the agents that are left.
The agent that takes back begins a new session of that link. Its neighbor, if it still runs, does the same when it
receives the new session number. With all agents present the numbers are those of `AggregativeTracking`, to the last
bit.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.guidance.optimization.agent import Agent
from crazychoir_fw.guidance.optimization.aggregative_tracking import AggregativeTracking

Array = NDArray[np.float64]


class ResilientAggregativeTracking(AggregativeTracking):
    """`AggregativeTracking` for undirected graphs with equal weights both ways, whose agents may come and go.

    `leave` says that a neighbor is gone, `rejoin` that it is back. A round ends when messages of all neighbors that are
    not gone have arrived. If a round ends without one, the caller must call `leave` for that neighbor. Both are called
    between rounds only.
    """

    def __init__(
        self,
        agent: Agent,
        initial_condition: ArrayLike,
        enable_log: bool = False,
        *,
        stepsize: float = 1e-3,
        session: int = 0,
    ) -> None:
        """Begin; further arguments and errors are those of `AggregativeTracking`.

        Args:
            agent: The agent that runs it.
            initial_condition: Own decision at the begin, shape (n,).
            enable_log: Remember the result of every round.
            stepsize: The step alpha.
            session: A number that grows with each restart of an agent, such as the time (ms): so neighbors notice it.
        """
        super().__init__(agent, initial_condition, enable_log, stepsize=stepsize)
        self._sessions = dict.fromkeys(agent.all_in_neighbors, session)
        self._taken = {one: np.zeros((2, self.x.size)) for one in agent.all_in_neighbors}
        self._gone: set[int] = set()

    @property
    def gone(self) -> frozenset[int]:
        """Neighbors that have left."""
        return frozenset(self._gone)

    def leave(self, neighbors: Iterable[int]) -> None:
        """Go on without some neighbors, as if they had never been there."""
        for one in neighbors:
            if one not in self._gone:
                self._gone.add(one)
                self._take_back(one, self._sessions[one] + 1)

    def rejoin(self, neighbors: Iterable[int]) -> None:
        """Count on some neighbors again, from the next round on."""
        self._gone.difference_update(neighbors)

    def _take_back(self, one: int, session: int) -> None:
        self._sessions[one] = session
        self.s, self.y = self.s - self._taken[one][0], self.y - self._taken[one][1]
        self._taken[one] = np.zeros_like(self._taken[one])

    def _message(self) -> tuple[Array, tuple[tuple[int, int, bool], ...]]:
        links = tuple((one, session, one not in self._gone) for one, session in self._sessions.items())
        return np.stack([self.s, self.y]), links

    def _update(self, received: Mapping[int, Any]) -> None:
        mixed, renewed = {}, {}
        for one, message in received.items():
            said = self._read(message)
            if said is None:
                continue
            values, session, counts_on_me = said
            if session > self._sessions[one]:
                renewed[one] = session
            elif session == self._sessions[one] and counts_on_me and one not in self._gone:
                mixed[one] = values
        own = np.stack([self.s, self.y])
        for one, values in mixed.items():
            self._taken[one] = self._taken[one] + self.agent.in_weights[one] * (values - own)
        super()._update(mixed)
        # after mixing: the neighbors mix with what was sent
        for one, session in renewed.items():
            self._take_back(one, session)

    def _read(self, message: Any) -> tuple[Array, int, bool] | None:
        """Return what a neighbor says of its means, the session of the link, and whether it counts on this agent."""
        try:
            values, links = message
            values, own = np.asarray(values, np.float64), [link for link in links if link[0] == self.agent.id]
            ((_, session, counts_on_me),) = own
        except (TypeError, ValueError, IndexError):
            return None
        if values.shape != (2, self.x.size) or not np.isfinite(values).all() or not isinstance(session, int):
            return None
        return values, session, bool(counts_on_me)
