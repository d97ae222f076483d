"""What a flight of tasks comes down to, read from what happened in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from crazychoir_fw.guidance.schemes.tasks.hungarian import best_assignment

Events = Sequence[Mapping[str, Any]]
"""Events of a flight log."""

_ENOUGH = 1e-5  # [m], by which a sum of costs may differ: the simplex takes less than 1e-6 for zero


def completed(events: Events) -> int:
    """Return how many tasks were completed."""
    return sum(event["kind"] == "completed" for event in events)


@dataclass(frozen=True)
class Agreement:
    """What all drones together decided about one list."""

    label: int
    """Which list."""
    count: int
    """Number of tasks that were taken."""
    best_count: int
    """Max number of tasks that could be taken."""
    cost: float
    """Sum of distances (m)."""
    best_cost: float
    """Min sum (m)."""
    is_consistent: bool
    """Whether no task is done by two."""

    @property
    def is_optimal(self) -> bool:
        """Whether it could not be better."""
        return self.is_consistent and self.count == self.best_count and self.cost <= self.best_cost + _ENOUGH


def agreements(events: Events) -> list[Agreement]:
    """Return what was decided about each list that was not replaced before all had decided."""
    decisions: dict[int, list[Mapping[str, Any]]] = {}
    for event in events:
        if event["kind"] == "assigned":
            decisions.setdefault(int(event["details"]["label"]), []).append(event["details"])
    agreed = [int(event["details"]["label"]) for event in events if event["kind"] == "agreed"]
    return [_agreement(label, decisions[label]) for label in agreed]


def largest_gap(events: Events) -> float | None:
    """Return by which part all routes together were longer than their lower bound, at worst over all lists.

    None if drones never agreed.
    """
    lengths: dict[int, float] = {}
    bounds: dict[int, float] = {}
    for event in events:
        details = event["details"]
        if event["kind"] == "assigned" and "bound" in details:
            label = int(details["label"])
            lengths[label] = lengths.get(label, 0.0) + details["cost"]
            bounds[label] = min(bounds.get(label, np.inf), details["bound"])
    agreed = [int(event["details"]["label"]) for event in events if event["kind"] == "agreed"]
    gaps = [lengths[label] / bounds[label] - 1.0 for label in agreed if bounds.get(label, 0.0) > _ENOUGH]
    return max(gaps) if gaps else None


def _agreement(label: int, decisions: Sequence[Mapping[str, Any]]) -> Agreement:
    columns = sorted({int(number) for decision in decisions for number, _ in decision["costs"]})
    costs = np.full((len(decisions), len(columns)), np.inf)
    taken = []
    for row, decision in enumerate(decisions):
        for number, cost in decision["costs"]:
            costs[row, columns.index(int(number))] = cost
        taken += [(row, columns.index(int(number))) for number in decision["takes"]]
    best = best_assignment(costs)
    return Agreement(
        label,
        len(taken),
        len(best),
        float(sum(costs[pair] for pair in taken)),
        float(sum(costs[pair] for pair in best.items())),
        len({column for _, column in taken}) == len(taken),
    )
