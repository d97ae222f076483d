"""Which flights went worst."""

from __future__ import annotations

from collections.abc import Sequence

from crazychoir_fw.campaign.flight import CRASHED, MARGIN, Record


def worst_of(records: Sequence[Record], count: int = 10) -> list[Record]:
    """Return the worst flights: crashed ones, failed ones, then those with the least margin."""

    def badness(record: Record) -> tuple[int, float, int]:
        rank = 0 if record.outcome == CRASHED else 1 if not record.passed else 2
        return rank, record.figures.get(MARGIN, float("inf")), record.number

    return sorted(records, key=badness)[:count]
