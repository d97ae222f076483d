"""Graphs and weights as matrices, under DISROPT's names (docs/reference/crazychoir.md#18 and #23).

An entry (i, j) that is not zero is an edge from j to i: row i holds the in-neighbors of agent i.
`crazychoir_fw.guidance.Graph` is the same thing as an object.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.graph import Graph

Array = NDArray[np.float64]

_MAX_DRAWS = 10_000


def path_graph(N: int) -> Array:
    """Return the undirected path 0, 1, ..., N - 1, shape (N, N)."""
    return Graph.path(N).adjacency


def ring_graph(N: int, link_type: str = "undirected") -> Array:
    """Return the ring 0, 1, ..., N - 1, 0, shape (N, N); directed: each hears the next one."""
    return Graph.ring(N, directed=_is_directed(link_type)).adjacency


def binomial_random_graph(N: int, p: float, seed: int | None = None, link_type: str = "undirected") -> Array:
    """Return a connected random graph, the same as DISROPT's for a seed.

    Args:
        N: Number of agents.
        p: Probability that a pair is drawn, in each direction, (0, 1].
        seed: Of the generator; the global one of NumPy is left alone.
        link_type: "undirected": a pair is connected if either direction is drawn; "directed": strongly connected.

    Returns:
        Matrix of 0 and 1, shape (N, N).

    Raises:
        RangeError: If an argument is outside its range, or p so small that no connected graph comes.
    """
    if not _is_directed(link_type) and seed is not None:
        return Graph.binomial(N, p, seed).adjacency
    if not 0.0 < p <= 1.0:
        raise RangeError(f"graph: p is {p}, allowed: above 0, at most 1")
    dice = np.random.RandomState(seed)
    for _ in range(_MAX_DRAWS):
        drawn = dice.binomial(1, p, (N, N))
        graph = Graph.from_adjacency(drawn if _is_directed(link_type) else drawn | drawn.T)
        if graph.is_connected():
            return graph.adjacency
    raise RangeError(f"graph: p is {p}, allowed: enough for a connected graph of {N} agents")


def binomial_random_graph_sequence(
    under_adj: ArrayLike,
    n_graphs: int,
    p: float = 0.1,
    period: int | None = None,
    seed: int | None = None,
    link_type: str = "undirected",
) -> list[Array]:
    """Return graphs that keep each edge of a largest one with a probability.

    Args:
        under_adj: The largest graph, shape (N, N).
        n_graphs: How many.
        p: Probability of an edge to be kept, [0, 1].
        period: All graphs of each such number in a row have all edges together: they are jointly connected if the
            largest is. The edges that are missing at the end of a period are in its last graph. None: nothing is
            added.
        seed: Of the generator.
        link_type: "undirected": both directions of an edge are kept together.

    Raises:
        RangeError: If an argument is outside its range.
    """
    largest = np.asarray(under_adj) != 0
    if not 0.0 <= p <= 1.0:
        raise RangeError(f"graph: p is {p}, allowed: [0, 1]")
    if period is not None and period < 1:
        raise RangeError(f"graph: period is {period}, allowed: 1 or more")
    dice = np.random.RandomState(seed)
    graphs: list[Array] = []
    seen = np.zeros_like(largest)
    for number in range(n_graphs):
        drawn = dice.random_sample(largest.shape) < p
        if not _is_directed(link_type):
            drawn = np.triu(drawn, 1)
            drawn = drawn | drawn.T
        kept = largest & drawn
        seen |= kept
        if period is not None and number % period == period - 1:
            kept |= largest & ~seen
            seen[:] = False
        graphs.append(kept.astype(np.float64))
    return graphs


def metropolis_hastings(Adj: ArrayLike) -> Array:
    """Return doubly stochastic weights of an undirected graph, w_ij = 1/(1 + max(degree_i, degree_j)), shape (N, N).

    Raises:
        RangeError: If an edge goes one way only.
    """
    return Graph.from_adjacency(Adj).metropolis_hastings()


def row_stochastic_matrix(Adj: ArrayLike) -> Array:
    """Return equal weights of each agent and its in-neighbors: rows sum to 1, shape (N, N)."""
    edges = (np.asarray(Adj) != 0).astype(np.float64)
    np.fill_diagonal(edges, 1.0)
    return edges / edges.sum(axis=1, keepdims=True)


def column_stochastic_matrix(Adj: ArrayLike) -> Array:
    """Return equal weights of each agent and its out-neighbors: columns sum to 1, shape (N, N)."""
    return row_stochastic_matrix(np.asarray(Adj).T).T


def _is_directed(link_type: str) -> bool:
    if link_type not in ("undirected", "directed"):
        raise RangeError(f"graph: link_type is {link_type!r}, allowed: 'undirected', 'directed'")
    return link_type == "directed"
