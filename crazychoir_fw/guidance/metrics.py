"""What flights of a law come down to: errors, places, criteria, marks. Plain arrays in, figures and sentences out."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.law import LawContext
from crazychoir_fw.recording.error_curve import ErrorCurve
from crazychoir_fw.recording.marks import Mark, TaskTimeline

Array = NDArray[np.float64]

FINAL_S = 1.0
"""Time before the end of a phase over which its final figures are averaged (s): noise is no error of a formation."""


@dataclass(frozen=True)
class Criterion:
    """Something that a mission may demand of a flight."""

    what: str
    """What is measured; sentences about a number of the swarm say "{what} is 0.3 m", those about one number for each
    drone "agent_0: is 0.3 m from {what}"."""
    unit: str = ""
    high: float = 1000.0
    """Largest limit."""
    kind: type = float
    """float, int or bool."""

    def checked(self, key: str, limit: Any) -> Any:
        """Return a limit as it is compared.

        Raises:
            RangeError: If it is of another type or outside its range.
        """
        if self.kind is bool:
            is_right, must = isinstance(limit, bool), "true or false"
        else:
            number, words = (Integral, "whole number") if self.kind is int else (Real, "number")
            is_right = isinstance(limit, number) and not isinstance(limit, bool) and 0 <= limit <= self.high
            must = f"a {words} in [0, {self.high:g}] {self.unit}".rstrip()
        if not is_right:
            raise RangeError(f"criteria.{key} is {limit!r}, but must be {must}")
        return self.kind(limit)


def criterion(what: str, unit: str = "", high: float = 1000.0, kind: type = float) -> Callable[[Any], Any]:
    """Return what makes a method of metrics a criterion of its name; arguments are those of `Criterion`."""

    def mark(method: Any) -> Any:
        method.criterion = Criterion(what, unit, high, kind)
        return method

    return mark


@dataclass(frozen=True)
class Verdict:
    """One criterion of a flight."""

    name: str
    """Key of the mission file."""
    limit: float | bool
    """What is allowed."""
    value: float | None
    """What was measured; None if it could not be."""
    passed: bool
    sentence: str
    """What is wrong, or what was measured."""

    def as_dict(self) -> dict[str, Any]:
        """Return it for summary.json."""
        return {"criterion": self.name, "limit": self.limit, "value": self.value, "passed": self.passed}


@dataclass(frozen=True)
class Flown:
    """A flight that is over, as arrays over its T samples and N drones."""

    names: Sequence[str]
    """Of the drones."""
    time: Array
    """Times (s), shape (T,)."""
    at: Array
    """Positions (m), shape (T, N, 3)."""
    wanted: Array
    """References (m), shape (T, N, 3); NaN where there was none."""
    up: NDArray[np.bool_]
    """Whether motors turned, shape (T, N)."""
    final: slice | None
    """Samples over which final figures are averaged; None without a phase that counts."""
    start: tuple[float, float] | None = None
    """Begin and end of the last START (s)."""
    events: Sequence[Mapping[str, Any]] = ()
    """What happened; see `FlightLog.events`."""
    counted: NDArray[np.bool_] | None = None
    """Drones that criteria count, shape (N,); None is all."""

    @property
    def final_positions(self) -> Array | None:
        """Mean positions over the final samples (m), shape (N, 3)."""
        return None if self.final is None else np.nanmean(self.at[self.final], axis=0)

    @property
    def flew_at_the_end(self) -> NDArray[np.bool_]:
        """Drones whose motors turned in all final samples, shape (N,)."""
        return self.up[self.final].all(axis=0) if self.final is not None else np.zeros(self.up.shape[1], bool)

    def counts(self, i: int) -> bool:
        """Return whether criteria count a drone."""
        return self.counted is None or bool(self.counted[i])


class Metrics:
    """Judges and draws the flights of a law. Subclasses override what they have.

    Methods under `criterion` are what a mission may demand, by their names: they take a `Flown` and return a number,
    one number for each drone, shape (N,), NaN where it has none, or a whole `Verdict`. A number passes up to its limit.
    """

    criteria: ClassVar[Mapping[str, Criterion]] = {}
    """What a mission may demand, by key: filled by the methods."""
    scope = "entry"
    """Which drones one object is about: those of an `entry` of the mission; `swarm`, once for all entries; `alone`, an
    entry that flies all drones."""
    curve_label = ""
    """Name of the errors, with their unit."""
    curve_limit = ""
    """Key of the criterion that limits the errors."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        methods = {name: value for one in reversed(cls.__mro__) for name, value in vars(one).items()}
        cls.criteria = {name: one.criterion for name, one in methods.items() if hasattr(one, "criterion")}

    def __init__(self, context: LawContext) -> None:
        """Take what the mission says."""
        self.context = context

    @classmethod
    def of(cls, context: LawContext) -> Metrics | None:
        """Return the metrics of a mission, or None if it says too little for them."""
        return cls(context)

    # ---------------------------------------------------------------- figures

    def errors(self, flown: Flown) -> Array | None:
        """Return the errors that count over time, shape (T, any), NaN while a drone does not fly; None: no curve."""
        del flown
        return None

    def places(self, at: Array, wanted: Array) -> Array | None:
        """Return where all drones shall be at the end (m), shape (N, 3), NaN where that is open; None: as told.

        Args:
            at: Where they are (m), shape (N, 3).
            wanted: Their references (m), shape (N, 3); NaN for drones without.
        """
        del at, wanted
        return None

    def figures(self, flown: Flown) -> dict[str, float | None]:
        """Return figures for summary.json, by key."""
        del flown
        return {}

    def verdict(self, key: str, limit: Any, flown: Flown) -> Verdict:
        """Return how a flight did by one of `criteria`."""
        measured, criterion = getattr(self, key)(flown), self.criteria[key]
        if isinstance(measured, Verdict):
            return measured
        if np.ndim(measured):
            return worst(key, criterion.checked(key, limit), measured, flown, criterion.what)
        return at_most(key, criterion.checked(key, limit), float(measured), criterion)

    # ---------------------------------------------------------------- pictures

    @property
    def leads(self) -> frozenset[int] | None:
        """Numbers of the drones that films show red, all others being blue; None leaves colors alone."""
        return None

    @property
    def pairs(self) -> Sequence[tuple[int, int]]:
        """Pairs of drones that pictures connect."""
        return ()

    def marks(self, end: Array | None) -> list[Mark]:
        """Return points that explain the flight.

        Args:
            end: Where drones are at the end (m), shape (N, 3); None leaves those out that move.
        """
        del end
        return []

    def timeline(self, events: Sequence[Mapping[str, Any]], names: Sequence[str], end: float) -> TaskTimeline | None:
        """Return what the drones worked on and where, if they work.

        Args:
            events: Of the flight log.
            names: Of the drones.
            end: When the flight was over (s).
        """
        del events, names, end
        return None

    def curve(self, flown: Flown, criteria: Any) -> ErrorCurve | None:
        """Return the errors over time for the picture, with the limit of the mission's criteria."""
        errors = self.errors(flown)
        if errors is None or np.isnan(errors).all():
            return None
        mean, largest = mean_and_largest(errors)
        places = self.places(flown.final_positions, flown.wanted[flown.final][-1]) if flown.final else None
        return ErrorCurve(
            self.curve_label,
            mean,
            largest,
            getattr(criteria, self.curve_limit, None),
            places,
            flown.final_positions,
            list(self.pairs),
            self.marks(flown.final_positions),
            judged=None if flown.final is None else (flown.time[flown.final][0], flown.time[flown.final][-1]),
        )


