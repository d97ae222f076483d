"""Fly a campaign: tasks out, records into the table, until all are there or the answer is clear."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from crazychoir_fw.campaign.campaign import Campaign, Job, check_ends
from crazychoir_fw.campaign.engines import Engine, Task
from crazychoir_fw.campaign.flight import Record
from crazychoir_fw.campaign.identity import identity_of
from crazychoir_fw.campaign.table import Table
from crazychoir_fw.campaign.verdict import UNDECIDED, SequentialTest, Verdict, judge, stop_of

Tell = Callable[[int, int, int], None]
"""Called with flights that are over, of them passed, and all."""


@dataclass(frozen=True)
class Outcome:
    """A campaign that is over, or was interrupted."""

    campaign: Campaign
    folder: Path
    records: list[Record]
    verdict: Verdict
    interrupted: bool = False
    identity: str = ""
    """Of all that decided what was flown when it began, see `identity_of`."""


def run(campaign: Campaign, folder: Path, engine: Engine, tell: Tell = lambda over, passed, total: None) -> Outcome:
    """Fly what is not in the table of a folder yet, and judge.

    Args:
        campaign: What flies.
        folder: Where the table is.
        engine: Engine that flies the tasks.
        tell: Called after every flight.

    Raises:
        CrazychoirError: If the campaign cannot be flown.
    """
    check_ends(campaign)
    rows = campaign.rows()
    with closing(Table(folder)) as table:
        known_as = identity_of(campaign)
        table.begin(known_as)
        known = table.numbers()
        watch = _Watch(campaign, {record.number: record.passed for record in table.records()}, len(rows))
        interrupted = False
        flying: dict[int, Job] = {}

        def tasks() -> Iterator[Task]:
            for number, values in enumerate(rows):
                if number not in known:
                    flying[number] = campaign.job(number, values)
                    yield flying[number], values

        flights = engine(tasks())
        try:
            if watch.end is None:
                for record in flights:
                    table.add(record, flying.pop(record.number))
                    watch.see(record)
                    tell(len(watch.passed), sum(watch.passed.values()), len(rows))
                    if watch.end is not None:
                        break
        except KeyboardInterrupt:
            interrupted = True
        finally:
            close = getattr(flights, "close", None)
            if close is not None:
                close()
        if watch.end is not None:
            table.forget_from(watch.end)  # which flights came after the decision depends on the machine
        records = [record for record in table.records() if record.number < len(rows)]
    return Outcome(campaign, folder, records, judge(campaign.settings, records), interrupted, known_as)


class _Watch:
    """Sees when a campaign may end early: by its first flights without a gap, so that order does not matter."""

    def __init__(self, campaign: Campaign, passed: dict[int, bool], total: int) -> None:
        self.passed = passed
        self.end: int | None = None
        """Number of the first flight that is not needed."""
        self._total = total
        settings = campaign.settings
        self._test = None
        if settings.early_stop:
            self._test = SequentialTest.about(settings.require.success, stop_of(settings))
        self._looked = 0
        self._look()

    def see(self, record: Record) -> None:
        self.passed[record.number] = record.passed
        self._look()

    def _look(self) -> None:
        if self._test is None or self.end is not None:
            return
        whole = self._looked
        while whole in self.passed:
            whole += 1
        if whole == self._looked:
            return
        self._looked = whole
        first = self._test.first([self.passed[k] for k in range(whole)])
        if first is not None and first + 1 < self._total:
            self.end = first + 1


def exit_code(outcomes: Sequence[Outcome]) -> int:
    """Return 0 for GO, 1 for NO-GO, 2 where that is not decided."""
    answers = {outcome.verdict.answer for outcome in outcomes}
    if any(outcome.interrupted for outcome in outcomes) or UNDECIDED in answers:
        return 2
    return 0 if answers == {"GO"} else 1
