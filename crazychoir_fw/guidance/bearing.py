"""Geometry of bearing formations (docs/reference/crazychoir.md#8.2 and #23).

The bearing from i to j is g_ij = (d_j - d_i)/|d_j - d_i|, and P_ij = I - g_ij g_ij' takes away what lies along it. The
bearing Laplacian has the blocks -P_ij and, on its diagonal, their sums. Leaders stay; what followers do is decided by
their block of it: if it is regular, leaders and bearings leave them one formation.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.graph import Graph

Array = NDArray[np.float64]

_MIN_DISTANCE = 1e-3  # [m]: nearer than that, a bearing has no meaning
_SINGULAR = 1e-6  # relative to the largest singular value


def checked_formation(formation: ArrayLike) -> Array:
    """Return desired positions as an array (m), shape (N, 3).

    Raises:
        RangeError: If they are no finite (N, 3).
    """
    positions = np.asarray(formation, dtype=np.float64)
    if positions.ndim != 2 or positions.shape[1] != 3:
        raise RangeError(f"formation has shape {positions.shape}, allowed: (N, 3)")
    if not np.isfinite(positions).all():
        raise RangeError("formation holds numbers that are not finite")
    return positions


def bearing(own: ArrayLike, other: ArrayLike) -> Array:
    """Return the unit vector from one position to another, shape (..., 3).

    Args:
        own: Position (m), shape (..., 3).
        other: Position (m), shape (..., 3).

    Raises:
        RangeError: If they are nearer than 1 mm.
    """
    between = np.asarray(other, dtype=np.float64) - np.asarray(own, dtype=np.float64)
    distance = np.linalg.norm(between, axis=-1, keepdims=True)
    if not np.all(distance >= _MIN_DISTANCE):
        raise RangeError(f"positions are {float(np.min(distance)):.2g} m apart, allowed: at least {_MIN_DISTANCE} m")
    return between / distance


def projection(direction: ArrayLike) -> Array:
    """Return I - g g' of unit vectors (..., 3), shape (..., 3, 3)."""
    g = np.asarray(direction, dtype=np.float64)
    return np.eye(3) - g[..., :, None] * g[..., None, :]


def projections(formation: ArrayLike, agent: int, neighbors: Iterable[int]) -> dict[int, Array]:
    """Return P_ij of an agent, by neighbor.

    Raises:
        RangeError: If two places of the formation coincide; the message names the agents.
    """
    places = checked_formation(formation)
    result = {}
    for neighbor in neighbors:
        try:
            result[neighbor] = projection(bearing(places[agent], places[neighbor]))
        except RangeError as error:
            raise RangeError(f"formation of agents {agent} and {neighbor}: {error}") from error
    return result


def ort_proj(formation: ArrayLike, agent: int, neighbors: Iterable[int]) -> list[float]:
    """Return the parameter ``ort_proj`` of an agent: its 3 x 3N block row, flattened by rows, zero for all others."""
    row = np.zeros((3, 3 * len(checked_formation(formation))))
    for neighbor, block in projections(formation, agent, neighbors).items():
        row[:, 3 * neighbor : 3 * neighbor + 3] = block
    return row.ravel().tolist()


def projections_of_ort_proj(values: ArrayLike, size: int, neighbors: Iterable[int]) -> dict[int, Array]:
    """Return P_ij by neighbor from the parameter ``ort_proj``, flat or of shape (3, 3N).

    Raises:
        RangeError: If it has another size, or the block of a neighbor is no projection on a plane.
    """
    row = np.asarray(values, dtype=np.float64)
    if row.size != 9 * size:
        raise RangeError(f"ort_proj has {row.size} numbers, allowed: 9 N = {9 * size}")
    row = row.reshape(3, 3 * size)
    result = {}
    for neighbor in neighbors:
        block = row[:, 3 * neighbor : 3 * neighbor + 3]
        # a projection on a plane is symmetric, equals its square and has trace 2; files may round
        if not (
            np.allclose(block, block.T, atol=1e-3)
            and np.allclose(block @ block, block, atol=1e-3)
            and abs(float(np.trace(block)) - 2.0) < 1e-2
        ):
            raise RangeError(f"ort_proj of neighbor {neighbor} is no orthogonal projection I - g g'")
        result[neighbor] = block.copy()
    return result


def bearing_laplacian(formation: ArrayLike, graph: Graph) -> Array:
    """Return the bearing Laplacian, shape (3N, 3N); row i sums over the in-neighbors of i."""
    size = graph.size
    blocks = np.zeros((size, 3, size, 3))
    for agent in range(size):
        for neighbor, block in projections(formation, agent, graph.in_neighbors(agent)).items():
            blocks[agent, :, neighbor] -= block
            blocks[agent, :, agent] += block
    return blocks.reshape(3 * size, 3 * size)


def follower_block(formation: ArrayLike, graph: Graph, leaders: Iterable[int]) -> Array:
    """Return rows and columns of the followers of the bearing Laplacian, in their order, shape (3F, 3F)."""
    index = _rows(graph.size, leaders)
    return bearing_laplacian(formation, graph)[np.ix_(index, index)]


