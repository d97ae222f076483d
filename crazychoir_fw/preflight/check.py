"""One line of a list of checks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.mission.backend_settings import SafetyBox

_LISTED = 3


@dataclass(frozen=True)
class Check:
    """One line of the list."""

    name: str
    ok: bool
    text: str
    """What was found, or which drones are not ready and why."""


def check(name: str, problems: Sequence[str], good: str) -> Check:
    """Return the line: good without problems, otherwise the first of them."""
    more = f" and {len(problems) - _LISTED} more" if len(problems) > _LISTED else ""
    return Check(name, not problems, "; ".join(problems[:_LISTED]) + more if problems else good)


def safety_area(area: SafetyBox, names: Sequence[str], position: NDArray[np.float64]) -> Check:
    """Return whether drones stand in the safety area.

    Args:
        area: The area.
        names: Of the drones.
        position: Where they are (m, world), shape (N, 3).
    """
    inside = np.all((position >= area.low) & (position <= area.high), axis=1)
    return check("safety area", [f"{names[int(k)]} is outside" for k in np.flatnonzero(~inside)], "all are inside")
