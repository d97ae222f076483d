"""`Containment`: followers gather among leaders (docs/reference/crazychoir.md#17.4).

Leaders stay or fly trajectories; followers ask for the velocity

    u_i = sum over neighbors j of k (p_j - p_i)

and come to rest where each is in the middle of its neighbors: at -L_ff^-1 L_fl times the places of the leaders, which
lies within their convex hull.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.graph import Graph, RandomEdges
from crazychoir_fw.guidance.velocity_feedback import VelocityFeedback, checked_gain

Array = NDArray[np.float64]

_DRAW_S = 0.1  # how long a draw of random edges holds [s]


class Containment(VelocityFeedback):
    """Followers fly to the middle of their neighbors, leaders where they want."""

    def __init__(
        self,
        agent_id: int,
        communicator: TopicCommunicator,
        *,
        k: float = 0.1,
        heights: ArrayLike | None = None,
        **options: Any,
    ) -> None:
        """Prepare.

        Args:
            agent_id: Number of this drone, that of the communicator.
            communicator: Carries poses to and from neighbors.
            k: Gain (1/s).
            heights: Of the take-off of each drone (m), shape (N,); None: `height` for all. Leaders at several heights
                span a hull with a volume.
            options: Further arguments of `VelocityFeedback`.

        Raises:
            RangeError: If a value is outside its range.
        """
        super().__init__(agent_id, communicator, **options)
        self.k = checked_gain(agent_id, k)
        self._takeoff_height = self.height
        if heights is not None:
            row = np.asarray(heights, dtype=np.float64)
            if row.shape != (communicator.size,) or not (np.isfinite(row).all() and (row > 0.0).all()):
                raise RangeError(
                    f"agent {agent_id}: heights are {heights}, allowed: {communicator.size} numbers above 0 m"
                )
            self._takeoff_height = float(row[agent_id])

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

    def __init__(
        self,
        agent_id: int,
        communicator: TopicCommunicator,
        *,
        graph: Graph,
        edge_prob: float = 0.8,
        seed: int = 0,
        update_frequency: float = 100.0,
        **options: Any,
    ) -> None:
        """Prepare.

        Args:
            agent_id: Number of this drone, that of the communicator.
            communicator: Carries poses to and from neighbors.
            graph: All edges that there may be.
            edge_prob: Of an edge to be there, [0, 1].
            seed: Of the draws, the same for all.
            update_frequency: Rounds per second (Hz); a draw holds for 0.1 s, or one round.
            options: Further arguments of `Containment`.

        Raises:
            RangeError: If a value is outside its range.
        """
        rounds = max(1, round(_DRAW_S * update_frequency))
        options["schedule"] = RandomEdges(graph, edge_prob, seed, rounds)
        super().__init__(agent_id, communicator, update_frequency=update_frequency, **options)


ContainmentGuidance = Containment
TimeVaryingContainmentGuidance = TimeVaryingContainment
"""Their names in ChoiRbot."""


def equilibrium(graph: Graph, leaders: Iterable[int], positions: ArrayLike) -> Array:
    """Return where all end up, given where the leaders are.

    Args:
        graph: Who hears whom.
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


def distance_from_hull(point: ArrayLike, corners: ArrayLike) -> float:
    """Return how far a point is from the convex hull of others (m); zero inside.

    Args:
        point: Shape (3,).
        corners: Shape (L, 3), any number of them, also in one plane or line.
    """
    return float(np.linalg.norm(_nearest(np.asarray(corners, np.float64) - np.asarray(point, np.float64))))


def _nearest(corners: Array) -> Array:
    """Return the point of a convex hull that is nearest to the origin, shape (3,) (Wolfe's algorithm)."""
    scale = max(1e-12, float(np.abs(corners).max()))
    points = corners / scale
    chosen = [int(np.argmin(np.einsum("ij,ij->i", points, points)))]
    weights = np.ones(1)
    for _ in range(100 * len(points)):
        nearest = weights @ points[chosen]
        ahead = int(np.argmin(points @ nearest))
        if ahead in chosen or nearest @ nearest - points[ahead] @ nearest < 1e-14:
            break
        chosen, weights = [*chosen, ahead], np.append(weights, 0.0)
        while True:
            flat = _flat_weights(points[chosen])
            if (flat > 1e-14).all():
                weights = flat
                break
            # as far towards the nearest point of the plane as the hull goes
            inward = flat <= 1e-14
            share = np.min(weights[inward] / np.maximum(weights[inward] - flat[inward], 1e-300))
            weights = weights + min(1.0, share) * (flat - weights)
            kept = weights > 1e-14
            chosen = [corner for corner, keep in zip(chosen, kept, strict=True) if keep]
            weights = weights[kept] / weights[kept].sum()
    return scale * (weights @ points[chosen])


def _flat_weights(points: Array) -> Array:
    """Return the weights, adding up to one, of the point nearest to the origin in the plane through some points."""
    count = len(points)
    system = np.ones((count + 1, count + 1))
    system[:count, :count] = points @ points.T
    system[count, count] = 0.0
    right = np.append(np.zeros(count), 1.0)
    return np.linalg.lstsq(system, right, rcond=None)[0][:count]
