"""Neighbors of each agent, for safety filters (docs/reference/crazychoir.md#9)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.onboard.arrays import doubles, filled_by_core

Array = NDArray[np.float64]

_MAX_DENSE = 64  # agents, up to which all pairs are looked at: faster than sorting into cells
_OFFSETS = ((1, -1), (1, 0), (1, 1), (0, 1))  # half of a cell's neighbors, so that no pair comes twice


class ClosestRobotGetter:
    """Finds for every agent the others within a distance, nearest first.

    Distances are horizontal, as those of the filters: a drone above another is near it. An agent whose position is
    unknown (nan) has no neighbors.
    """

    def __init__(self, sensing_distance: float = 3.0) -> None:
        """Choose the distance (m).

        Raises:
            RangeError: If it is not above zero.
        """
        if not 0.0 < sensing_distance < np.inf:
            raise RangeError(f"sensing_distance is {sensing_distance}, allowed: above 0 m")
        self.sensing_distance = float(sensing_distance)

    def pairs(self, positions: ArrayLike) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
        """Return all pairs that are nearer than the sensing distance.

        Args:
            positions: Where they are (m), shape (N, 2) or (N, 3).

        Returns:
            First agents, second agents and distances (m), each of shape (P,); each pair once.
        """
        plane = np.asarray(positions, dtype=np.float64)[:, :2]
        if len(plane) <= _MAX_DENSE:
            first, second = np.triu_indices(len(plane), 1)
        else:
            first, second = self._near_cells(plane)
        distance = np.hypot(*(plane[first] - plane[second]).T)
        near = distance < self.sensing_distance
        return first[near], second[near], distance[near]

    def _near_cells(self, plane: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return pairs of agents in the same or adjacent cells of a grid."""
        known = np.flatnonzero(np.all(np.isfinite(plane), axis=1))
        if not known.size:
            return known, known
        cells = np.floor((plane[known] - plane[known].min(axis=0)) / self.sensing_distance).astype(np.int64)
        width = int(cells[:, 1].max()) + 3  # room for neighbors beyond either edge
        keys = cells[:, 0] * width + cells[:, 1] + 1
        order = np.argsort(keys, kind="stable")
        ordered = keys[order]
        firsts, seconds = [], []
        for step in (0, *(dx * width + dy for dx, dy in _OFFSETS)):
            # within the own cell, only agents that come later in order
            begin = np.searchsorted(ordered, ordered + step) if step else np.arange(1, len(ordered) + 1)
            count = np.searchsorted(ordered, ordered + step, side="right") - begin
            one = np.repeat(np.arange(len(ordered)), count)
            within = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
            firsts.append(one)
            seconds.append(np.repeat(begin, count) + within)
        first, second = np.concatenate(firsts), np.concatenate(seconds)
        return known[order[first]], known[order[second]]

    def neighbors(self, positions: ArrayLike) -> NDArray[np.integer]:
        """Return numbers of the neighbors of each agent, nearest first, padded with -1, shape (N, K)."""
        count = len(np.asarray(positions))
        if count <= _MAX_DENSE:
            return self._dense_neighbors(np.asarray(positions, dtype=np.float64))
        first, second, distance = self.pairs(positions)
        agents = np.concatenate([first, second])
        others = np.concatenate([second, first])
        order = np.lexsort([others, np.concatenate([distance, distance]), agents])
        agents, others = agents[order], others[order]
        counts = np.bincount(agents, minlength=count)
        table = np.full((count, int(counts.max(initial=0))), -1, dtype=np.intp)
        place = np.arange(len(agents)) - np.repeat(np.cumsum(counts) - counts, counts)
        table[agents, place] = others
        return table

    def _dense_neighbors(self, positions: Array) -> NDArray[np.int32]:
        """Return the same by the distances of all from all, faster than by a list of pairs for a few agents."""
        count, axes = positions.shape
        table = np.empty((count, max(count - 1, 0)), np.int32)
        near = lib.cf_find_nearby(
            count,
            axes,
            doubles(positions, positions.shape),
            self.sensing_distance,
            filled_by_core(np.empty(count)),
            ffi.from_buffer("int32_t[]", table, require_writable=True),
        )
        return table[:, :near]

    def closest(self, poses: Pose) -> list[dict[int, Pose]]:
        """Return for each agent the poses of the others near it, nearest first.

        Args:
            poses: All poses, with positions (m) of shape (N, 3).
        """
        table = self.neighbors(_positions(poses))
        singles = [_single(poses, i) for i in range(len(table))]
        return [{int(j): singles[j] for j in row if j >= 0} for row in table]

    def gathered(self, poses: Pose) -> Pose:
        """Return poses of the neighbors as arrays for the filters: shape (N, K, 3), padded with nan."""
        position = _positions(poses)
        table = np.ascontiguousarray(self.neighbors(position), np.int32)
        if poses.velocity is None:
            return Pose(position=_gathered(position, table))
        return Pose(position=_gathered(position, table), velocity=_gathered(np.asarray(poses.velocity, float), table))


def _gathered(vectors: Array, table: NDArray[np.int32]) -> Array:
    """Return vectors of the agents in a table (N, K), shape (N, K, axes); nan for -1."""
    (count, near), axes = table.shape, vectors.shape[1]
    values = np.empty((count, near, axes))
    cells = ffi.from_buffer("int32_t[]", table)
    lib.cf_gather_nearby(count, axes, doubles(vectors, vectors.shape), cells, near, near, filled_by_core(values))
    return values


def stacked(neighbors: dict[int, Pose]) -> Pose:
    """Return the poses of one agent's neighbors as arrays for the filters, shape (K, 3)."""
    poses = list(neighbors.values())
    position = np.array([_positions(pose) for pose in poses], dtype=np.float64).reshape(len(poses), 3)
    if any(pose.velocity is None for pose in poses):
        return Pose(position=position)
    velocity = np.array([pose.velocity for pose in poses], dtype=np.float64).reshape(len(poses), 3)
    return Pose(position=position, velocity=velocity)


def _positions(poses: Pose) -> Array:
    if poses.position is None:
        raise RangeError("pose has no position, allowed: where everybody is (m)")
    return np.asarray(poses.position, dtype=np.float64)


def _single(poses: Pose, i: int) -> Pose:
    velocity = None if poses.velocity is None else poses.velocity[i]
    return Pose(position=_positions(poses)[i], velocity=velocity, time=poses.time)