def follower_eigenvalues(formation: ArrayLike, graph: Graph, leaders: Iterable[int]) -> NDArray[np.complex128] | Array:
    """Return the eigenvalues of the follower block, by real part; real numbers for undirected graphs."""
    block = follower_block(formation, graph, leaders)
    if graph.is_undirected:
        return np.linalg.eigvalsh(block)
    values = np.linalg.eigvals(block)
    return values[np.argsort(values.real, kind="stable")]


def _rows(size: int, leaders: Iterable[int]) -> NDArray[np.intp]:
    leading = set(leaders)
    return np.array([3 * i + k for i in range(size) if i not in leading for k in range(3)], dtype=np.intp)


def is_rigid(formation: ArrayLike, graph: Graph) -> bool:
    """Return whether the bearings fix the formation but for place and size (infinitesimal bearing rigidity)."""
    undirected = Graph.undirected(graph.size, graph.pairs)
    values = np.linalg.eigvalsh(bearing_laplacian(formation, undirected))
    # three ways to move, one to grow
    return graph.size < 2 or bool(values[4:].min(initial=np.inf) > _SINGULAR * values[-1])


def free_followers(formation: ArrayLike, graph: Graph, leaders: Iterable[int]) -> list[int]:
    """Return the followers whose places leaders and bearings do not determine; none: the formation is unique."""
    leading = list(leaders)
    block = follower_block(formation, graph, leading)
    if not block.size:
        return []
    _, singular, rows = np.linalg.svd(block)
    free = rows[singular <= _SINGULAR * max(1.0, singular[0])]
    moves = np.abs(free).reshape(len(free), len(block) // 3, 3).max(axis=(0, 2), initial=0.0)
    followers = [agent for agent in range(graph.size) if agent not in set(leading)]
    return [agent for agent, move in zip(followers, moves, strict=True) if move > 1e-4]


def check_formation(formation: ArrayLike, graph: Graph, leaders: Sequence[int]) -> None:
    """Refuse a formation that leaders and bearings do not determine.

    Raises:
        RangeError: If something is wrong; the message names it and the drones.
    """
    places = checked_formation(formation)
    if len(places) != graph.size:
        raise RangeError(f"formation has {len(places)} places, allowed: one for each of {graph.size} agents")
    leaders = list(leaders)
    for leader in leaders:
        if not 0 <= leader < graph.size:
            raise RangeError(f"leaders hold {leader}, allowed: agents 0 to {graph.size - 1}")
    if len(set(leaders)) < 2 and len(set(leaders)) < graph.size:
        raise RangeError(f"there are {len(set(leaders))} leaders, allowed: 2 or more, for bearings tell no size")
    graph.check_rooted(leaders)
    if free := free_followers(places, graph, leaders):
        names = ", ".join(graph.name(agent) for agent in free)
        raise RangeError(
            f"formation is ambiguous: bearings and leaders do not determine where {names} shall be, "
            "allowed: a bearing rigid formation (add edges whose bearings are not parallel)"
        )


def modes(eigenvalues: ArrayLike, k_p: float, k_v: float, k_i: float = 0.0) -> NDArray[np.complex128]:
    """Return the modes (1/s) of a double integrator per eigenvalue L: s^2 + k_v L s + k_p L, times s, plus k_i L.

    Slowest first, which is the largest real part.
    """
    roots = []
    for value in np.atleast_1d(np.asarray(eigenvalues)):
        polynomial = [1.0, k_v * value, k_p * value]
        roots.append(np.roots([*polynomial, k_i * value] if k_i else polynomial))
    joined = np.concatenate(roots)
    return joined[np.argsort(-joined.real, kind="stable")]


def bearing_errors_deg(positions: ArrayLike, formation: ArrayLike, pairs: Iterable[tuple[int, int]]) -> Array:
    """Return the angles between bearings as they are and as they shall be (degrees), one per pair.

    Args:
        positions: Where the agents are (m), shape (..., N, 3).
        formation: Where they shall be (m), shape (N, 3).
        pairs: Of agents, as `Graph.pairs`.

    Returns:
        Shape (..., number of pairs).

    Raises:
        RangeError: If two agents of a pair are nearer than 1 mm.
    """
    pairs = np.array(list(pairs), dtype=np.intp).reshape(-1, 2)
    first, second = pairs[:, 0], pairs[:, 1]
    is_now = np.asarray(positions, dtype=np.float64)
    shall = checked_formation(formation)
    g, d = bearing(is_now[..., first, :], is_now[..., second, :]), bearing(shall[first], shall[second])
    # the arc tangent is exact at small angles, the arc cosine is not
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(g, d), axis=-1), np.sum(g * d, axis=-1)))


def bearing_error_deg(positions: ArrayLike, formation: ArrayLike, pairs: Iterable[tuple[int, int]]) -> Array:
    """Return the largest of `bearing_errors_deg`, shape (...)."""
    return bearing_errors_deg(positions, formation, pairs).max(axis=-1, initial=0.0)
