"""Where in the space of all variations flights lie: shares in [0, 1], one row per flight, one column per value."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import MissionError

if TYPE_CHECKING:
    from crazychoir_fw.campaign.spread import Varied

Array = NDArray[np.float64]

DESIGNS = ("monte_carlo", "latin_hypercube", "sobol", "saltelli", "grid")
MAX_FLIGHTS = 1_000_000


def shares(design: str, flights: int, columns: int, seed: int) -> Array:
    """Return the shares of a design, shape (flights, columns); grid and saltelli have as many as fit.

    Args:
        design: One of `DESIGNS`.
        flights: How many; at most, for grid and saltelli.
        columns: How many values vary.
        seed: Of all random numbers.
    """
    if columns == 0:
        return np.zeros((flights, 0))
    if design == "monte_carlo":
        # a row depends on seed and number alone, so that more flights begin with the same ones
        return np.array([np.random.default_rng((seed, number)).random(columns) for number in range(flights)])
    if design == "grid":
        return _grid(flights, columns)
    if design == "saltelli":
        return _saltelli(flights, columns, seed)
    from scipy.stats import qmc

    engine = {"latin_hypercube": qmc.LatinHypercube, "sobol": qmc.Sobol}[design](
        columns, rng=np.random.default_rng(seed)
    )
    if design == "sobol":
        return engine.random_base2(max(0, int(np.ceil(np.log2(flights)))))[:flights]
    return engine.random(flights)


def _grid(flights: int, columns: int) -> Array:
    """Return the middles of equal cells, as many per column as fit."""
    steps = int(np.floor(flights ** (1.0 / columns) + 1e-9))
    if steps < 2:
        raise MissionError(f"design is grid with {columns} values, but flights must be at least {2**columns} for it")
    middles = (np.arange(steps) + 0.5) / steps
    return np.stack([axis.ravel() for axis in np.meshgrid(*[middles] * columns, indexing="ij")], axis=1)


def _saltelli(flights: int, columns: int, seed: int) -> Array:
    """Return the design that Sobol indices are computed from (Saltelli, Computer Physics Communications 145, 2002)."""
    from SALib.sample import sobol

    block = 2 * columns + 2
    if flights < 2 * block:
        raise MissionError(f"design is saltelli with {columns} values, but flights must be at least {2 * block} for it")
    return np.asarray(sobol.sample(share_problem(columns), 2 ** int(np.log2(flights // block)), seed=seed))


def share_problem(columns: int) -> dict[str, Any]:
    """Return so many shares as SALib describes its inputs."""
    return {"num_vars": columns, "names": [f"x{k}" for k in range(columns)], "bounds": [[0.0, 1.0]] * columns}


def correlate(values: Array, varied: Sequence[Varied], groups: Sequence[tuple[Sequence[str], float]]) -> Array:
    """Return shares of which those of each group of keys go together, by a Gaussian copula.

    Args:
        values: Shares, shape (F, K).
        varied: What the columns are.
        groups: Keys, and the correlation of each pair of them.
    """
    if not groups:
        return values
    from scipy.stats import norm

    found, keys = values.copy(), [one.key for one in varied]
    for names, rho in groups:
        columns = [keys.index(name) for name in names]
        matrix = np.full((len(columns), len(columns)), rho)
        np.fill_diagonal(matrix, 1.0)
        normal = norm.ppf(np.clip(values[:, columns], 1e-12, 1.0 - 1e-12))
        found[:, columns] = norm.cdf(normal @ np.linalg.cholesky(matrix).T)
    return found


def check_correlation(where: str, size: int, rho: Any) -> float:
    """Return a correlation that a group of so many keys may have.

    Raises:
        MissionError: If it is none.
    """
    least = -1.0 / (size - 1) if size > 1 else -1.0
    if isinstance(rho, bool) or not isinstance(rho, int | float) or not least < rho < 1.0:
        raise MissionError(f"{where} is {rho!r}, but must be a number above {least:.3g} and below 1, for {size} keys")
    return float(rho)
