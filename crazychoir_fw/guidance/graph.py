"""Graphs of communication, fixed and changing (docs/reference/crazychoir.md#16 to #18 and #23)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError

Array = NDArray[np.float64]
Agent = int | str


@dataclass(frozen=True)
class Graph:
    """A directed graph of agents: an edge (i, j) says that what i sends, j hears."""

    size: int
    """Number of agents."""
    edges: tuple[tuple[int, int], ...]
    """Directed edges, sorted."""
    names: tuple[str, ...] = ()
    """Names of the agents for messages; empty: ``agent_0`` and so on."""
    _in: tuple[tuple[int, ...], ...] = field(init=False, repr=False, compare=False)
    _out: tuple[tuple[int, ...], ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        into: list[list[int]] = [[] for _ in range(self.size)]
        out: list[list[int]] = [[] for _ in range(self.size)]
        for sender, receiver in self.edges:
            out[sender].append(receiver)
            into[receiver].append(sender)
        object.__setattr__(self, "_in", tuple(tuple(sorted(one)) for one in into))
        object.__setattr__(self, "_out", tuple(tuple(sorted(one)) for one in out))

    # ---------------------------------------------------------------- to make one

    @classmethod
    def directed(cls, size: int, edges: Iterable[Sequence[Agent]], names: Sequence[str] = ()) -> Graph:
        """Return the graph with edges from first to second.

        Args:
            size: Number of agents.
            edges: Pairs of numbers, or of names where there are some.
            names: Names of the agents.

        Raises:
            RangeError: If an edge is no pair of two different agents; the message names it.
        """
        if not (isinstance(size, int) and size >= 1):
            raise RangeError(f"graph: size is {size}, allowed: 1 or more agents")
        if names and len(names) != size:
            raise RangeError(f"graph: there are {len(names)} names, allowed: one for each of {size} agents")
        numbers = {name: number for number, name in enumerate(names)}
        pairs = {_pair(edge, size, numbers) for edge in edges}
        return cls(size, tuple(sorted(pairs)), tuple(names))

    @classmethod
    def undirected(cls, size: int, edges: Iterable[Sequence[Agent]], names: Sequence[str] = ()) -> Graph:
        """Return the graph whose edges go both ways; arguments and errors as in `directed`."""
        one_way = cls.directed(size, edges, names)
        both = {pair for edge in one_way.edges for pair in (edge, edge[::-1])}
        return cls(size, tuple(sorted(both)), one_way.names)

    @classmethod
    def complete(cls, size: int) -> Graph:
        """Return the complete graph: every agent receives from every other."""
        return cls.undirected(size, [(i, j) for i in range(size) for j in range(i)])

    @classmethod
    def path(cls, size: int) -> Graph:
        """Return the undirected path 0, 1, ..., size - 1."""
        return cls.undirected(size, [(i, i + 1) for i in range(size - 1)])

    @classmethod
    def ring(cls, size: int, *, directed: bool = False) -> Graph:
        """Return the ring 0, 1, ..., size - 1, 0."""
        edges = [(i, (i + 1) % size) for i in range(size)] if size > 1 else []
        return cls.directed(size, edges) if directed else cls.undirected(size, edges)

    @classmethod
    def binomial(cls, size: int, probability: float, seed: int) -> Graph:
        """Return a connected undirected random graph, the same as DISROPT's for the seed.

        Each pair is drawn twice with the probability, until the graph is connected.

        Raises:
            RangeError: If the probability is outside (0, 1], or so small that 10,000 draws give no connected graph.
        """
        if not 0.0 < probability <= 1.0:
            raise RangeError(f"graph: probability is {probability}, allowed: above 0, at most 1")
        # the old generator of NumPy, for the same graphs by the same seeds; a state of its own, not the global one
        dice = np.random.RandomState(seed)
        for _ in range(10_000):
            drawn = dice.binomial(1, probability, (size, size)).astype(bool)
            graph = cls.from_adjacency(drawn | drawn.T)
            if graph.is_connected():
                return graph
        raise RangeError(f"graph: probability is {probability}, allowed: enough for a connected graph of {size} agents")

    @classmethod
    def from_adjacency(cls, matrix: ArrayLike) -> Graph:
        """Return the graph where j hears i if the entry (i, j) is not zero; the diagonal does not count."""
        matrix = np.asarray(matrix)
        return cls.directed(len(matrix), [(int(i), int(j)) for i, j in np.argwhere(matrix) if i != j])

    def without(self, agents: Iterable[int]) -> Graph:
        """Return the graph without the edges of some agents, which keep their numbers."""
        gone = set(agents)
        return Graph(self.size, tuple(edge for edge in self.edges if not gone & set(edge)), self.names)

    # ---------------------------------------------------------------- to ask

    def in_neighbors(self, agent: int) -> tuple[int, ...]:
        """Return the agents that an agent receives from."""
        return self._in[agent]

    def out_neighbors(self, agent: int) -> tuple[int, ...]:
        """Return the agents that receive from an agent."""
        return self._out[agent]

    def neighbors_at(self, agent: int, now: float, label: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Return in- and out-neighbors at a time and round: a graph is a schedule that never changes."""
        del now, label
        return self._in[agent], self._out[agent]

    def name(self, agent: int) -> str:
        """Return the name of an agent."""
        return self.names[agent] if self.names else f"agent_{agent}"

    @property
    def is_undirected(self) -> bool:
        """Whether every edge goes both ways."""
        edges = set(self.edges)
        return all(edge[::-1] in edges for edge in edges)

    @property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """Pairs (i, j), i < j, of which at least one hears the other."""
        return tuple(sorted({(min(edge), max(edge)) for edge in self.edges}))

    def reachable(self, sources: Iterable[int]) -> set[int]:
        """Return the agents that receive from the sources, directly or through others, and the sources."""
        seen = set(sources)
        ahead = list(seen)
        while ahead:
            for agent in self._out[ahead.pop()]:
                if agent not in seen:
                    seen.add(agent)
                    ahead.append(agent)
        return seen

    def is_connected(self) -> bool:
        """Return whether the graph is strongly connected: each agent hears all, directly or through others."""
        backward = Graph(self.size, tuple(edge[::-1] for edge in self.edges))
        return len(self.reachable([0])) == self.size == len(backward.reachable([0]))

    def check_connected(self) -> None:
        """Refuse a graph that is not strongly connected.

        Raises:
            RangeError: Naming agents that agent 0 does not reach, or that do not reach it.
        """
        backward = Graph(self.size, tuple(edge[::-1] for edge in self.edges))
        for graph, what in ((self, "is not reached from"), (backward, "does not reach")):
            if missing := sorted(set(range(self.size)) - graph.reachable([0])):
                raise RangeError(f"graph: {self.name(missing[0])} {what} {self.name(0)}, allowed: a connected graph")

    def check_rooted(self, leaders: Iterable[int]) -> None:
        """Refuse a graph where a follower hears no leader, not even through others.

        Raises:
            RangeError: Naming the followers.
        """
        leaders = list(leaders)
        if missing := sorted(set(range(self.size)) - self.reachable(leaders)):
            names = ", ".join(self.name(agent) for agent in missing)
            raise RangeError(f"graph: no way leads from a leader to {names}, allowed: every follower hears a leader")

    @property
    def adjacency(self) -> Array:
        """Matrix whose entry (i, j) is 1 where j hears i, shape (size, size)."""
        matrix = np.zeros((self.size, self.size))
        for i, j in self.edges:
            matrix[i, j] = 1.0
        return matrix

    def metropolis_hastings(self) -> Array:
        """Return doubly stochastic weights: 1/(1 + larger degree) on edges, the rest on the diagonal, (size, size).

        Raises:
            RangeError: If an edge goes one way only.
        """
        if not self.is_undirected:
            raise RangeError("graph: has edges of one direction, allowed: an undirected graph")
        degree = [len(one) for one in self._in]
        weights = np.zeros((self.size, self.size))
        for i, j in self.edges:
            weights[i, j] = 1.0 / (1.0 + max(degree[i], degree[j]))
        np.fill_diagonal(weights, 1.0 - weights.sum(axis=1))
        return weights


