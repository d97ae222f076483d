"""Reads CSV files, plain or gzip: what scripts with cflib write, exports of spreadsheets, and the NanoBench set."""

from __future__ import annotations

import csv
import gzip
import zlib
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.comparison.raw_log import MAX_BYTES, RawLog, table_of

SUFFIXES = (".csv", ".csv.gz", ".txt", ".tsv")
_DELIMITERS = ",;\t"


def read_csv(path: Path) -> RawLog:
    """Return the columns of a file with a header line; cells that are no numbers are NaN.

    Raises:
        RangeError: If it is no such file.
    """
    opener = gzip.open if path.suffix == ".gz" else open
    try:
        with opener(path, "rt", newline="", encoding="utf-8-sig") as file:
            lines = limited(file)
            first = next(iter(lines), "")
            delimiter = max(_DELIMITERS, key=first.count)
            header = [name.strip().lstrip("#").strip() for name in next(csv.reader([first], delimiter=delimiter), [])]
            rows = [row for row in csv.reader(lines, delimiter=delimiter) if row]
    except (OSError, EOFError, UnicodeDecodeError, csv.Error, zlib.error) as error:
        raise RangeError(f"{path.name}: cannot be read: {error}") from error
    if not header or all(_is_number(name) for name in header):
        raise RangeError(f"{path.name}: its first line names no columns")
    if not rows:
        raise RangeError(f"{path.name}: no rows")
    places = {name: header.index(name) for name in header if name}
    table = {name: np.array([number(row, place) for row in rows]) for name, place in places.items()}
    return RawLog(_name(path), "CSV", (table_of(path.name, table),))


def _name(path: Path) -> str:
    return path.name.removesuffix(".gz").rsplit(".", 1)[0]


def limited(lines: Iterable[str]) -> Iterable[str]:
    """Pass lines on, but not more than any flight has: a small file can unpack to a very large one."""
    total = 0
    for line in lines:
        total += len(line)
        if total > MAX_BYTES:
            raise csv.Error(f"longer than {MAX_BYTES} bytes")
        yield line


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def number(row: list[str], place: int) -> float:
    """Return a cell as a number; NaN if it is missing, no number, or larger than anything that flies."""
    try:
        found = float(row[place])
    except (ValueError, IndexError):
        return np.nan
    return found if abs(found) < 1e15 else np.nan
