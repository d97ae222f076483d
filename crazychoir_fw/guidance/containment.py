"""`Containment`: followers gather among leaders (docs/reference/crazychoir.md#17.4).

Leaders stay or fly trajectories; followers ask for the velocity

    u_i = sum over neighbors j of k (p_j - p_i)

and come to rest where each is in the middle of its neighbors: at -L_ff^-1 L_fl times the places of the leaders, which
lies within their convex hull.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.formation_metrics import ShapeMetrics, leaders_at
from crazychoir_fw.guidance.graph import Graph, NeighborSchedule, RandomEdges
from crazychoir_fw.guidance.law import LawContext, Needs, option
from crazychoir_fw.guidance.metrics import Flown
from crazychoir_fw.guidance.velocity_feedback import VelocityFeedback

Array = NDArray[np.float64]

_DRAW_S = 0.1  # how long a draw of random edges holds [s]


class ContainmentMetrics(ShapeMetrics):
    """Followers shall rest in the middle of their neighbors, among the leaders."""

    curve_label, curve_limit = "distance from its place (m)", "position_error_m"

    def errors(self, flown: Flown) -> Array:
        """Return how far each follower is from where the leaders of the moment want it (m), shape (T, followers)."""
        # the places of followers are linear in those of leaders: one matrix serves all times
        graph, leaders, followers = self.context.graph, list(self.context.leaders), self.context.followers
        unit = np.zeros((graph.size, graph.size))
        unit[leaders, leaders] = 1.0
        try:
            share = np.array([equilibrium(graph, leaders, unit[:, [k]])[:, 0] for k in leaders]).T[followers]
        except RangeError:
            return np.full((len(flown.at), len(followers)), np.nan)
        errors = np.linalg.norm(flown.at[:, followers] - share @ flown.at[:, leaders], axis=2)
        return np.where(flown.up[:, followers] & flown.up[:, leaders].all(axis=1, keepdims=True), errors, np.nan)

    def places(self, at: Array, wanted: Array) -> Array:
        """Return the commanded places of leaders, and the equilibrium of followers for them."""
        places = leaders_at(self.context.leaders, at, wanted)
        with contextlib.suppress(np.linalg.LinAlgError, RangeError):
            return equilibrium(self.context.graph, self.context.leaders, places)
        return places


class Containment(VelocityFeedback):
    """Followers fly to the middle of their neighbors, leaders where they want."""

    needs = Needs(graph=True, leaders=True, planning_of_leaders=True, formation=False)
    metrics = ContainmentMetrics

    k: float = option(0.1, "gain", "1/s", above=0)
    heights: Any = option(
        None, "height of each drone after its take-off, shape (N,), so that leaders span a volume; None: height", "m"
    )

    def __init__(self, agent_id: int, communicator: TopicCommunicator, **options: Any) -> None:
        """Prepare; arguments and errors are those of `RoundGuidance`."""
        super().__init__(agent_id, communicator, **options)
        self._takeoff_height, heights = self.height, self.heights
        if heights is not None:
            row = np.asarray(heights, dtype=np.float64)
            if row.shape != (communicator.size,) or not (np.isfinite(row).all() and (row > 0.0).all()):
                raise RangeError(
                    f"agent {agent_id}: heights are {heights}, allowed: {communicator.size} numbers above 0 m"
                )
            self._takeoff_height = float(row[agent_id])

    @classmethod
    def check(cls, context: LawContext) -> None:
        """Refuse followers that no leader reaches."""
        reached = context.graph.reachable(context.leaders)
        if lonely := [context.names[i] for i in context.members if i not in reached]:
            raise RangeError(f"no way leads from a leader to {', '.join(lonely[:5])}; see layers.communication.graph")

    @property
    def takeoff_height(self) -> float:
        """Where the take-off ends (m)."""
        return self._takeoff_height

    def evaluate_input(self, neigh_data: dict[int, Pose]) -> Array:
        """Return the velocity (m/s, world), shape (3,)."""
        return self.k * self.offsets(neigh_data).sum(axis=0)


class TimeVaryingContainment(Containment):
    """Containment where each edge is there for a part of the time only, drawn at random.

    Both ends of an edge draw with the same seed, so that they agree without a word; in the original each end draws for
    itself and tells the other, so that its edges are there with the square of the probability.
    """

    edge_prob: float = option(0.8, "probability of an edge to be there", low=0, high=1)
    seed: int = option(0, "seed of the draws, the same for all agents", low=0)

    def __init__(self, agent_id: int, communicator: TopicCommunicator, *, graph: Graph, **options: Any) -> None:
        """Prepare.

        Args:
            agent_id: Number of this drone, that of the communicator.
            communicator: Carries poses to and from neighbors.
            graph: All edges that there may be; of those, the agent uses the ones that its communicator knows.
            options: Further options of the class; a draw holds for 0.1 s, or one round.

        Raises:
            RangeError: If a value is outside its range.
        """
        super().__init__(agent_id, communicator, **options)
        rounds = max(1, round(_DRAW_S * self.update_frequency))
        self.schedule = _OwnEdges(RandomEdges(graph, self.edge_prob, self.seed, rounds), communicator)


class _OwnEdges:
    """Of the neighbors that a schedule has, those that a communicator knows."""

    def __init__(self, schedule: NeighborSchedule, communicator: TopicCommunicator) -> None:
        self._schedule, self._communicator = schedule, communicator

    def neighbors_at(self, agent: int, now: float, label: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
        heard, hearers = self._schedule.neighbors_at(agent, now, label)
        known = self._communicator
        return (
            tuple(one for one in heard if one in known.in_neighbors),
            tuple(one for one in hearers if one in known.out_neighbors),
        )


ContainmentGuidance = Containment
TimeVaryingContainmentGuidance = TimeVaryingContainment
"""Their names in ChoiRbot."""


def equilibrium(graph: Graph, leaders: Iterable[int], positions: ArrayLike) -> Array:
    """Return where all end up, given where the leaders are.

    Args:
        graph: Edges from senders to receivers.
        leaders: Numbers of the leaders.
        positions: Where all are (m), of which only those of leaders count, shape (N, 3).

    Returns:
        Positions (m), shape (N, 3).

    Raises:
        RangeError: If a follower hears no leader, not even through others.
    """
    leaders = sorted(leaders)
    graph.check_rooted(leaders)
    followers = [i for i in range(graph.size) if i not in leaders]
    hears = graph.adjacency.T
    laplacian = np.diag(hears.sum(axis=1)) - hears
    places = np.array(positions, dtype=np.float64)
    right = -laplacian[np.ix_(followers, leaders)] @ places[leaders]
    places[followers] = np.linalg.solve(laplacian[np.ix_(followers, followers)], right)
    return places
