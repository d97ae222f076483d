"""Partition of requests among drones: a linear program whose columns are routes, and the search for whole numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from crazychoir_fw.guidance.optimization import DistributedSimplex, LinearProblem
from crazychoir_fw.guidance.schemes.delivery.routes import Route

_WHOLE = 1e-6  # by which a value may miss 0 or 1
_ENOUGH = 1e-5  # [m], which a better solution must be worth

Routes = Mapping[frozenset[int], Route]
"""Routes of one agent by the numbers of what they serve."""

_Branch = tuple[int, int, bool]
"""An agent, a request, and whether that agent serves it."""

_Column = tuple[float, int, frozenset[int], float]
"""Value, agent, what it serves, cost."""


def partition_problem(agent: int, agents: int, slots: int, routes: Routes) -> LinearProblem:
    """Return one agent's part: it takes one of its routes, and each request is on one route.

    Args:
        agent: Its number, [0, agents - 1].
        agents: How many there are.
        slots: How many requests there are.
        routes: Its routes.
    """
    columns = np.zeros((agents + slots, len(routes)))
    for k, numbers in enumerate(routes):
        columns[agent, k] = 1.0
        columns[[agents + number for number in numbers], k] = 1.0
    return LinearProblem([route.cost for route in routes.values()], columns, np.ones(agents + slots))


class Partition:
    """The search for whole numbers, which every agent does alike: all have the same basis after each optimization.

    Where a basis is fractional, the search branches on whether an agent serves a request, depth first, and leaves out
    what cannot be better than what it has (branch and bound).
    """

    def __init__(self, agents: int, slots: int, most_stages: int = 60) -> None:
        """Begin.

        Args:
            agents: How many agents there are.
            slots: How many requests there are.
            most_stages: After so many optimizations, take the best that was found.
        """
        self.agents = agents
        self.slots = slots
        self.most_stages = most_stages
        self.stages = 0
        """How many optimizations were made use of."""
        self.bound = 0.0
        """What all routes cost at least (m), were fractions of routes allowed."""
        self.chosen: dict[int, tuple[frozenset[int], float]] = {}
        """What each agent serves, and how long its route is (m), as far as is known."""
        self._best = math.inf  # cost of that, with the price of what is unserved
        self._branch: tuple[_Branch, ...] = ()  # the node whose optimum comes next
        self._waiting: list[tuple[_Branch, ...]] = []

    def routes_left(self, agent: int, routes: Routes) -> Routes:
        """Return what an agent may choose from in the next optimization."""
        left = dict(routes)
        for who, number, serves in self._branch:
            must = serves and who == agent
            if serves or who == agent:
                left = {numbers: route for numbers, route in left.items() if (number in numbers) == must}
        return left

    def take(self, simplex: DistributedSimplex) -> bool:
        """Take over a basis; True if the search is over."""
        routes = self._routes_of(simplex)
        if self.stages == 0:
            self.bound = float(sum(value * cost for value, _, _, cost in routes))
        self.stages += 1
        if self._best - simplex.J > _ENOUGH:
            split = self._split(routes)
            if split is None or not self.chosen:
                # where it is fractional, better than nothing
                self.chosen = {agent: (numbers, cost) for value, agent, numbers, cost in routes if value > 0.5}
            if split is None:
                self._best = simplex.J
            else:
                self._waiting += [(*self._branch, (*split, False)), (*self._branch, (*split, True))]
        if not self._waiting or self.stages >= self.most_stages:
            return True
        self._branch = self._waiting.pop()
        return False

    def _routes_of(self, simplex: DistributedSimplex) -> list[_Column]:
        found = []
        for column, value in zip(simplex.B.T, simplex.x_basic, strict=True):
            doers = np.flatnonzero(column[1 : self.agents + 1])
            numbers = frozenset(np.flatnonzero(column[self.agents + 1 :]).tolist())
            # an agent without a column of its own in the basis is represented by an artificial one
            is_artificial = not numbers and column[0] == simplex.big_M
            if value > _WHOLE and doers.size == 1 and not is_artificial:
                found.append((float(value), int(doers[0]), numbers, float(column[0])))
        return found

    def _split(self, routes: list[_Column]) -> tuple[int, int] | None:
        """Return an agent and a request that is served by it in part, most of all; None if there is none."""
        shares: dict[tuple[int, int], float] = {}
        for value, agent, numbers, _ in routes:
            for number in numbers:
                shares[agent, number] = shares.get((agent, number), 0.0) + value
        # rounded, so that all agents agree on which are equal
        parts = {pair: round(share, 6) for pair, share in shares.items() if _WHOLE < share < 1.0 - _WHOLE}
        return max(parts, key=lambda pair: (parts[pair], -pair[0], -pair[1]), default=None)
