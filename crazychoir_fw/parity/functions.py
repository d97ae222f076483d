"""Asks both providers the same questions and compares their answers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.parity.cases import Case, CaseRequest, Outcome
from crazychoir_fw.parity.deviation import Deviation, Trace, Verdict, measure, overall, trace
from crazychoir_fw.parity.side import Side
from crazychoir_fw.parity.tolerances import tolerance_of

TRACES = 2
"""Of so many signals of a case a picture is kept, the worst ones."""


@dataclass
class Comparison:
    """Two answers to one question, or two flights, signal by signal."""

    group: str
    name: str
    about: str
    is_by_number: bool
    """Samples are counted; otherwise they are named by their tick (ms)."""
    deviations: list[Deviation] = field(default_factory=list)
    """The worst first."""
    traces: dict[str, Trace] = field(default_factory=dict)
    """Of the worst signals."""
    missing_in: tuple[str, ...] = ()
    """Names of the providers that cannot be asked."""
    failures: dict[str, str] = field(default_factory=dict)
    """Why a provider gave up, by ``reference`` and ``candidate``."""
    modules: tuple[str, ...] = ()
    """Of flights: the modules around the algorithms that decide them."""
    only_in: dict[str, list[str]] = field(default_factory=dict)
    """Signals that only the ``reference`` or the ``candidate`` gave."""

    @property
    def verdict(self) -> Verdict:
        """What is to be said about this question."""
        if self.missing_in:
            return Verdict.MISSING
        if self.failures:
            return Verdict.DIFFERENT
        return overall([deviation.verdict for deviation in self.deviations])

    @property
    def worst(self) -> Deviation | None:
        """The worst signal, or None when there is none."""
        return self.deviations[0] if self.deviations else None

    @property
    def first_tick(self) -> int | None:
        """When the first signal begins to deviate."""
        ticks = [deviation.first_tick for deviation in self.deviations if deviation.first_tick is not None]
        return min(ticks, default=None)

    @property
    def first_signals(self) -> list[str]:
        """Those that deviate first."""
        first = self.first_tick
        return [
            deviation.signal for deviation in self.deviations if deviation.first_tick == first and first is not None
        ]

    def as_json(self) -> dict[str, Any]:
        """Return what a JSON report says."""
        return {
            "group": self.group,
            "name": self.name,
            "about": self.about,
            "ticks_are_numbers": self.is_by_number,
            "verdict": self.verdict.value,
            "missing_in": list(self.missing_in),
            "failures": self.failures,
            "only_in": self.only_in,
            "first_tick": self.first_tick,
            "first_signals": self.first_signals,
            "signals": [deviation.as_json() for deviation in self.deviations if deviation.deviating],
            "identical_signals": [deviation.signal for deviation in self.deviations if not deviation.deviating],
        }


def compare_functions(
    reference: Side,
    candidate: Side,
    cases: Sequence[Case],
    progress: Callable[[float], None] | None = None,
) -> list[Comparison]:
    """Ask both sides all questions.

    Args:
        reference: The side that is right by definition.
        candidate: The other one.
        cases: The questions.
        progress: Told which share is done, in [0, 1].
    """
    found = []
    for i, case in enumerate(cases):
        found.append(compare_case(reference, candidate, case))
        if progress is not None:
            progress((i + 1) / len(cases))
    return found


def compare_case(reference: Side, candidate: Side, case: Case) -> Comparison:
    """Ask both sides one question."""
    result = Comparison(case.group, case.name, case.about, case.by_number)
    sides = {"reference": reference, "candidate": candidate}
    result.missing_in = tuple(side.name for side in sides.values() if not case.is_possible(side))
    if result.missing_in:
        return result
    logs = common_logs(reference, candidate, case.log_groups)
    outcomes: dict[str, Outcome] = {}
    for role, side in sides.items():
        try:
            outcome = outcomes[role] = case.run(CaseRequest(side, logs))
        except CrazychoirError as error:
            result.failures[role] = str(error)
        else:
            if outcome.failure:
                result.failures[role] = outcome.failure
    if len(outcomes) == 2:
        _compare_signals(result, outcomes["reference"], outcomes["candidate"])
    return result


def common_logs(reference: Side, candidate: Side, groups: Sequence[str]) -> tuple[str, ...]:
    """Return the log variables of these groups that both providers have with the same type."""
    theirs = candidate.log_table
    return tuple(
        name
        for name, variable in reference.log_table.items()
        if name.split(".")[0] in groups and name in theirs and theirs[name].dtype == variable.dtype
    )


def _compare_signals(result: Comparison, reference: Outcome, candidate: Outcome) -> None:
    for name, values in reference.signals.items():
        if name not in candidate.signals:
            result.only_in.setdefault("reference", []).append(name)
            continue
        tolerance = tolerance_of(name, values.dtype)
        result.deviations.append(measure(name, values, candidate.signals[name], reference.ticks, tolerance))
    missing = [name for name in candidate.signals if name not in reference.signals]
    if missing:
        result.only_in["candidate"] = missing
    result.deviations.sort(key=lambda deviation: deviation.severity, reverse=True)
    for deviation in result.deviations[:TRACES]:
        if deviation.deviating:
            name = deviation.signal
            first, second = reference.signals[name], candidate.signals[name]
            result.traces[name] = trace(first, second, np.asarray(reference.ticks), deviation.tolerance.turn)
