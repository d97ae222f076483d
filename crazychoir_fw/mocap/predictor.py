"""Estimates of poses between two samples: the filtered derivative, and the prediction of one stage."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError

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


_H = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])


class SingleStagePredictor:
    """Kalman predictor of one step for a double integrator in the plane, state (x, vx, y, vy)."""

    def __init__(
        self,
        dt: float = 0.01,
        dt_dyn: float = 0.01,
        sigma_u: float = 10.0,
        sigma_m: float = 1e-4,
        x0: ArrayLike | None = None,
        PP0: ArrayLike | None = None,
    ) -> None:
        """Choose the model.

        Args:
            dt: Step between samples, by which positions move (s).
            dt_dyn: Time over which an acceleration changes the velocity (s). What the original uses it for is not
                established; with its default both readings agree.
            sigma_u: Standard deviation of the acceleration (m/s^2).
            sigma_m: Standard deviation of a measured position (m).
            x0: State at the start, shape (4,); None is zero.
            PP0: Its covariance, shape (4, 4); None is zero.

        Raises:
            RangeError: If a number is outside its range.
        """
        for name, value in (("dt", dt), ("dt_dyn", dt_dyn), ("sigma_u", sigma_u), ("sigma_m", sigma_m)):
            if not (math.isfinite(value) and value > 0.0):
                raise RangeError(f"{name} is {value}, allowed: above 0")
        self._F = np.kron(np.eye(2), [[1.0, dt], [0.0, 1.0]])
        G = np.kron(np.eye(2), [[0.0], [dt_dyn]])
        self._Q = sigma_u**2 * G @ G.T
        self._R = sigma_m**2 * np.eye(2)
        self.state: Array = _shaped("x0", np.zeros(4) if x0 is None else x0, (4,))
        """Predicted x, vx, y, vy (m, m/s)."""
        self.covariance: Array = _shaped("PP0", np.zeros((4, 4)) if PP0 is None else PP0, (4, 4))
        """Covariance of the state."""
        self.gain: Array = np.zeros((4, 2))
        """Gain of the last step."""

    def step(self, measured: ArrayLike) -> Array:
        """Take a measured x, y (m) and return the state predicted for the next sample, shape (4,).

        Raises:
            RangeError: If they are not two finite numbers.
        """
        z = _shaped("measured", measured, (2,))
        F, P = self._F, self.covariance
        K = self.gain = np.linalg.solve((_H @ P @ _H.T + self._R).T, (F @ P @ _H.T).T).T
        kept = F - K @ _H
        self.state = kept @ self.state + K @ z
        self.covariance = kept @ P @ kept.T + K @ self._R @ K.T + self._Q
        return self.state


def _shaped(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
    array = np.array(values, float)
    if array.shape != shape or not np.all(np.isfinite(array)):
        raise RangeError(f"{name} is {str(values)[:60]}, allowed: finite numbers of shape {shape}")
    return array
