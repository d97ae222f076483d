"""Limits of numbers."""

from __future__ import annotations

import math

from crazychoir_fw.common.errors import RangeError


def limited(value: float, limit: float) -> float:
    """Return the value, cut to [-limit, limit]."""
    return min(max(value, -limit), limit)


def positive(name: str, value: float) -> None:
    """Refuse what is not a finite number above 0.

    Raises:
        RangeError: If it is not.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not (math.isfinite(value) and value > 0.0):
        raise RangeError(f"{name} is {value!r}, allowed: a number above 0")
