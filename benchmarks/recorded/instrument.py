"""Time constant of the motors and inertia, by an instrument: the attitude that the controller asks for.

A free fit of torque on commands is biased in closed loop: the controller answers every disturbance, and markers jitter.
The desired attitude comes from the position loop; it moves the motors, and is almost free of both. So the model must be
right only in what goes with the desired attitude of the last 0.4 s (two-stage least squares):

    torque of the model = inertia * angular acceleration + moment of flight * thrust * speed + constant

The time constant is the one that leaves least of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crazychoir_fw.comparison.signals import Array, at, smooth

_LAGS = np.arange(0.0, 0.41, 0.04)  # [s], of the instrument
_NARROW, _WIDE = 4, 60  # rows of smoothing: 3 dB at 3.3 and 0.2 Hz


@dataclass(frozen=True)
class Torques:
    """One axis of one flight, on the rows that count."""

    model: Array
    """Torque of the model (N m), shape (T,)."""
    motion: Array
    """Angular acceleration (rad/s²), and thrust in weights times speed (m/s), shape (T, 2)."""
    instrument: Array
    """Desired roll and pitch of several moments (deg), shape (T, n)."""


def torques(time: Array, model: Array, motion: Array, desired: Array, rows: Array) -> Torques:
    """Return the parts of one axis that vary within seconds.

    Args:
        time: Clock (s), shape (T,).
        model: See `Torques`, all rows.
        motion: See `Torques`, all rows.
        desired: Desired roll and pitch (deg) on that clock, shape (T, 2).
        rows: Rows that count, shape (T,).
    """
    earlier = np.column_stack([at(time - lag, time, desired) for lag in _LAGS])
    return Torques(_band(model)[rows], _band(motion)[rows], _band(earlier)[rows])


def instrumented(parts: Sequence[Torques]) -> tuple[Array, float]:
    """Return inertia (kg m²) and correction of the moment of flight (N s), and the share of the torque that is wrong.

    The share is that of the square of the torque that goes with the instrument and is not explained.
    """
    seen = np.vstack([_projected(part.motion, part.instrument) for part in parts])
    found = np.linalg.lstsq(seen, np.concatenate([part.model for part in parts]), rcond=None)[0]
    wrong = sum(np.sum(_projected(part.model - part.motion @ found, part.instrument) ** 2) for part in parts)
    return found, float(wrong / sum(np.sum(part.model**2) for part in parts))


def _projected(values: Array, columns: Array) -> Array:
    return columns @ np.linalg.lstsq(columns, values, rcond=None)[0]


def _band(values: Array) -> Array:
    narrow = smooth(values, _NARROW)
    return narrow - smooth(narrow, _WIDE)
