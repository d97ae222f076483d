"""Between newtons and the thrust of a setpoint, in simulation and over the radio."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real

import numpy as np

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.onboard.core import platform_names

_FULL_THRUST = 65535.0

ThrustWord = str | float | Sequence[Sequence[float]]
"""A platform, the thrust at full command (N), or a measured curve: rows of newtons and counts."""


def thrust_counts(newtons: float, max_thrust: float) -> float:
    """Return the thrust of a setpoint, in [0, 65535], for a thrust of all rotors together.

    The mixer hands it to every motor, and the battery compensation inverts the thrust curve of the platform, so that
    full scale is the full thrust of a motor whatever the charge.

    Args:
        newtons: Thrust (N).
        max_thrust: Thrust at full command (N).
    """
    return min(max(newtons / max_thrust, 0.0), 1.0) * _FULL_THRUST


def platform_max_thrust(platform: str) -> float:
    """Return the thrust of all rotors of a platform at full command (N).

    Raises:
        UnknownNameError: If there is no such platform.
    """
    return 4.0 * float(_facts(platform).thrust.thrust_max)


class ThrustCalibration:
    """How many counts of the thrust of a setpoint are how many newtons.

    Args:
        word: A platform (``"cf2"``, ``"cf21bl"``: its thrust curve, which the onboard battery compensation inverts),
            the thrust of all rotors at full command (N), or a curve of your own: at least two rows of newtons and
            counts, both rising. For instance ``[(0, 0), (0.39, 42000)]`` is a line through one measurement.

    Raises:
        RangeError: If it is none of these.
        UnknownNameError: If there is no such platform.
    """

    def __init__(self, word: ThrustWord = "cf2") -> None:
        if isinstance(word, str):
            word = platform_max_thrust(word)
        if isinstance(word, Real) and not isinstance(word, bool):
            if not (math.isfinite(word) and word > 0.0):
                raise RangeError(f"thrust is {word!r}, allowed: newtons at full command, above 0")
            word = [(0.0, 0.0), (float(word), _FULL_THRUST)]
        self._newtons, self._counts = _curve(word)

    @property
    def max_newtons(self) -> float:
        """Thrust at full command (N); a curve that ends below is continued in its last direction."""
        return self._at(_FULL_THRUST, self._counts, self._newtons)

    def counts(self, newtons: float) -> float:
        """Return the counts for a thrust of all rotors (N), within [0, 65535]."""
        return min(max(self._at(newtons, self._newtons, self._counts), 0.0), _FULL_THRUST)

    def newtons(self, counts: float) -> float:
        """Return the thrust of all rotors (N) for counts in [0, 65535]."""
        return max(self._at(counts, self._counts, self._newtons), 0.0)

    @staticmethod
    def _at(value: float, xs: np.ndarray, ys: np.ndarray) -> float:
        """Piecewise linear, continued at both ends."""
        i = min(max(int(np.searchsorted(xs, value)) - 1, 0), len(xs) - 2)
        return float(ys[i] + (value - xs[i]) * (ys[i + 1] - ys[i]) / (xs[i + 1] - xs[i]))


def platform_weight(platform: str) -> float:
    """Return the weight that the onboard software of a platform believes in (N).

    Raises:
        UnknownNameError: If there is no such platform.
    """
    return 9.81 * float(_facts(platform).mass)


def _facts(platform: str):
    names = platform_names()
    if platform not in names:
        raise UnknownNameError(f"there is no platform '{platform}', allowed: {', '.join(names)}")
    return lib.cf_platform_facts(names.index(platform))


def _curve(rows: object) -> tuple[np.ndarray, np.ndarray]:
    try:
        table = np.array(rows, float)
    except (TypeError, ValueError):
        table = np.empty(0)
    if table.ndim != 2 or table.shape[0] < 2 or table.shape[1] != 2 or not np.all(np.isfinite(table)):
        raise RangeError(f"thrust is {rows!r}, allowed: a platform, newtons at full command, or rows (newtons, counts)")
    if not np.all(np.diff(table, axis=0) > 0.0):
        raise RangeError(f"thrust is {rows!r}, allowed: rows whose newtons and counts both rise")
    return table[:, 0], table[:, 1]
