"""Communication of a mission: its graphs, at rest and as they change, and its communicators."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw import guidance
from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.guidance.graph import (
    Graph,
    NeighborSchedule,
    RandomEdges,
    SeveralSchedules,
    TimedGraphs,
    WithinDistance,
)

if TYPE_CHECKING:
    from crazychoir_fw.mission.communication import Communication
    from crazychoir_fw.mission.schema import LayeredMission

Positions = Callable[[], NDArray[np.float64]]
"""Returns where all drones are (m, world), shape (N, 3)."""


def graph_of(mission: LayeredMission) -> Graph:
    """Return which drones hear which, among all and among those of each guidance: the largest graph, if it changes."""
    names = [drone.id for drone in mission.fleet]
    edges: set[tuple[int, int]] = set()
    for communication, numbers in _parts(mission):
        own = _largest(communication, [names[i] for i in numbers])
        edges |= {(numbers[i], numbers[j]) for i, j in own.edges}
    return Graph(len(names), tuple(sorted(edges)), tuple(names))


def schedule_of(
    mission: LayeredMission, begin: float = 0.0, positions: Positions | None = None
) -> NeighborSchedule | None:
    """Return the neighbors of a mission as they change, or None if they do not.

    Args:
        mission: The mission.
        begin: When the flight begins (s).
        positions: Where all drones are; None: unknown.

    Raises:
        MissionError: If positions are needed and unknown.
    """
    parts = _parts(mission)
    if not any(_changes(communication) for communication, _ in parts):
        return None
    names = [drone.id for drone in mission.fleet]
    return SeveralSchedules(
        [
            (numbers, _schedule(communication, [names[i] for i in numbers], numbers, begin, positions))
            for communication, numbers in parts
        ]
    )


def goes_by_distance(mission: LayeredMission) -> bool:
    """Return whether the graph depends on the distances between drones."""
    return any(
        getattr(communication.graph, "within_distance", None) is not None for communication, _ in _parts(mission)
    )


def _parts(mission: LayeredMission) -> list[tuple[Communication, list[int]]]:
    """Return each rule of communication, with the numbers of the drones that it applies to."""
    names = [drone.id for drone in mission.fleet]
    parts = [(mission.layers.communication, list(range(len(names))))]
    for layer in mission.layers.guidances:
        if layer.communication is not None:
            members = names if layer.drones is None else layer.drones
            parts.append((layer.communication, [names.index(name) for name in members]))
    return parts


def _changes(communication: Communication) -> bool:
    return getattr(communication.graph, "changes", False)


def _at_rest(chosen: Any, directed: bool, names: Sequence[str]) -> Graph:
    """Return a graph that does not change."""
    make = Graph.directed if directed else Graph.undirected
    count = len(names)
    if chosen == "complete":
        return Graph.undirected(count, [(i, j) for i in range(count) for j in range(i)], names)
    if isinstance(chosen, str):
        pairs = [(i, i + 1) for i in range(count - 1)]
        if chosen == "ring" and count > 2:
            pairs.append((count - 1, 0))
        return make(count, pairs, names)
    if isinstance(chosen, tuple):
        return make(count, chosen, names)
    if chosen.random is None:
        raise MissionError("layers.communication.graph: a graph that changes holds graphs that do not change")
    return Graph.binomial(count, chosen.random.probability, chosen.random.seed)


def _largest(communication: Communication, names: Sequence[str]) -> Graph:
    """Return all edges that there may ever be."""
    chosen, directed = communication.graph, communication.directed
    if not _changes(communication):
        return _at_rest(chosen, directed, names)
    if chosen.schedule is None:
        return _at_rest(chosen.of, directed, names)
    edges = {edge for one in chosen.schedule for edge in _at_rest(one.graph, directed, names).edges}
    return Graph(len(names), tuple(sorted(edges)), tuple(names))


def _schedule(
    communication: Communication, names: Sequence[str], numbers: list[int], begin: float, positions: Positions | None
) -> NeighborSchedule:
    chosen, largest = communication.graph, _largest(communication, names)
    if not _changes(communication):
        return largest
    if chosen.schedule is not None:
        graphs = [(one.at, _at_rest(one.graph, communication.directed, names)) for one in chosen.schedule]
        return _Since(TimedGraphs(graphs, chosen.period), begin)
    if chosen.random_edges is not None:
        drawn = chosen.random_edges
        return RandomEdges(largest, drawn.probability, drawn.seed, drawn.rounds)
    if positions is None:
        raise MissionError(
            "layers.communication.graph: within_distance needs everybody's position, which nobody knows here; take a "
            "schedule"
        )
    return WithinDistance(largest, chosen.within_distance, lambda: positions()[numbers])


class _Since:
    """A schedule whose time begins later."""

    def __init__(self, schedule: NeighborSchedule, begin: float) -> None:
        self._schedule, self._begin = schedule, begin

    def neighbors_at(self, agent: int, now: float, label: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
        return self._schedule.neighbors_at(agent, now - self._begin, label)


def disturbed(mission: LayeredMission, i: int, transport: Any, clock: Callable[[], float]) -> Any:
    """Return the transport of a drone: one that loses, delays and doubles what it hears, if the mission says so."""
    settings = mission.layers.communication_of(mission.fleet[i].id)
    if not settings.is_disturbed:
        return transport
    return guidance.DisturbedTransport(
        transport,
        clock=clock,
        loss=settings.loss,
        delay=settings.delay_s,
        jitter=settings.jitter_s,
        duplication=settings.duplication,
        seed=(mission.seed, i),
    )


def make_communicators(
    mission: LayeredMission,
    transport: Any,
    clock: Callable[[], float],
    only: Sequence[int] | None = None,
    schedule: NeighborSchedule | None = None,
) -> dict[int, Any]:
    """Return the communicators of drones, by number.

    Args:
        mission: The mission.
        transport: What they share.
        clock: Time by which rounds end (s).
        only: Which drones; None is all.
        schedule: Neighbors as they change.
    """
    graph = graph_of(mission)
    chosen = range(len(mission.fleet)) if only is None else only
    settings_of = {i: mission.layers.communication_of(mission.fleet[i].id) for i in chosen}
    return {
        i: guidance.TimeVaryingCommunicator(
            i,
            len(mission.fleet),
            graph.in_neighbors(i),
            graph.out_neighbors(i),
            settings.mode == "lockstep",
            settings.differentiated_topics,
            transport=disturbed(mission, i, transport, clock),
            deadline=settings.deadline_s,
            clock=clock,
            schedule=schedule,
        )
        for i, settings in settings_of.items()
    }


def statistics_of(agents: Sequence[Any]) -> dict[str, Any] | None:
    """Return what the communicators of a flight have seen, for summary.json: by drone, and in total.

    Args:
        agents: See `crazychoir_fw.flight.agent`.
    """
    found: dict[str, dict[str, Any]] = {}
    for agent in agents:
        communicator = getattr(agent.guidance, "communicator", None)
        if communicator is not None and communicator.in_neighbors + communicator.out_neighbors:
            found[agent.name] = dict(vars(communicator.statistics))
    if not found:
        return None
    total = {key: sum(one[key] for one in found.values()) for key in next(iter(found.values()))}
    for agent in agents:
        took = getattr(getattr(agent.guidance, "communicator", None), "round_ms", None)
        if took is not None:
            found[agent.name]["round_ms"] = took
    return {"total": total, **found}
