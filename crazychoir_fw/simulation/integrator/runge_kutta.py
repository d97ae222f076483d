"""The explicit Runge-Kutta method of degree 4."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Derivative = Callable[[float, Array], Array]


def rk4(derivative: Derivative, time: float, state: Array, dt: float) -> Array:
    """Return the state one step later.

    Args:
        derivative: Of time (s) and state.
        time: Time at the begin of the step (s).
        state: State there, any shape.
        dt: Length of the step (s).
    """
    k1 = derivative(time, state)
    k2 = derivative(time + 0.5 * dt, state + 0.5 * dt * k1)
    k3 = derivative(time + 0.5 * dt, state + 0.5 * dt * k2)
    k4 = derivative(time + dt, state + dt * k3)
    return state + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


def euler(derivative: Derivative, time: float, state: Array, dt: float) -> Array:
    """Return the state one forward Euler step later; arguments as of `rk4`."""
    return state + dt * derivative(time, state)
