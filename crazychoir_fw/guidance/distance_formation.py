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
from crazychoir_fw.guidance.velocity_feedback import VelocityFeedback, checked_gain

Array = NDArray[np.float64]


class FormationControl(VelocityFeedback):
    """Drones take distances to their neighbors; leaders, if there are any, fly trajectories."""

    def __init__(
        self,
        agent_id: int,
        communicator: TopicCommunicator,
        *,
        formation: ArrayLike | None = None,
        weights: ArrayLike | None = None,
        k: float = 0.1,
        keeps_height: bool = False,
        **options: Any,
    ) -> None:
        """Prepare.

        Args:
            agent_id: Number of this drone, that of the communicator.
            communicator: Carries poses to and from neighbors.
            formation: Places of all, of which the distances count (m), shape (N, 3). Its heights are those of the
                take-off, because drones that hover at one height have no way to leave it: all their errors lie in
                the plane.
            weights: In place of it: the distances to all (m), those of others than neighbors zero, shape (N,).
            k: Gain (1/(m^2 s)).
            keeps_height: Stay at the height of the take-off; distances count in the plane then.
            options: Further arguments of `VelocityFeedback`.

        Raises:
            RangeError: If a value is outside its range, or there is neither formation nor weights.
        """
        super().__init__(agent_id, communicator, **options)
        self.k = checked_gain(agent_id, k)
        self.keeps_height = keeps_height
        self._takeoff_height = self.height
        self._distances = self._own_distances(formation, weights)

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
        pairs: Whose distances count.

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
