"""Two of anything on the same variations and seeds: what the second one changes, flight by flight."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from crazychoir_fw.campaign.campaign import Campaign, Variant, backend_of
from crazychoir_fw.campaign.flight import FAILED, PASSED, Record
from crazychoir_fw.campaign.revision import checkout_at
from crazychoir_fw.campaign.run import Outcome
from crazychoir_fw.campaign.sensitivity import Influence, blame
from crazychoir_fw.campaign.verdict import NO_GO
from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.firmware.checkout import VARIABLE
from crazychoir_fw.mission.loader import load_mission

CONFIDENCE = 0.95
"""Of the intervals of differences, and of the statement that the second one is worse."""


@dataclass(frozen=True)
class Difference:
    """How a figure differs, second less first, over the flights that have it in both."""

    figure: str
    before: float
    after: float
    """Means."""
    low: float
    high: float
    """Interval of the mean difference."""
    flights: int

    @property
    def is_clear(self) -> bool:
        """Whether the interval leaves zero out."""
        return self.low > 0.0 or self.high < 0.0


@dataclass(frozen=True)
class Comparison:
    """What two variants of a campaign say together."""

    before: Outcome
    after: Outcome
    differences: tuple[Difference, ...]
    broken: tuple[int, ...]
    """Flights that succeeded before, and not after."""
    mended: tuple[int, ...]
    """Flights that succeeded after, and not before."""
    p: float
    """Probability of so uneven changes of verdicts if nothing differed (exact test of McNemar)."""

    @property
    def answer(self) -> str:
        """`GO` if the second one is GO by itself and not clearly worse than the first."""
        worse = len(self.broken) > len(self.mended) and self.p < 1.0 - CONFIDENCE
        return NO_GO if worse else self.after.verdict.answer

    @property
    def sentence(self) -> str:
        """The answer with its reasons."""
        changed = f"{len(self.broken)} flights broken, {len(self.mended)} mended (p = {self.p:.2g})"
        return f"{self.after.verdict.reasons[0]}; {changed}" if self.after.verdict.reasons else changed


def variants_of(campaign: Campaign) -> dict[str, Campaign]:
    """Return the two sides of a comparison, by name.

    Raises:
        MissionError: If one of them cannot be flown.
    """
    compare = campaign.settings.compare
    assert compare is not None
    return {name: _as(campaign, variant) for name, variant in (("before", compare.before), ("after", compare.after))}


def checkout_of(campaign: Campaign, variant: Variant) -> str | None:
    """Return the folder of the checkout that a variant flies, at its revision; None where it names none."""
    if variant.checkout is None and variant.revision is None:
        return None
    named = os.environ.get(VARIABLE) if variant.checkout is None else str(campaign.file.parent / variant.checkout)
    if named is None:
        raise MissionError(f"{campaign.file}: a revision needs checkout, or {VARIABLE}, the folder of the repository")
    folder = Path(named).resolve()
    return str(folder if variant.revision is None else checkout_at(folder, variant.revision))


def _as(campaign: Campaign, variant: Variant) -> Campaign:
    file = campaign.mission_file if variant.mission is None else campaign.file.parent / variant.mission
    app = None if variant.app is None else [campaign.file.parent / one for one in variant.app]
    changes = [*campaign.settings.set, *variant.set]
    backend = backend_of(file, changes)
    mission = load_mission(file, changes=changes, provider=variant.provider, app=app, backend=backend)
    return replace(campaign, variant=variant, mission=mission, checkout=checkout_of(campaign, variant), backend=backend)


def culprits(both: Comparison) -> list[Influence]:
    """Return what brings the change out, see `blame`: influences on broken verdicts and on differences of figures.

    Influences that a value has on either side cancel, such as that of the charge on the voltage.
    """
    first, second = ({record.number: record for record in one.records} for one in (both.before, both.after))
    changes = [
        replace(
            second[number],
            outcome=FAILED if number in both.broken else PASSED,
            figures={
                name: value - first[number].figures[name]
                for name, value in second[number].figures.items()
                if name in first[number].figures
            },
        )
        for number in sorted(first.keys() & second.keys())
    ]
    return blame(both.after.campaign, changes)


def compare(before: Outcome, after: Outcome) -> Comparison:
    """Compare flights of the same numbers."""
    first, second = ({record.number: record for record in one.records} for one in (before, after))
    both = sorted(first.keys() & second.keys())
    broken = tuple(n for n in both if first[n].passed and not second[n].passed)
    mended = tuple(n for n in both if second[n].passed and not first[n].passed)
    pairs = [(first[n], second[n]) for n in both]
    return Comparison(before, after, tuple(_differences(pairs)), broken, mended, mcnemar(len(broken), len(mended)))


def mcnemar(broken: int, mended: int) -> float:
    """Return the two-sided exact probability of so uneven changes, if either way were as likely."""
    from scipy.stats import binomtest

    return float(binomtest(broken, broken + mended).pvalue) if broken + mended else 1.0


def _differences(pairs: Sequence[tuple[Record, Record]]) -> list[Difference]:
    from scipy.stats import t

    found = []
    for name in dict.fromkeys(name for one, _ in pairs for name in one.figures):
        values = np.array([
            (one.figures[name], other.figures[name])
            for one, other in pairs if name in one.figures and name in other.figures
        ])  # fmt: skip
        if len(values) < 2:
            continue
        change = values[:, 1] - values[:, 0]
        half = float(t.ppf(0.5 + CONFIDENCE / 2.0, len(change) - 1) * change.std(ddof=1) / math.sqrt(len(change)))
        mean = float(change.mean())
        first, second = (float(one) for one in values.mean(axis=0))
        found.append(Difference(name, first, second, mean - half, mean + half, len(change)))
    return sorted(found, key=lambda one: not one.is_clear)
