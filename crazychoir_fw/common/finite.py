"""Commands are numbers that drones can hold (32-bit floats): what is none is refused by name."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError

LARGEST = 3.4028234e38
"""About the largest number of 32 bits; more becomes infinite on board, and fits into no packet."""


def finite(who: str, **values: object) -> list[float]:
    """Return the values as floats.

    Args:
        who: Name of the drone that the command is for, in the error.
        values: The values by their names.

    Raises:
        RangeError: If one is not a finite real number, or larger than a drone can hold; the message names drone, value
            and what is allowed.
    """
    numbers = []
    for name, value in values.items():
        # floats first, also those of NumPy: nearly all commands are
        if not (isinstance(value, float) and -LARGEST <= value <= LARGEST):
            value = _checked(who, name, value)
        numbers.append(float(value))
    return numbers


def _checked(who: str, name: str, value: object) -> Real:
    # NumPy's scalars and arrays of one number come out of most control laws
    number = value.item() if isinstance(value, np.ndarray | np.generic) and value.size == 1 else value
    if not isinstance(number, Real) or isinstance(number, bool) or not -LARGEST <= number <= LARGEST:
        raise RangeError(f"{who}: {name} is {_shown(value)}, allowed: a finite number")
    return number


def three(who: str, name: str, values: object) -> Sequence[object]:
    """Return a vector of three.

    Raises:
        RangeError: If it has another shape.
    """
    shape = np.shape(values) if not isinstance(values, str) else ()
    if shape != (3,):
        raise RangeError(f"{who}: {name} is {_shown(values)}, allowed: three finite numbers")
    return list(values)  # type: ignore[call-overload]


def _shown(value: object) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:60]}…"


def are_finite(*arrays: NDArray[np.float64]) -> bool:
    """Tell whether all numbers are finite: by their squares, which cost a third of looking at each, or one by one."""
    return math.isfinite(sum(float(np.vdot(array, array)) for array in arrays)) or all(
        bool(np.isfinite(array).all()) for array in arrays
    )


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
