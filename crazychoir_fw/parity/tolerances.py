"""How far two providers may be apart, per class of signals, and why: `tolerances.yaml` is the one table.

A sample is within tolerance when it is near enough by one of the measures: units in the last place, absolutely, or
relative to the largest magnitude of its signal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.common.plain_yaml import read_yaml


@dataclass(frozen=True)
class Tolerance:
    """One class of signals."""

    name: str
    """Name of the class, as reports show it."""
    patterns: tuple[str, ...]
    """Names of signals that belong to it; a star stands for anything."""
    reason: str
    """Why that much, in one sentence."""
    absolute: float = 0.0
    """In the unit of the signal."""
    unit: str = ""
    """That unit, for people."""
    ulps: int = 0
    """Units in the last place of float32; means nothing to whole numbers."""
    relative: float = 0.0
    """Share of the largest magnitude of the reference's signal."""
    turn: float = 0.0
    """Angles: what a full turn is, so that both sides of the wrap are neighbors; 0 for other signals."""
    is_judged: bool = True
    """False: measured and shown, but without a say in the verdict."""


def _read() -> dict[str, tuple[Tolerance, ...]]:
    tables = read_yaml(Path(__file__).with_suffix(".yaml"), CrazychoirError)
    return {
        name: tuple(Tolerance(**{**row, "patterns": tuple(row["patterns"])}) for row in rows)
        for name, rows in tables.items()
    }


_TABLES = _read()

REPLAY = _TABLES["replay"]
"""Both providers on the same recorded inputs: nothing feeds a deviation back but the state of the function itself."""

FLIGHT = _TABLES["flight"]
"""Whole flights, each provider in its own loop."""

OWN_LOOP = (*_TABLES["own_loop"], *FLIGHT[-3:])
"""Whole flights of a candidate that brings its own stabilizer loop, from take-off on."""

WHOLE = Tolerance("decision", ("*",), "a state, a mode, a count or a yes or no is the same or it is not")
"""Whole numbers that no other class names."""


def tolerance_of(signal: str, dtype: np.dtype, table: Sequence[Tolerance] = REPLAY) -> Tolerance:
    """Return the class of a signal.

    Args:
        signal: Its name.
        dtype: Its type; whole numbers of a replay that no class names must be equal.
        table: `REPLAY` or `FLIGHT`, both of which end with a class for everything.
    """
    found = next(row for row in table if any(fnmatchcase(signal, pattern) for pattern in row.patterns))
    catches_all = found.patterns in (("*",), ("log.*",))
    return WHOLE if table is REPLAY and catches_all and np.dtype(dtype).kind in "biu" else found
