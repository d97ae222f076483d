"""How motors fade as they get warm: a loss that all have in common, and what the harder working ones lose besides.

Common: the force that the motion demands over that of a model without heat falls while a drone flies. Each flight has a
scale of its own. The heat follows the thrust that is delivered, and that is what the motion demands.
Own: the torque that is missing, on the torque of motors that fade by their own warmth less the mean of the four.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.comparison.signals import Array, smooth

SIDES_X, SIDES_Y = np.array([1.0, -1.0, -1.0, 1.0]), np.array([-1.0, -1.0, 1.0, 1.0])
"""Signs of the places of the motors M1 to M4."""

_TIMES = (3.0, 4.0, 5.0, 6.0, 8.0, 10.0)  # [s], common
_OWN_TIMES = (1.0, 1.5, 2.0, 3.0, 5.0)  # [s]
_BIN = 50  # rows of half a second, over which force errors are averaged
_GREATEST_LOSS = 0.3


def warmth(thrust: Array, heat_thrust: float, time: float, period: float) -> Array:
    """Return the warmth of motors that begin cold, from the thrust that they deliver.

    Args:
        thrust: One motor (N), shape (T,) or (T, n).
        heat_thrust: Thrust (N) that leads to a warmth of 1.
        time: Time constant (s).
        period: Time between rows (s).
    """
    heat = (thrust / heat_thrust) ** 2
    kept = np.exp(-period / time)
    result = np.empty_like(heat)
    value = np.zeros_like(heat[0])
    for row, now in enumerate(heat):
        value = now + (value - now) * kept
        result[row] = value
    return result


def common_heat(
    flights: Sequence[tuple[Array, Array, NDArray[np.bool_]]], heat_thrust: float, period: float
) -> tuple[float, float]:
    """Return loss and time constant (s) that all four motors have in common.

    Args:
        flights: Of each the demanded force (N), the thrust of a model without heat (N), and the rows to look at.
        heat_thrust: See `warmth`.
        period: Time between rows (s).
    """

    def fit(time: float) -> tuple[float, float]:
        """Return loss and mean square of what is left, the scale of each flight being free."""
        ratios, colds = [], []
        for needed, thrust, rows in flights:
            cold = 1.0 - warmth(thrust * (needed[rows].mean() / thrust[rows].mean()) / 4.0, heat_thrust, time, period)
            ratio = _binned(needed[rows]) / _binned(thrust[rows])
            ratios.append(ratio / ratio.mean() - 1.0)
            colds.append(_binned(cold[rows]) - _binned(cold[rows]).mean())
        y, x = np.concatenate(ratios), np.concatenate(colds)
        loss = float(np.clip(x @ y / (x @ x), 0.0, _GREATEST_LOSS))
        return loss, float(np.mean((y - loss * x) ** 2))

    time = min(_TIMES, key=lambda time: fit(time)[1])
    return fit(time)[0], time


def own_heat(
    flights: Sequence[tuple[Array, Array, Array, NDArray[np.bool_]]],
    heat_thrust: float,
    arms: tuple[float, float],
    width: int,
    period: float,
) -> tuple[float, float]:
    """Return the loss of motors that work harder than the others, and its time constant (s).

    Args:
        flights: Of each the missing torque (N m), shape (T, 3), the thrusts of the motors in a model without that loss
            (N), shape (T, 4), what the torque is explained by already, shape (T, 2), one column per axis, and the rows.
        heat_thrust: See `warmth`.
        arms: Distance of the motors from the axes, x and y (m).
        width: Rows of the smoothing.
        period: Time between rows (s).
    """

    def fit(time: float) -> tuple[float, float]:
        ys, xs = [], []
        for torque, thrusts, known, rows in flights:
            warm = warmth(thrusts, heat_thrust, time, period)
            lost = thrusts * (warm - warm.mean(axis=1, keepdims=True))
            columns = (-arms[1] * lost @ SIDES_Y, arms[0] * lost @ SIDES_X)
            for axis, column in enumerate(columns):
                design = np.column_stack([smooth(known[:, axis], width)[rows], np.ones(rows.sum())])
                ys.append(_apart(smooth(torque[:, axis], width)[rows], design))
                xs.append(_apart(smooth(column, width)[rows], design))
        y, x = np.concatenate(ys), np.concatenate(xs)
        loss = float(np.clip(x @ y / (x @ x), 0.0, _GREATEST_LOSS))
        return loss, float(np.mean((y - loss * x) ** 2))

    time = min(_OWN_TIMES, key=lambda time: fit(time)[1])
    return fit(time)[0], time


def _apart(values: Array, columns: Array) -> Array:
    """Return what columns do not explain of values."""
    return values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0]


def _binned(values: Array) -> Array:
    count = len(values) // _BIN
    return values[: count * _BIN].reshape(count, _BIN).mean(axis=1)
