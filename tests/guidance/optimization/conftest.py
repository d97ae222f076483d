import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from crazychoir_fw.guidance import InProcessTransport, TimeVaryingCommunicator
from crazychoir_fw.guidance.optimization import Agent, Algorithm, graphs


class ListedGraphs:
    """A schedule of matrices, one per round, from the begin again after the last."""

    def __init__(self, matrices: Sequence[np.ndarray]) -> None:
        self._matrices = matrices

    def neighbors_at(self, agent: int, now: float, label: int) -> tuple[list[int], list[int]]:
        matrix = self._matrices[label % len(self._matrices)]
        return np.flatnonzero(matrix[agent]).tolist(), np.flatnonzero(matrix[:, agent]).tolist()


def make_team(
    adjacency: np.ndarray,
    problems: Sequence[Any] = (),
    *,
    loss: float | None = None,
    schedule: Any = None,
    seed: int = 0,
    serialize: bool = False,
    weighted: bool = True,
) -> list[Agent]:
    """Return agents of one process; with a loss (maybe 0) they are asynchronous."""
    transport = InProcessTransport(loss=loss or 0.0, seed=seed, serialize=serialize)
    undirected = np.array_equal(adjacency, adjacency.T)
    weights = graphs.metropolis_hastings(adjacency) if undirected and weighted else None
    team = []
    for i in range(len(adjacency)):
        communicator = TimeVaryingCommunicator(
            i,
            len(adjacency),
            np.flatnonzero(adjacency[i]).tolist(),
            np.flatnonzero(adjacency[:, i]).tolist(),
            synchronous_mode=loss is None,
            transport=transport,
            clock=time.monotonic,
        )
        row = None if weights is None else weights[i].tolist()
        team.append(Agent(communicator=communicator, in_weights=row, schedule=schedule))
    for agent, problem in zip(team, problems, strict=False):
        agent.set_problem(problem)
    return team


def run_in_any_order(algorithms: Sequence[Algorithm], rounds: int, seed: int = 0) -> None:
    """Let agents do rounds on their own, in random order, as many each on average."""
    dice = np.random.default_rng(seed)
    for i in dice.integers(len(algorithms), size=rounds * len(algorithms)):
        algorithms[i].begin_round()
        algorithms[i].finish_round()


@pytest.fixture(scope="session")
def team() -> Callable[..., list[Agent]]:
    return make_team


@pytest.fixture(scope="session")
def in_any_order() -> Callable[..., None]:
    return run_in_any_order


@pytest.fixture(scope="session")
def jointly_connected() -> Callable[..., tuple[np.ndarray, ListedGraphs]]:
    """Return a (strongly) connected graph and a schedule of parts: each three in a row have all its edges together."""

    def make(size: int, seed: int, kind: str = "undirected") -> tuple[np.ndarray, ListedGraphs]:
        largest = graphs.binomial_random_graph(size, 0.5, seed, kind)
        parts = graphs.binomial_random_graph_sequence(largest, 12, 0.3, period=3, seed=seed, link_type=kind)
        return largest, ListedGraphs(parts)

    return make


@pytest.fixture(scope="session")
def factor_per_round() -> Callable[..., float]:
    """Return the factor by which errors shrink in a round: the slope of their logarithms, above rounding."""

    def fit(errors: Sequence[float], after: int = 0, least: float = 1e-10) -> float:
        logarithms = np.log(np.array([error for error in errors[after:] if error > least]))
        assert len(logarithms) > 20, "too few errors above rounding for a slope"
        return float(np.exp(np.polyfit(np.arange(len(logarithms)), logarithms, 1)[0]))

    return fit
