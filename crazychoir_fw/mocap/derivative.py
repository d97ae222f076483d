"""The derivative with a low-pass behind it, by which velocities come out of poses (docs/reference/crazychoir.md#10)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEGACY_STEP = 0.01
"""Step that the original takes for granted (s)."""
_LEGACY_POLE = 0.6

TIME_CONSTANT = -LEGACY_STEP / math.log(_LEGACY_POLE)
"""Time constant (s), 19.6 ms, by which the filter at 100 Hz is that of the original."""


class FilteredDerivative:
    """Low-passed slope of samples that come at any times, of any number of vectors at once.

    Between two samples the slope is constant: then the low-pass of first order has the exact solution
    ``v = a v + (1 - a) slope``, ``a = exp(-dt / time_constant)``, whatever the steps are. Where they are 10 ms that is
    ``v = 0.6 v + 40 (p - p_before)``: the two cascaded sections of the original, whose pole and zero at -1 cancel.
    """

    def __init__(self, time_constant: float = TIME_CONSTANT) -> None:
        """Choose the time constant (s); 0 is the plain slope."""
        self._time_constant = time_constant
        self.value: Array = np.zeros(0)
        """Derivative, shape (n, k)."""

    def begin(self, shape: tuple[int, ...]) -> None:
        """Forget everything."""
        self.value = np.zeros(shape)

    def update(self, change: Array, dt: Array, who: Array) -> None:
        """Take new samples.

        Args:
            change: By how much the samples changed, shape (n, k).
            dt: Since when (s), shape (n,), above 0 where `who` is.
            who: Which ones there are, shape (n,) of bool.
        """
        dt = np.where(who, dt, 1.0)[:, None]
        keep = np.exp(-dt / self._time_constant) if self._time_constant > 0.0 else np.zeros_like(dt)
        self.value = np.where(who[:, None], keep * self.value + (1.0 - keep) * change / dt, self.value)
