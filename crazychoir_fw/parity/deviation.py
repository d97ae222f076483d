"""How far two signals are apart: in units of the last place, absolutely, and since when.

Numbers that are not numbers: NaN equals NaN whatever its bits, and an infinity equals itself. A sample where only one
side is NaN or infinite, or where the infinities have different signs, is `unmatched`: no tolerance covers it, its
absolute deviation is infinite, and it stays out of the RMS. +0 equals -0.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.parity.tolerances import Tolerance

UNMATCHED_ULPS = 2**32
"""Distance of a number from what is none: more than any two numbers are apart."""


class Verdict(str, enum.Enum):
    """What is to be said about a signal, or all of them."""

    IDENTICAL = "identical"
    EQUAL = "equal within tolerance"
    DIFFERENT = "different"
    MISSING = "missing"
    """Only one of the providers has it."""
    NOT_JUDGED = "not judged"
    """It deviates, and that cannot make the whole different."""


def ulps_apart(reference: ArrayLike, candidate: ArrayLike) -> NDArray[np.int64]:
    """Return how many float32 numbers lie between two arrays, element by element.

    Both zeros are one number; NaN is 0 from NaN and `UNMATCHED_ULPS` from everything else.
    """
    first, second = _float32(reference), _float32(candidate)
    apart = np.abs(_ordered(first) - _ordered(second))
    first_nan, second_nan = np.isnan(first), np.isnan(second)
    apart[first_nan != second_nan] = UNMATCHED_ULPS
    apart[first_nan & second_nan] = 0
    return apart


def _float32(values: ArrayLike) -> NDArray[np.float32]:
    with np.errstate(over="ignore"):
        return np.atleast_1d(np.asarray(values)).astype(np.float32)


def _ordered(values: NDArray[np.float32]) -> NDArray[np.int64]:
    """Return whole numbers that are in the order of the floats, one step per float."""
    bits = values.view(np.int32).astype(np.int64)
    return np.where(bits < 0, -(bits & 0x7FFFFFFF), bits)


@dataclass(frozen=True)
class Deviation:
    """How far one signal of the candidate is from the reference's."""

    signal: str
    tolerance: Tolerance
    samples: int
    """That were compared."""
    deviating: int = 0
    """Samples that are not equal."""
    beyond: int = 0
    """Samples beyond the tolerance."""
    unmatched: int = 0
    """Samples where only one side is a finite number, see above."""
    share: float = 0.0
    """Largest share of the tolerance that a sample uses; above 1 it is beyond, unless its ulps are few."""
    max_ulps: int | None = None
    """Largest distance in float32 units of the last place; None for whole numbers."""
    max_absolute: float = 0.0
    """Largest distance in the unit of the signal; infinite when a sample is unmatched."""
    sum_of_squares: float = 0.0
    first_tick: int | None = None
    """Tick (ms), or number, of the first sample that is not equal."""
    first_beyond_tick: int | None = None
    """The same of the first sample beyond the tolerance."""
    worst_tick: int | None = None
    worst_reference: float | None = None
    worst_candidate: float | None = None

    @property
    def rms(self) -> float:
        """Root mean square over the matched samples, in the unit of the signal."""
        matched = self.samples - self.unmatched
        return math.sqrt(self.sum_of_squares / matched) if matched else 0.0

    @property
    def verdict(self) -> Verdict:
        """What is to be said about this signal."""
        if not self.deviating:
            return Verdict.IDENTICAL
        if not self.tolerance.is_judged:
            return Verdict.NOT_JUDGED
        return Verdict.DIFFERENT if self.beyond else Verdict.EQUAL

    @property
    def severity(self) -> tuple[int, float, int]:
        """Sorts the worst signals first when reversed: by verdict, then by share of the tolerance that is used."""
        rank = {Verdict.DIFFERENT: 3, Verdict.EQUAL: 2, Verdict.NOT_JUDGED: 1}.get(self.verdict, 0)
        return rank, self.share, self.deviating

    def as_json(self) -> dict[str, Any]:
        """Return what a JSON report says; infinite and missing figures are null."""
        return {
            "signal": self.signal,
            "verdict": self.verdict.value,
            "tolerance": self.tolerance.name,
            "samples": self.samples,
            "deviating": self.deviating,
            "beyond_tolerance": self.beyond,
            "unmatched": self.unmatched,
            "share_of_tolerance": finite_or_none(self.share),
            "max_ulps": self.max_ulps,
            "max_absolute": finite_or_none(self.max_absolute),
            "rms": finite_or_none(self.rms),
            "first_tick": self.first_tick,
            "first_tick_beyond_tolerance": self.first_beyond_tick,
            "worst_tick": self.worst_tick,
            "worst_reference": _json_number(self.worst_reference),
            "worst_candidate": _json_number(self.worst_candidate),
        }


def finite_or_none(value: float | None) -> float | None:
    """Return a number that JSON can hold, or None."""
    return value if value is not None and math.isfinite(value) else None


def _json_number(value: float | None) -> float | str | None:
    """Return a number, or its name where JSON has none for it."""
    return value if value is None or math.isfinite(value) else str(value)


