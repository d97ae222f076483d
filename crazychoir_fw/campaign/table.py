"""The table of a campaign: one SQLite file, in which a flight is whole or not there."""

from __future__ import annotations

import hashlib
import json
import math
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from crazychoir_fw.campaign.campaign import Job
from crazychoir_fw.campaign.flight import Record
from crazychoir_fw.common.errors import StateError, UnknownNameError

FILE = "campaign.sqlite"
_RECORD = "number, outcome, vary, figures, failures, digest, sim_seconds, wall_seconds"
_SCHEMA = """
CREATE TABLE IF NOT EXISTS about (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS flights (
  number INTEGER PRIMARY KEY, outcome TEXT NOT NULL, vary TEXT NOT NULL, figures TEXT NOT NULL,
  failures TEXT NOT NULL, digest TEXT NOT NULL, sim_seconds REAL NOT NULL, wall_seconds REAL NOT NULL,
  job TEXT NOT NULL);
"""


class Table:
    """Completed flights; each is stored before the next one is reported."""

    def __init__(self, folder: Path) -> None:
        """Open, or begin, the table of a folder.

        Raises:
            StateError: If the file is no such table, or cannot be written.
        """
        folder.mkdir(parents=True, exist_ok=True)
        self.path = folder / FILE
        with self._said():
            self._file = sqlite3.connect(self.path, isolation_level=None)
            self._file.execute("PRAGMA journal_mode=WAL")
            self._file.execute("PRAGMA synchronous=NORMAL")  # a killed process loses nothing; a power cut the last ones
            self._file.executescript(_SCHEMA)

    @contextmanager
    def _said(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            if "is full" in str(error):  # Python 3.10 has no codes of SQLite
                raise StateError(
                    f"{self.path}: the disk is full; all flights that are over are kept, "
                    "and the same command goes on when there is room"
                ) from None
            raise StateError(f"{self.path}: {error}") from None

    def close(self) -> None:
        """Close it; the file is then one file."""
        with self._said():
            self._file.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            self._file.close()

    def begin(self, identity: str) -> None:
        """Note which campaign it is.

        Raises:
            StateError: If flights of another campaign are there already.
        """
        with self._said():
            known = self._file.execute("SELECT value FROM about WHERE key = 'campaign'").fetchone()
            if known is not None and known[0] != identity:
                raise StateError(
                    f"{self.path} has flights of another campaign, or of files that were changed since; "
                    "choose another folder with --out, or remove it"
                )
            self._file.execute("INSERT OR REPLACE INTO about VALUES ('campaign', ?)", (identity,))

    def add(self, record: Record, job: Job) -> None:
        """Keep a flight, and how to fly it again."""
        row = (
            record.number, record.outcome, json.dumps(record.values), json.dumps(record.figures),
            json.dumps(record.failures), record.digest, record.sim_seconds, record.wall_seconds,
            json.dumps(vars(job)),
        )  # fmt: skip
        with self._said():
            self._file.execute("INSERT OR REPLACE INTO flights VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)", row)

    def forget_from(self, number: int) -> None:
        """Remove the flights from a number on."""
        with self._said():
            self._file.execute("DELETE FROM flights WHERE number >= ?", (number,))

    def numbers(self) -> set[int]:
        """Return which flights are there."""
        with self._said():
            return {row[0] for row in self._file.execute("SELECT number FROM flights")}

    def job(self, number: int) -> Job | None:
        """Return how to fly a flight again; None if there is none of that number."""
        with self._said():
            row = self._file.execute("SELECT job FROM flights WHERE number = ?", (number,)).fetchone()
        if row is None:
            return None
        given = json.loads(row[0])
        app = given.pop("app")
        return Job(**{**given, "changes": tuple(given["changes"])}, app=None if app is None else tuple(app))

    def records(self) -> list[Record]:
        """Return all flights by number."""
        with self._said():
            return [_record(row) for row in self._file.execute(f"SELECT {_RECORD} FROM flights ORDER BY number")]


def _record(row: tuple[Any, ...]) -> Record:
    number, outcome, values, figures, failures, digest, sim_seconds, wall_seconds = row
    return Record(
        number, outcome, json.loads(values), json.loads(figures), tuple(json.loads(failures)), digest,
        sim_seconds, wall_seconds,
    )  # fmt: skip


def read_flight(folder: Path, number: int) -> tuple[Record, Job]:
    """Return a flight of a campaign's folder, and how to fly it again.

    Raises:
        StateError: If there is no table.
        UnknownNameError: If it has no such flight.
    """
    if not (folder / FILE).is_file():
        raise StateError(f"{folder} is no folder of a campaign: there is no {FILE}")
    with closing(Table(folder)) as table:
        job = table.job(number)
        if job is None:
            raise UnknownNameError(f"{table.path} has no flight {number}, but {len(table.numbers())} others")
        return next(record for record in table.records() if record.number == number), job


def hash_of(records: Iterable[Record]) -> str:
    """Return a digest of a table that does not depend on machine, workers, order or engine."""
    digest = hashlib.sha256()
    for record in sorted(records, key=lambda one: one.number):
        figures = {name: value if math.isfinite(value) else str(value) for name, value in record.figures.items()}
        said = [record.number, record.outcome, record.values, figures, record.failures, record.digest]
        digest.update(json.dumps(said, sort_keys=True).encode())
    return digest.hexdigest()
