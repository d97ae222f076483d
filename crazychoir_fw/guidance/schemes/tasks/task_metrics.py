"""Metrics of flights whose drones work for a table: what was completed, and how well it was shared out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from crazychoir_fw.guidance.metrics import Flown, Metrics, Verdict, criterion
from crazychoir_fw.guidance.schemes.tasks.judging import agreements, completed, largest_gap
from crazychoir_fw.guidance.schemes.tasks.task_timeline import timeline_of
from crazychoir_fw.recording.marks import TaskTimeline


class WorkMetrics(Metrics):
    """What all tables have in common."""

    scope = "swarm"

    def timeline(self, events: Sequence[Mapping[str, Any]], names: Sequence[str], end: float) -> TaskTimeline | None:
        """See `Metrics`."""
        return timeline_of(events, names, end)

    def verdict(self, key: str, limit: Any, flown: Flown) -> Verdict:
        """See `Metrics`."""
        return getattr(self, key)(flown, limit)

    @criterion("completed tasks", high=1_000_000, kind=int)
    def tasks_completed(self, flown: Flown, least: int) -> Verdict:
        """Return whether so many tasks, or deliveries, were completed."""
        done = completed(flown.events)
        sentence = f"{done} tasks were completed, allowed: {least} or more"
        return Verdict("tasks_completed", least, float(done), done >= least, sentence)


class TaskMetrics(WorkMetrics):
    """Whether lists of tasks were shared out as well as by an assignment with all costs in one place."""

    @criterion("optimal assignments", kind=bool)
    def assignment_optimal(self, flown: Flown, _: bool) -> Verdict:
        """Return whether each list was shared out as well as possible."""
        agreed = agreements(flown.events)
        good = sum(one.is_optimal for one in agreed)
        sentence = f"{good} of {len(agreed)} assignments were optimal"
        for bad in [one for one in agreed if not one.is_optimal][:1]:
            sentence += (
                f"; list {bad.label}: {bad.count} tasks at {bad.cost:.3f} m instead of {bad.best_count} at "
                f"{bad.best_cost:.3f} m"
            )
        passed = bool(agreed) and good == len(agreed)
        return Verdict("assignment_optimal", True, float(good), passed, sentence)


class DeliveryMetrics(WorkMetrics):
    """How much longer routes are than they had to be."""

    @criterion("length of routes above the bound", high=10.0)
    def routes_gap(self, flown: Flown, limit: float) -> Verdict:
        """Return whether routes are near their lower bound."""
        gap = largest_gap(flown.events)
        if gap is None:
            return Verdict("routes_gap", limit, None, False, "drones agreed on no routes")
        sentence = f"routes are {100 * gap:.1f} % longer than their lower bound, allowed: {100 * limit:g} %"
        return Verdict("routes_gap", limit, round(gap, 4), gap <= limit, sentence)
