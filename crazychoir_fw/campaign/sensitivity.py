"""Which varied values move which figures: rank correlations, and Sobol indices where the design allows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.campaign.campaign import Campaign
from crazychoir_fw.campaign.design import share_problem
from crazychoir_fw.campaign.flight import MARGIN, Record

Array = NDArray[np.float64]

FAILED = "failed"
"""The figure that is 1 of a flight that did not succeed, and 0 otherwise."""
_LEAST_FLIGHTS = 8


@dataclass(frozen=True)
class Influence:
    """How a varied value goes with a figure."""

    key: str
    figure: str
    rank: float
    """Spearman's rank correlation, -1 to 1."""
    p: float
    """Probability of one so large without any influence."""
    first: float | None = None
    """Sobol index of first order, 0 to 1."""
    total: float | None = None
    """Sobol index of all orders, 0 to 1."""


def influences(campaign: Campaign, records: Sequence[Record]) -> list[Influence]:
    """Return the influences of all numbers that vary on all figures, the strongest first."""
    from scipy.stats import spearmanr

    flown = [record for record in records if record.figures]
    if len(flown) < _LEAST_FLIGHTS:
        return []
    found = []
    targets = targets_of(flown)
    for varied in campaign.varied:
        values = [record.values.get(varied.key) for record in flown]
        if not all(isinstance(value, int | float) for value in values) or len(set(values)) < 2:
            continue
        for name, target in targets.items():
            known = np.isfinite(target)
            if known.sum() < _LEAST_FLIGHTS or np.ptp(target[known]) == 0.0:
                continue
            result = spearmanr(np.array(values, float)[known], target[known])
            if math.isfinite(result.statistic):
                found.append(Influence(varied.key, name, float(result.statistic), float(result.pvalue)))
    if campaign.settings.design == "saltelli":
        found = _with_sobol(campaign, flown, targets, found)
    return sorted(found, key=lambda one: -abs(one.rank))


def blame(campaign: Campaign, records: Sequence[Record]) -> list[Influence]:
    """Return the influences that are no accident, those on failures and margins first.

    An influence counts if its p is below 0.05 over the number of all that were looked at (Bonferroni).
    """
    found = influences(campaign, records)
    clear = [one for one in found if one.p < 0.05 / len(found)]
    return sorted(clear, key=lambda one: one.figure not in (FAILED, MARGIN))


def targets_of(records: Sequence[Record]) -> dict[str, Array]:
    """Return what may be influenced, by name: `FAILED`, and all figures."""
    names = dict.fromkeys(name for record in records for name in record.figures if name != "sim_seconds")
    targets = {FAILED: np.array([float(not record.passed) for record in records])}
    for name in names:
        targets[name] = np.array([record.figures.get(name, math.nan) for record in records])
    return targets


def _with_sobol(
    campaign: Campaign, records: Sequence[Record], targets: dict[str, Array], found: list[Influence]
) -> list[Influence]:
    """Add Sobol indices; flights without a figure count as its mean."""
    from SALib.analyze import sobol

    keys = [varied.key for varied in campaign.varied]
    block = 2 * len(keys) + 2
    count = len(records) // block * block
    indices: dict[tuple[str, str], tuple[float, float]] = {}
    for name, target in targets.items():
        values = np.where(np.isfinite(target), target, np.nanmean(target))[:count]
        if count and np.ptp(values) > 0.0:
            result: Any = sobol.analyze(share_problem(len(keys)), values, calc_second_order=True, seed=0)
            for key, first, total in zip(keys, result["S1"], result["ST"], strict=True):
                indices[key, name] = float(first), float(total)
    return [
        Influence(one.key, one.figure, one.rank, one.p, *indices.get((one.key, one.figure), (None, None)))
        for one in found
    ]
