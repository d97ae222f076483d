"""A log as its file has it: columns by name, on the clocks of their tables, before their meaning is known."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError

Array = NDArray[np.float64]

MAX_BYTES = 400_000_000
"""A file, unpacked, may be as large (bytes)."""

_SHOWN = 12


@dataclass(frozen=True)
class RawLog:
    """What a file holds."""

    name: str
    """Of the file, without its suffix."""
    format: str
    """Such as ``CSV``."""
    tables: tuple[Mapping[str, Array], ...]
    """Columns by name; those of a table are of one length, and one or more of them is a clock."""
    notes: tuple[str, ...] = ()
    """What was left out, and why."""

    @property
    def columns(self) -> list[str]:
        """Names of all columns."""
        return list(dict.fromkeys(name for table in self.tables for name in table))

    def shown_columns(self) -> str:
        """Return some of the names, for messages."""
        names = self.columns
        more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
        return ", ".join(name[:40] for name in names[:_SHOWN]) + more


def alike(name: str) -> str:
    """Return a name as names are compared: ``stateEstimate.x``, ``StateEstimate/x`` and ``stateestimate_x`` are one."""
    return re.sub(r"[./\s:]+", "_", name.strip().lower()).strip("_")


def table_of(name: str, columns: Mapping[str, Iterable[float]]) -> dict[str, Array]:
    """Return a table of numbers.

    Raises:
        RangeError: If columns have different lengths.
    """
    table = {key: np.asarray(values, float) for key, values in columns.items()}
    lengths = {len(values) for values in table.values()}
    if len(lengths) > 1:
        raise RangeError(f"{name}: columns have {min(lengths)} to {max(lengths)} rows, but must have one length")
    return table