def _pair(edge: Sequence[Agent], size: int, numbers: dict[str, int]) -> tuple[int, int]:
    if isinstance(edge, str) or len(edge) != 2:
        raise RangeError(f"graph: edge {edge!r} is no pair of agents")
    ends = []
    for agent in edge:
        number = numbers.get(agent, agent) if isinstance(agent, str) else agent
        if isinstance(number, bool) or not isinstance(number, int | np.integer) or not 0 <= number < size:
            known = ", ".join(numbers) if numbers else f"0 to {size - 1}"
            raise RangeError(f"graph: edge {list(edge)} names {agent!r}, allowed: {known}")
        ends.append(int(number))
    if ends[0] == ends[1]:
        raise RangeError(f"graph: edge {list(edge)} goes from an agent to itself")
    return ends[0], ends[1]


# -------------------------------------------------------------------- graphs that change


class NeighborSchedule(Protocol):
    """Neighbors as they change. All agents must come to the same answer, or they wait for each other in vain."""

    def neighbors_at(self, agent: int, now: float, label: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Return in- and out-neighbors of an agent at a time (s), in the round of that label."""


class TimedGraphs:
    """Graphs one after the other."""

    def __init__(self, graphs: Sequence[tuple[float, Graph]], period: float | None = None) -> None:
        """Choose them.

        Args:
            graphs: Begin (s) and graph, in order; the first also holds before.
            period: After which the schedule repeats (s); None: the last graph stays.

        Raises:
            RangeError: If there is none, they are out of order, or the period is too short.
        """
        begins = [begin for begin, _ in graphs]
        if not begins or begins != sorted(begins):
            raise RangeError(f"graph: begins are {begins}, allowed: one or more, in order")
        if period is not None and not period > begins[-1]:
            raise RangeError(f"graph: period is {period}, allowed: above the last begin, {begins[-1]} s")
        self._begins = np.array(begins)
        self._graphs = [graph for _, graph in graphs]
        self._period = period

    def graph_at(self, now: float) -> Graph:
        """Return the graph of a time (s)."""
        at = now if self._period is None else now % self._period
        return self._graphs[max(0, int(np.searchsorted(self._begins, at, side="right")) - 1)]

    def neighbors_at(self, agent: int, now: float, label: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Return in- and out-neighbors of an agent at a time."""
        return self.graph_at(now).neighbors_at(agent, now, label)


class RandomEdges:
    """Each pair of neighbors keeps its edges with a probability, drawn again every few rounds."""

    def __init__(self, graph: Graph, probability: float, seed: int = 0, rounds: int = 1) -> None:
        """Choose them.

        Args:
            graph: The largest graph.
            probability: Of an edge to be there, [0, 1].
            seed: The same for all agents, so that both ends of an edge agree without a message.
            rounds: How many rounds a draw holds.

        Raises:
            RangeError: If a number is outside its range.
        """
        if not 0.0 <= probability <= 1.0:
            raise RangeError(f"graph: probability is {probability}, allowed: [0, 1]")
        if rounds < 1:
            raise RangeError(f"graph: rounds is {rounds}, allowed: 1 or more")
        self._graph = graph
        self._pairs = graph.pairs
        self._probability = probability
        self._seed = seed
        self._rounds = rounds
        self._drawn: tuple[int, Graph] = (-1, graph)

    def graph_at(self, label: int) -> Graph:
        """Return the graph of a round."""
        draw, graph = self._drawn
        if draw != label // self._rounds:
            draw = label // self._rounds
            kept = np.random.default_rng([self._seed, draw]).random(len(self._pairs)) < self._probability
            pairs = {pair for pair, keep in zip(self._pairs, kept, strict=True) if keep}
            edges = tuple(edge for edge in self._graph.edges if (min(edge), max(edge)) in pairs)
            graph = Graph(self._graph.size, edges, self._graph.names)
            self._drawn = (draw, graph)
        return graph

    def neighbors_at(self, agent: int, now: float, label: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Return in- and out-neighbors of an agent in a round."""
        return self.graph_at(label).neighbors_at(agent, now, label)


class WithinDistance:
    """Those of a graph's edges whose ends are near each other, as a radio of limited range has it.

    It needs the positions of all drones, which only the process that simulates them all has.
    """

    def __init__(self, graph: Graph, distance: float, positions: Callable[[], ArrayLike]) -> None:
        """Choose them.

        Args:
            graph: The largest graph.
            distance: Largest distance of neighbors (m).
            positions: Returns where all are (m), shape (N, 3).

        Raises:
            RangeError: If the distance is not above zero.
        """
        if not distance > 0.0:
            raise RangeError(f"graph: distance is {distance}, allowed: above 0 m")
        self._edges = np.array(graph.edges, int).reshape(-1, 2)
        self._graph = graph
        self._distance = distance
        self._positions = positions
        self._at = np.zeros((0, 3))
        self._near = graph

    def graph_now(self) -> Graph:
        """Return the graph of drones within the distance; it is made again only when positions change."""
        at = np.asarray(self._positions(), float)
        if not np.array_equal(at, self._at):
            apart = at[self._edges[:, 0]] - at[self._edges[:, 1]]
            near = np.linalg.norm(apart, axis=-1) <= self._distance  # false for positions of nan
            edges = tuple((int(i), int(j)) for i, j in self._edges[near])
            self._at, self._near = at.copy(), Graph(self._graph.size, edges, self._graph.names)
        return self._near

    def neighbors_at(self, agent: int, now: float, label: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Return in- and out-neighbors of an agent now."""
        return self.graph_now().neighbors_at(agent, now, label)


class SeveralSchedules:
    """Neighbors by several schedules, each for some of the agents."""

    def __init__(self, parts: Sequence[tuple[Sequence[int], NeighborSchedule]]) -> None:
        """Combine parts: the agents of each part in order, and a schedule that numbers them from 0."""
        self._parts = [(tuple(members), schedule) for members, schedule in parts]

    def neighbors_at(self, agent: int, now: float, label: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Return in- and out-neighbors of an agent, by any of the schedules."""
        into: set[int] = set()
        out: set[int] = set()
        for members, schedule in self._parts:
            if agent in members:
                heard, hearing = schedule.neighbors_at(members.index(agent), now, label)
                into.update(members[one] for one in heard)
                out.update(members[one] for one in hearing)
        return tuple(sorted(into)), tuple(sorted(out))
