"""Compares the tables of parameters and log variables: names, types, flags and factory values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from crazychoir_fw.onboard.variables import Variable
from crazychoir_fw.parity.deviation import Verdict, finite_or_none, ulps_apart
from crazychoir_fw.parity.side import Side


@dataclass(frozen=True)
class Difference:
    """One variable in which the providers differ."""

    kind: str
    """``parameter`` or ``log variable``."""
    name: str
    what: str
    """``missing``, ``type``, ``flags`` or ``factory value``."""
    reference: str | float | int | None
    """What the reference says; None when it lacks the variable."""
    candidate: str | float | int | None
    ulps: int | None = None
    """Distance of two factory values that are floats."""

    @property
    def verdict(self) -> Verdict:
        """Missing variables have no say in the verdict, flags are of no consequence in flight."""
        if self.what == "missing":
            return Verdict.MISSING
        return Verdict.NOT_JUDGED if self.what == "flags" else Verdict.DIFFERENT

    def as_json(self) -> dict[str, Any]:
        """Return what a JSON report says."""
        return {
            "kind": self.kind,
            "name": self.name,
            "what": self.what,
            "verdict": self.verdict.value,
            "reference": _json(self.reference),
            "candidate": _json(self.candidate),
            "ulps": self.ulps,
        }


def _json(value: Any) -> Any:
    """Return a value for JSON; a number that it does not know is a word."""
    if isinstance(value, float) and finite_or_none(value) is None:
        return str(value)
    return value


@dataclass
class Tables:
    """How the tables of two providers compare."""

    parameters: int
    """That both have."""
    logs: int
    """That both have."""
    differences: list[Difference]

    @property
    def verdict(self) -> Verdict:
        """Different when a variable that both have differs in type or factory value."""
        verdicts = {difference.verdict for difference in self.differences}
        return Verdict.DIFFERENT if Verdict.DIFFERENT in verdicts else Verdict.IDENTICAL

    @property
    def missing(self) -> int:
        """How many variables only one side has."""
        return sum(difference.what == "missing" for difference in self.differences)

    def as_json(self) -> dict[str, Any]:
        """Return what a JSON report says."""
        return {
            "verdict": self.verdict.value,
            "common_parameters": self.parameters,
            "common_logs": self.logs,
            "differences": [difference.as_json() for difference in self.differences],
        }


def compare_tables(reference: Side, candidate: Side) -> Tables:
    """Compare the providers' own tables; those of the rest of the drone are the same code on both sides."""
    differences = _compare("parameter", reference.parameter_table, candidate.parameter_table)
    differences += _factory_values(reference, candidate)
    differences += _compare("log variable", reference.log_table, candidate.log_table)
    return Tables(
        parameters=len(reference.parameter_table.keys() & candidate.parameter_table.keys()),
        logs=len(reference.log_table.keys() & candidate.log_table.keys()),
        differences=differences,
    )


def _compare(kind: str, reference: Mapping[str, Variable], candidate: Mapping[str, Variable]) -> list[Difference]:
    found = []
    for name in [*reference, *(name for name in candidate if name not in reference)]:
        first, second = reference.get(name), candidate.get(name)
        if first is None or second is None:
            types = [None if side is None else side.dtype.name for side in (first, second)]
            found.append(Difference(kind, name, "missing", *types))
            continue
        if first.dtype != second.dtype:
            found.append(Difference(kind, name, "type", first.dtype.name, second.dtype.name))
        if _flags(first) != _flags(second):
            found.append(Difference(kind, name, "flags", _flags(first), _flags(second)))
    return found


def _flags(variable: Variable) -> str:
    words = {
        "core": variable.is_core,
        "persistent": variable.is_persistent,
        "read-only": variable.is_read_only,
    }
    return " ".join(word for word, is_set in words.items() if is_set) or "none"


def _factory_values(reference: Side, candidate: Side) -> list[Difference]:
    theirs = candidate.factory_values()
    found = []
    for name, ours in reference.factory_values().items():
        if name not in theirs or reference.parameter_table[name].dtype != candidate.parameter_table[name].dtype:
            continue
        is_same = ours == theirs[name] or (np.isnan(ours) and np.isnan(theirs[name]))
        if not is_same:
            is_float = reference.parameter_table[name].dtype.kind == "f"
            ulps = int(ulps_apart(ours, theirs[name])[0]) if is_float else None
            found.append(Difference("parameter", name, "factory value", ours, theirs[name], ulps))
    return found