def mean_and_largest(errors: Array) -> tuple[Array, Array]:
    """Return mean and largest of errors, shape (T, any), at each time, shape (T,) each; NaN where all are."""
    known = ~np.isnan(errors).all(axis=1)
    mean, largest = np.full(len(errors), np.nan), np.full(len(errors), np.nan)
    mean[known], largest[known] = np.nanmean(errors[known], axis=1), np.nanmax(errors[known], axis=1)
    return mean, largest


def at_most(name: str, limit: float, value: float, criterion: Criterion) -> Verdict:
    """Return the verdict about one number, which passes up to its limit; NaN does not."""
    what, unit = criterion.what, criterion.unit
    measured = f"{value:.3g} {unit}".rstrip() if math.isfinite(value) else "not known"
    known = round(value, 4) if math.isfinite(value) else None
    return Verdict(name, limit, known, value <= limit, f"{what} is {measured}, allowed: {limit:g} {unit}".rstrip())


def worst(name: str, limit: float, values: Array, flown: Flown, what: str) -> Verdict:
    """Return the verdict about the largest of one distance (m) for each drone, shape (N,); NaN where it has none."""
    values = values if flown.counted is None else np.where(flown.counted, values, np.nan)
    if not np.isfinite(values).any():
        return Verdict(name, limit, None, False, f"{name}: no drone has one at the end of the flight")
    index = int(np.nanargmax(values))
    value = float(values[index])
    sentence = f"{flown.names[index]}: is {value:.3f} m from {what}, allowed: {limit:g} m"
    return Verdict(name, limit, round(value, 4), value <= limit, sentence)