def measure(
    signal: str, reference: NDArray[Any], candidate: NDArray[Any], ticks: NDArray[Any], tolerance: Tolerance
) -> Deviation:
    """Compare two signals of the same samples.

    Args:
        signal: Name.
        reference: Values, shape (T,), whole numbers, booleans or floats.
        candidate: Values of the other side, same shape and kind.
        ticks: What each sample is called in the report, shape (T,).
        tolerance: How far they may be apart.
    """
    if reference.shape != candidate.shape or reference.shape != ticks.shape:
        raise ValueError(f"{signal}: shapes {reference.shape}, {candidate.shape} and {ticks.shape} differ")
    is_float = "f" in (reference.dtype.kind, candidate.dtype.kind)
    same = Deviation(signal, tolerance, samples=len(ticks), max_ulps=0 if is_float else None)
    if not is_float and np.array_equal(reference, candidate):
        return same
    first, second = reference.astype(np.float64), candidate.astype(np.float64)
    is_equal = (first == second) | (np.isnan(first) & np.isnan(second))
    if is_equal.all():
        return same

    at = np.flatnonzero(~is_equal)
    first, second, ticks = first[at], second[at], ticks[at]
    distance = _distance(first, second, tolerance.turn)
    allowed = max(tolerance.absolute, tolerance.relative * _scale(reference))
    is_near = distance <= allowed
    ulps = ulps_apart(reference[at], candidate[at]) if is_float else None
    if ulps is not None:
        is_near |= (ulps <= tolerance.ulps) & np.isfinite(distance)
    beyond = ticks[~is_near]
    worst = int(distance.argmax())
    is_matched = np.isfinite(distance)
    return replace(
        same,
        deviating=len(at),
        beyond=len(beyond),
        unmatched=int((~is_matched).sum()),
        share=float(distance[worst] / allowed) if allowed else math.inf,
        max_ulps=None if ulps is None else int(ulps.max()),
        max_absolute=float(distance[worst]),
        sum_of_squares=float((distance[is_matched] ** 2).sum()),
        first_tick=int(ticks[0]),
        first_beyond_tick=int(beyond[0]) if len(beyond) else None,
        worst_tick=int(ticks[worst]),
        worst_reference=float(first[worst]),
        worst_candidate=float(second[worst]),
    )


def _distance(first: NDArray[np.float64], second: NDArray[np.float64], turn: float) -> NDArray[np.float64]:
    """Return how far samples that are not equal are apart; infinite where one side is no finite number."""
    is_matched = np.isfinite(first) & np.isfinite(second)
    distance = np.full(first.shape, np.inf)
    distance[is_matched] = np.abs(first[is_matched] - second[is_matched])
    if turn:
        rest = np.fmod(distance[is_matched], turn)
        distance[is_matched] = np.minimum(rest, turn - rest)
    return distance


def _scale(reference: NDArray[Any]) -> float:
    values = reference.astype(np.float64)
    values = values[np.isfinite(values)]
    return float(np.abs(values).max()) if len(values) else 0.0


def join(earlier: Deviation, later: Deviation) -> Deviation:
    """Return the deviation of two stretches of one signal, one after the other."""
    worse = later if later.max_absolute > earlier.max_absolute else earlier
    ulps = None if earlier.max_ulps is None or later.max_ulps is None else max(earlier.max_ulps, later.max_ulps)
    return Deviation(
        signal=earlier.signal,
        tolerance=earlier.tolerance,
        samples=earlier.samples + later.samples,
        deviating=earlier.deviating + later.deviating,
        beyond=earlier.beyond + later.beyond,
        unmatched=earlier.unmatched + later.unmatched,
        share=max(earlier.share, later.share),
        max_ulps=ulps,
        max_absolute=worse.max_absolute,
        sum_of_squares=earlier.sum_of_squares + later.sum_of_squares,
        first_tick=_either(earlier.first_tick, later.first_tick),
        first_beyond_tick=_either(earlier.first_beyond_tick, later.first_beyond_tick),
        worst_tick=worse.worst_tick,
        worst_reference=worse.worst_reference,
        worst_candidate=worse.worst_candidate,
    )


def _either(first: int | None, second: int | None) -> int | None:
    return second if first is None else first


def overall(verdicts: list[Verdict]) -> Verdict:
    """Return the verdict of several: different, equal or identical; what is missing has no say."""
    if Verdict.DIFFERENT in verdicts:
        return Verdict.DIFFERENT
    return Verdict.EQUAL if {Verdict.EQUAL, Verdict.NOT_JUDGED} & set(verdicts) else Verdict.IDENTICAL


POINTS = 400


@dataclass(frozen=True)
class Trace:
    """Two signals, thinned out for a picture."""

    ticks: NDArray[Any]
    reference: NDArray[np.float64]
    candidate: NDArray[np.float64]
    deviation: NDArray[np.float64]
    """Largest absolute deviation since the instant before; infinite where a sample is unmatched."""


def trace(
    reference: NDArray[Any], candidate: NDArray[Any], ticks: NDArray[Any], turn: float = 0.0, points: int = POINTS
) -> Trace:
    """Thin two signals of shape (T,) out; no deviation between two instants is lost."""
    first, second = reference.astype(np.float64), candidate.astype(np.float64)
    with np.errstate(invalid="ignore"):
        distance = np.abs(first - second)
    distance[(first == second) | (np.isnan(first) & np.isnan(second))] = 0.0
    distance[np.isnan(distance)] = np.inf
    if turn:
        is_finite = np.isfinite(distance)
        rest = np.fmod(distance[is_finite], turn)
        distance[is_finite] = np.minimum(rest, turn - rest)
    starts = np.linspace(0, len(ticks), min(points, len(ticks)), endpoint=False, dtype=np.intp)
    return Trace(ticks[starts], first[starts], second[starts], np.maximum.reduceat(distance, starts))
