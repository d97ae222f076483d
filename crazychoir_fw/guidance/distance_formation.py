"""`FormationControl`: a formation given by the distances between neighbors (docs/reference/crazychoir.md#17.4).

Each drone asks for the velocity

    u_i = sum over neighbors j of k (|e_ij|^2 - w_ij^2) e_ij,    e_ij = p_j - p_i

which descends on the sum of k/4 (|e_ij|^2 - w_ij^2)^2 over all edges. Without leaders the middle of the formation stays
where it is; where it is, how it is turned, and whether it is mirrored, no distance says.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.formation_metrics import ShapeMetrics
from crazychoir_fw.guidance.law import LawContext, Needs, option
from crazychoir_fw.guidance.metrics import Flown, Metrics, criterion
from crazychoir_fw.guidance.velocity_feedback import VelocityFeedback

Array = NDArray[np.float64]


class DistanceMetrics(ShapeMetrics):
    """Neighbors shall be as far apart as their places; heights count unless the law keeps them."""

    curve_label, curve_limit = "error of distances (m)", "distance_error_m"

    @classmethod
    def of(cls, context: LawContext) -> Metrics | None:
        """See `Metrics`."""
        return None if context.formation is None else cls(context)

    def shape_errors(self, at: Array) -> Array:
        """Return the signed errors of all distances (m), shape (..., pairs)."""
        places: Any = self.context.formation
        flat = np.array([1.0, 1.0, 0.0]) if self.context.option("keeps_height", False) else 1.0
        return distance_errors(at * flat, places * flat, list(self.pairs))

    def errors(self, flown: Flown) -> Array:
        """Return the errors of all distances over time (m), shape (T, pairs)."""
        return np.where(self.fly_together(flown), np.abs(self.shape_errors(flown.at)), np.nan)

    @criterion("the largest distance error", "m")
    def distance_error_m(self, flown: Flown) -> float:
        """Return the largest error at the end (m)."""
        if flown.final is None:
            return np.nan
        errors = np.abs(self.shape_errors(flown.final_positions))[self.counted_pairs(flown)]
        return float(np.max(errors)) if len(errors) else np.nan

    def places(self, at: Array, wanted: Array) -> Array:
        """Return the formation where it fits best."""
        return fitted(self.context.formation, at)  # type: ignore[arg-type]


class FormationControl(VelocityFeedback):
    """Drones take distances to their neighbors; leaders, if there are any, fly trajectories."""

    needs = Needs(graph=True, planning_of_leaders=True, formation=True, formation_or="weights")
    metrics = DistanceMetrics

    formation: Any = option(None, "places whose distances count, shape (N, 3)", "m")
    weights: Any = option(None, "in place of it, the distances to all agents, shape (N,)", "m", kind=list[float])
    k: float = option(0.1, "gain", "1/(m^2 s)", above=0)
    keeps_height: bool = option(False, "whether drones stay at their heights")

    def __init__(self, agent_id: int, communicator: TopicCommunicator, **options: Any) -> None:
        """Prepare; arguments and errors are those of `RoundGuidance`, one of formation and weights is needed."""
        super().__init__(agent_id, communicator, **options)
        self._takeoff_height = self.height
        self._distances = self._own_distances(self.formation, self.weights)

    def _own_distances(self, formation: ArrayLike | None, weights: ArrayLike | None) -> dict[int, float]:
        who, size = f"agent {self.agent_id}", self.communicator.size
        if (formation is None) == (weights is None):
            raise RangeError(f"{who}: give one of formation and weights")
        if formation is not None:
            places = np.asarray(formation, dtype=np.float64)
            if places.shape != (size, 3) or not np.isfinite(places).all():
                raise RangeError(f"{who}: formation has shape {places.shape}, allowed: ({size}, 3), finite")
            self._takeoff_height = max(float(places[self.agent_id, 2]), 1e-3)
            offsets = places - places[self.agent_id]
            if self.keeps_height:
                offsets[:, 2] = 0.0
            row = np.linalg.norm(offsets, axis=1)
        else:
            row = np.asarray(weights, dtype=np.float64)
            if row.shape != (size,) or not np.isfinite(row).all():
                raise RangeError(f"{who}: weights have shape {row.shape}, allowed: ({size},), finite")
        wanted = {neighbor: float(row[neighbor]) for neighbor in self.communicator.in_neighbors}
        for neighbor, distance in wanted.items():
            if not distance > 0.0:
                raise RangeError(f"{who}: the distance to agent {neighbor} is {distance}, allowed: above 0 m")
        return wanted

    @property
    def takeoff_height(self) -> float:
        """Where the take-off ends (m): at its place in the formation."""
        return self._takeoff_height

    def evaluate_input(self, neigh_data: dict[int, Pose]) -> Array:
        """Return the velocity (m/s, world), shape (3,)."""
        offsets = self.offsets(neigh_data)
        if self.keeps_height:
            offsets[:, 2] = 0.0
        wanted = np.array([self._distances[neighbor] for neighbor in neigh_data])
        return self.k * ((np.einsum("ij,ij->i", offsets, offsets) - wanted**2) @ offsets)


FormationControlGuidance = FormationControl
"""Its name in ChoiRbot."""


def distance_errors(positions: ArrayLike, formation: ArrayLike, pairs: Sequence[tuple[int, int]]) -> Array:
    """Return how far distances are from those of a formation (m).

    Args:
        positions: Where drones are (m), shape (..., N, 3).
        formation: Where they shall be to each other (m), shape (N, 3).
        pairs: Pairs of drones whose distances count.

    Returns:
        Distance minus desired distance, shape (..., pairs).
    """
    at, places = np.asarray(positions, dtype=np.float64), np.asarray(formation, dtype=np.float64)
    i, j = np.array(pairs, int).reshape(-1, 2).T
    return np.linalg.norm(at[..., i, :] - at[..., j, :], axis=-1) - np.linalg.norm(places[i] - places[j], axis=-1)


def fitted(formation: ArrayLike, positions: ArrayLike) -> Array:
    """Return a formation moved, turned and if need be mirrored to where drones are (m), shape (N, 3).

    Args:
        formation: Places (m), shape (N, 3).
        positions: Where drones are (m), shape (N, 3).
    """
    places, at = np.asarray(formation, dtype=np.float64), np.asarray(positions, dtype=np.float64)
    middle, there = places.mean(axis=0), at.mean(axis=0)
    # the orthogonal matrix that fits best (Kabsch); mirrors are allowed, for distances do not see them
    u, _, vt = np.linalg.svd((places - middle).T @ (at - there))
    return (places - middle) @ (u @ vt) + there
