"""GO or NO-GO: exact intervals, quantiles with limits, and the test that may end a campaign early."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from crazychoir_fw.campaign.flight import CRASHED, Record

if TYPE_CHECKING:
    from crazychoir_fw.campaign.campaign import CampaignFile, EarlyStop, QuantileLimit

GO, NO_GO, UNDECIDED = "GO", "NO-GO", "UNDECIDED"


def clopper_pearson(passed: int, flown: int, confidence: float, sides: int = 2) -> tuple[float, float]:
    """Return the exact interval of a probability (Clopper and Pearson, Biometrika 26, 1934).

    Args:
        passed: Successes.
        flown: Trials.
        confidence: Of the interval, such as 0.95.
        sides: 2, or 1: then each end by itself has the confidence.
    """
    from scipy.stats import beta

    tail = (1.0 - confidence) / sides
    low = 0.0 if passed == 0 else float(beta.ppf(tail, passed, flown - passed + 1))
    high = 1.0 if passed == flown else float(beta.ppf(1.0 - tail, passed + 1, flown - passed))
    return low, high


@dataclass(frozen=True)
class SequentialTest:
    """Wald's sequential probability ratio test of a probability (Ann. Math. Stat. 16, 1945)."""

    good: float
    """GO is right from here on."""
    bad: float
    """NO-GO is right up to here."""
    error: float
    """Probability of either wrong answer."""

    @classmethod
    def about(cls, success: float, stop: EarlyStop) -> SequentialTest:
        """Return the test about a wanted probability."""
        good, bad = min(success + stop.margin, 1.0 - 1e-6), max(success - stop.margin, 1e-6)
        return cls(good, bad, stop.error)

    def answer(self, outcomes: Sequence[bool]) -> str:
        """Return `GO` or `NO_GO` of the first flights that decide it, or `UNDECIDED`.

        Args:
            outcomes: Successes, in the order of the numbers of the flights.
        """
        first = self.first(outcomes)
        if first is None:
            return UNDECIDED
        return GO if self._ratio(outcomes)[first] > 0 else NO_GO

    def first(self, outcomes: Sequence[bool]) -> int | None:
        """Return the index of the flight that decides it."""
        bound = math.log((1.0 - self.error) / self.error)
        decided = np.flatnonzero(np.abs(self._ratio(outcomes)) >= bound)
        return int(decided[0]) if len(decided) else None

    def _ratio(self, outcomes: Sequence[bool]) -> np.ndarray:
        steps = (math.log(self.good / self.bad), math.log((1.0 - self.good) / (1.0 - self.bad)))
        return np.cumsum(np.where(np.asarray(outcomes, bool), *steps))


@dataclass(frozen=True)
class QuantileVerdict:
    """One figure against its limits."""

    name: str
    quantile: float
    value: float | None
    """The figure in that share of flights; None if no flight has it."""
    limit: str
    """In words."""
    passed: bool


@dataclass(frozen=True)
class Verdict:
    """What a campaign says."""

    answer: str
    """`GO`, `NO_GO` or `UNDECIDED`."""
    flown: int
    passed: int
    crashed: int
    interval: tuple[float, float]
    """Two-sided, of the probability of success."""
    lower: float
    """One-sided lower end, which is compared with `require.success`."""
    quantiles: tuple[QuantileVerdict, ...]
    reasons: tuple[str, ...]
    """Why, one sentence each."""


def judge(settings: CampaignFile, records: Sequence[Record]) -> Verdict:
    """Return the verdict of flights."""
    require = settings.require
    flown, passed = len(records), sum(record.passed for record in records)
    crashed = sum(record.outcome == CRASHED for record in records)
    interval = clopper_pearson(passed, flown, require.confidence) if flown else (0.0, 1.0)
    lower, upper = clopper_pearson(passed, flown, require.confidence, sides=1) if flown else (0.0, 1.0)
    quantiles = tuple(_quantile(name, limit, records) for name, limit in settings.quantiles.items())
    answer, reasons = _answer(settings, records, lower, upper)
    broken = [f"{one.name} is {_words(one.value)} at {one.quantile:.3g}, allowed: {one.limit}"
              for one in quantiles if not one.passed]  # fmt: skip
    if broken and flown:
        answer = NO_GO
    return Verdict(answer, flown, passed, crashed, interval, lower, quantiles, (*reasons, *broken))


def _answer(
    settings: CampaignFile, records: Sequence[Record], lower: float, upper: float
) -> tuple[str, tuple[str, ...]]:
    require, flown = settings.require, len(records)
    passed = sum(record.passed for record in records)
    facts = f"{passed} of {flown} flights succeeded"
    asked = f"{require.success:.4g} with confidence {require.confidence:.4g}"
    if not flown:
        return UNDECIDED, ("no flight was flown",)
    if settings.early_stop and flown < settings.flights:
        stop = stop_of(settings)
        answer = SequentialTest.about(require.success, stop).answer([one.passed for one in records])
        if answer != UNDECIDED:
            return answer, (f"{facts}; the sequential test decides so with errors of {stop.error:.3g}",)
    if lower >= require.success:
        return GO, (f"{facts}: the probability is at least {lower:.4f}, asked {asked}",)
    if upper < require.success:
        return NO_GO, (f"{facts}: the probability is at most {upper:.4f}, asked {asked}",)
    if flown < settings.flights:
        return UNDECIDED, (f"{facts} of {settings.flights}",)
    needed = least_flights(require.success, require.confidence)
    more = f"; {needed} flights without a failure would prove it" if passed == flown else ""
    return NO_GO, (f"{facts}: a probability of {lower:.4f} or more is proven, asked {asked}{more}",)


def stop_of(settings: CampaignFile) -> EarlyStop:
    """Return how a campaign ends early."""
    from crazychoir_fw.campaign.campaign import EarlyStop

    return EarlyStop() if isinstance(settings.early_stop, bool) else settings.early_stop


def least_flights(success: float, confidence: float) -> int:
    """Return how many flights without a failure prove a probability."""
    return math.ceil(math.log(1.0 - confidence) / math.log(success)) if success > 0.0 else 1


def _quantile(name: str, limit: QuantileLimit, records: Sequence[Record]) -> QuantileVerdict:
    """Compare; flights without the figure keep no limit."""
    ends = (("at most", limit.max), ("at least", limit.min))
    words = " and ".join(f"{word} {end:g}" for word, end in ends if end is not None)
    found = [record.figures.get(name) for record in records]
    known = [value for value in found if value is not None]
    if not known:
        return QuantileVerdict(name, limit.quantile, None, words or "any", False)
    missing = len(found) - len(known)
    highest = np.quantile([*known, *[math.inf] * missing], limit.quantile, method="higher")
    lowest = np.quantile([*known, *[-math.inf] * missing], 1.0 - limit.quantile, method="lower")
    passed = (limit.max is None or highest <= limit.max) and (limit.min is None or lowest >= limit.min)
    value = float(lowest if limit.max is None and limit.min is not None else highest)
    return QuantileVerdict(name, limit.quantile, value, words or "any", bool(passed))


def _words(value: float | None) -> str:
    return "not known" if value is None else f"{value:.4g}"


def figures_table(records: Sequence[Record]) -> Mapping[str, np.ndarray]:
    """Return all figures by name, shape (F,), NaN where a flight has none."""
    names = dict.fromkeys(name for record in records for name in record.figures)
    return {name: np.array([record.figures.get(name, math.nan) for record in records]) for name in names}
