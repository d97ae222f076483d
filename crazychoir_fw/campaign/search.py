"""Looks for the smallest deviation that makes a flight fail, and keeps it as a regression test."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import NormalDist
from typing import Any

import yaml

from crazychoir_fw.campaign.campaign import Campaign, Job
from crazychoir_fw.campaign.engines import Engine
from crazychoir_fw.campaign.flight import MARGIN, Record
from crazychoir_fw.common.errors import MissingLibraryError
from crazychoir_fw.common.replacing import replacing

FOLDER = "regressions"
_BATCH = 8
"""Flights that are chosen together: fixed, so that the search does not depend on the number of workers."""
_EXPLORES = 0.6
"""Share of the budget that looks for failures; the rest makes the nearest one smaller."""
_PASSED = 10.0
"""Score of a flight that succeeds, beside its margin; those that fail score their distance."""
_EDGE = 0.0005  # shares keep this far from 0 and 1
_NORMAL = NormalDist()

Shares = tuple[float, ...]


@dataclass(frozen=True)
class Finding:
    """The smallest deviation that was found to fail."""

    shares: Shares
    record: Record
    job: Job
    distance: float
    """Root of the sum of squares of the deviations, each in standard deviations of a normal variable."""
    keys: tuple[str, ...]
    """What deviates, the most first."""


class Search:
    """Asks Optuna where to look, and then takes away what is not needed to fail."""

    def __init__(self, campaign: Campaign, engine: Engine, tell: Callable[[int, int, int], None]) -> None:
        """Prepare.

        Args:
            campaign: What varies; `search.budget` flights are flown.
            engine: Engine that flies the tasks.
            tell: Called with flights that are over, of them passed, and all.
        """
        assert campaign.settings.search is not None
        self._campaign = campaign
        self._engine = engine
        self._tell = tell
        self._budget = campaign.settings.search.budget
        self.records: list[Record] = []
        """All flights, in order."""
        self._columns = len(campaign.varied)

    def run(self) -> Finding | None:
        """Search; returns None where nothing failed."""
        nominal = (0.5,) * self._columns
        self._fly([nominal])
        best = nominal if not self.records[0].passed else self._explore()
        if best is None:
            return None
        best = self._smaller(best)
        record, job = self._flown[best]
        ranked = sorted(range(self._columns), key=lambda k: -abs(_z(best[k])))
        keys = tuple(self._campaign.varied[k].key for k in ranked if best[k] != 0.5)
        return Finding(best, record, job, distance(best), keys)

    @property
    def _left(self) -> int:
        return self._budget - len(self.records)

    def _fly(self, points: Sequence[Shares]) -> list[Record]:
        """Fly at points; the seed is the campaign's, so that only the deviation differs."""
        if not hasattr(self, "_flown"):
            self._flown: dict[Shares, tuple[Record, Job]] = {}
        begin = len(self.records)
        jobs = []
        for offset, point in enumerate(points):
            values = self._campaign.values_at(point)
            job = self._campaign.job(0, values)
            jobs.append((Job(**{**vars(job), "number": begin + offset}), values))
        found = {record.number: record for record in self._engine(jobs)}
        ordered = [found[begin + offset] for offset in range(len(points))]
        for point, record, (job, _) in zip(points, ordered, jobs, strict=True):
            self._flown[point] = record, job
        self.records += ordered
        self._tell(len(self.records), sum(one.passed for one in self.records), self._budget)
        return ordered

    def _explore(self) -> Shares | None:
        """Look for failures, nearer and nearer ones; returns the nearest."""
        optuna = _optuna()
        study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=self._campaign.settings.seed))
        failed: list[Shares] = []
        while self._left > (1.0 - _EXPLORES) * self._budget:
            count = min(_BATCH, self._left)
            trials = [study.ask() for _ in range(count)]
            points = [
                tuple(trial.suggest_float(f"x{k}", _EDGE, 1.0 - _EDGE) for k in range(self._columns))
                for trial in trials
            ]
            for trial, point, record in zip(trials, points, self._fly(points), strict=True):
                study.tell(trial, score(record, point))
                if not record.passed:
                    failed.append(point)
        return min(failed, key=distance) if failed else None

    def _smaller(self, point: Shares) -> Shares:
        """Remove unneeded deviations, the smallest first, then halve the remaining ones."""
        for k in sorted(range(self._columns), key=lambda k: abs(_z(point[k]))):
            if self._left <= _BATCH:
                break
            if point[k] == 0.5:
                continue
            without = (*point[:k], 0.5, *point[k + 1 :])
            if not self._fly([without])[0].passed:
                point = without
        low, high = 0.0, 1.0
        while self._left > 0 and high - low > 0.02:
            middle = 0.5 * (low + high)
            shrunk = tuple(share if share == 0.5 else _NORMAL.cdf(middle * _z(share)) for share in point)
            if self._fly([shrunk])[0].passed:
                low = middle
            else:
                high, best = middle, shrunk
        return best if high < 1.0 else point


def _z(share: float) -> float:
    return _NORMAL.inv_cdf(min(max(share, 1e-9), 1.0 - 1e-9))


def distance(point: Shares) -> float:
    """Return how far shares are from the nominal flight."""
    return math.sqrt(sum(_z(share) ** 2 for share in point))


def score(record: Record, point: Shares) -> float:
    """Return what is to become small: the distance of a failure; of a success more than that of any, by its margin."""
    if not record.passed:
        return min(distance(point), _PASSED)
    return _PASSED + max(0.0, record.figures.get(MARGIN, 1.0))


def _optuna() -> Any:
    try:
        import optuna
    except ImportError:
        raise MissingLibraryError("a search needs Optuna: pip install 'crazychoir-fw[campaign]'") from None
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    return optuna


def write_finding(campaign: Campaign, finding: Finding, folder: Path) -> Path:
    """Write a failed flight as a regression test; `crazychoir campaign FOLDER` flies all flights of a folder."""
    path = folder / FOLDER / f"{campaign.name}_{finding.record.digest[:8]}.yaml"
    job = finding.job
    content = {
        "regression": list(finding.record.failures),
        "mission": str(Path(job.mission).resolve()),
        "seed": job.seed,
        "set": list(job.changes),
        "provider": job.provider,
        "app": None if job.app is None else list(job.app),
    }
    text = yaml.safe_dump(
        {key: value for key, value in content.items() if value is not None}, sort_keys=False, width=1000
    )
    with replacing(path) as temporary:
        temporary.write_text(
            f"# Found by a search; `{job.command}` flies it with log and plot.\n{text}", encoding="utf-8"
        )
    return path
