"""Comparison 3: the plant alone. From true states on, recorded motors and voltage; where is it after half a second?

Nothing closes a loop here, and an error of the torque grows with the square of time. Thrust scale and trim are those of
the flight's hover (`tuning`). Because motors warm up unequally, the trim of a real vehicle wanders by as much as its
size within a flight; `followed` figures take it from the second before each start instead.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.comparison.nanobench import PERIOD, RecordedFlight
from crazychoir_fw.comparison.phases import Phases
from crazychoir_fw.comparison.signals import Array, matrices, multiply, rms, tilt_between, turn
from crazychoir_fw.comparison.tuning import (
    GRAVITY,
    TrueMotion,
    Tuning,
    balance,
    rotor_history,
    start_window,
    true_attitude,
    true_motion,
)
from crazychoir_fw.comparison.vehicle_model import TICK, RotorHistory, VehicleModel

HORIZONS = (0.1, 0.2, 0.5)
"""Times (s) after which prediction and truth are compared."""

_SPACING = 0.1  # [s] between starts
_MEMORY = 1.0  # [s] that the followed trim is taken from


@dataclass(frozen=True)
class Prediction:
    """Errors of predictions, root mean squares over all starts; one number per horizon."""

    position_cm: tuple[float, ...]
    """Distance to the true position, trim of the hover."""
    tilt_deg: tuple[float, ...]
    """Angle between the z axes."""
    mean_position_cm: tuple[float, ...]
    """The same with the mean trim of the whole compared part, which is unknown in hover."""
    mean_tilt_deg: tuple[float, ...]
    followed_position_cm: tuple[float, ...]
    """The same with the trim of the second before each start."""
    followed_tilt_deg: tuple[float, ...]
    followed_tilt_median_deg: tuple[float, ...]
    starts: int
    """How many predictions there were."""
    trim_wander: float
    """Standard deviation of the followed roll and pitch trim over the flight (N m)."""


def predict(
    flight: RecordedFlight,
    phases: Phases,
    vehicle: Mapping[str, Any],
    tuning: Tuning,
) -> Prediction:
    """Predict from every tenth of a second of the compared part of a flight.

    Raises:
        RangeError: If that part is too short.
    """
    begin, end = phases.compared
    starts = np.arange(begin, min(end, flight.time[-1]) - HORIZONS[-1] - 0.05, _SPACING)
    if len(starts) < 5:
        raise RangeError(f"{flight.name}: too short to predict anything")
    model = VehicleModel({**vehicle, **tuning.overrides()})
    misalignment = np.array(tuning.misalignment)
    motion = true_motion(flight, misalignment)
    start = true_motion(flight, misalignment, *start_window(flight, phases, tuning.log_lag))
    target = flight.position, true_attitude(flight, misalignment)
    history = rotor_history(model, flight, tuning.log_lag)
    rows = np.rint(starts / PERIOD).astype(int)

    # torque that the model lacks, averaged over the second before each start
    state = balance(model, history, motion)
    lacking = np.cumsum(np.vstack([np.zeros(3), state.needed_torque - state.model_torque]), axis=0)
    back = np.maximum(rows - round(_MEMORY / PERIOD), 0)
    followed = (lacking[rows] - lacking[back]) / np.maximum(rows - back, 1)[:, None]

    used = slice(*np.rint([begin / PERIOD, end / PERIOD]).astype(int))
    mean = np.broadcast_to((state.needed_torque - state.model_torque)[used].mean(axis=0), followed.shape)

    trims = np.zeros_like(followed), mean, followed
    errors = [_errors(model, history, start, target, rows, torque) for torque in trims]
    (hover_position, hover_tilt), (mean_position, mean_tilt), (position, tilt) = errors
    return Prediction(
        position_cm=tuple(100 * rms(error) for error in hover_position),
        tilt_deg=tuple(rms(error) for error in hover_tilt),
        mean_position_cm=tuple(100 * rms(error) for error in mean_position),
        mean_tilt_deg=tuple(rms(error) for error in mean_tilt),
        followed_position_cm=tuple(100 * rms(error) for error in position),
        followed_tilt_deg=tuple(rms(error) for error in tilt),
        followed_tilt_median_deg=tuple(float(np.median(error)) for error in tilt),
        starts=len(starts),
        trim_wander=float(np.std(followed[:, :2], axis=0).max()),
    )


def _errors(
    model: VehicleModel,
    history: RotorHistory,
    start: TrueMotion,
    target: tuple[Array, Array],
    rows: Array,
    torque: Array,
) -> tuple[list[Array], list[Array]]:
    """Return distances (m) and tilts (deg) at each horizon, one array of all starts each.

    Args:
        model: The vehicle.
        history: Its rotors.
        start: Motion to start from.
        target: Positions and attitudes to compare with.
        rows: Rows of the flight to start at, shape (n,).
        torque: What the model lacks (N m), shape (n, 3).
    """
    position, velocity = start.position[rows].copy(), start.velocity[rows].copy()
    attitude, rates = start.quat_xyzw[rows].copy(), start.rates[rows].copy()
    inertia, inverse = model.inertia, np.linalg.inv(model.inertia)
    first = rows * round(PERIOD / TICK)
    marks = [round(horizon / TICK) for horizon in HORIZONS]
    distances, tilts = [], []
    for tick in range(1, marks[-1] + 1):
        force, moment = history.wrench(first + tick - 1, matrices(attitude), velocity, rates)
        acceleration = force / model.mass - np.array([0.0, 0.0, GRAVITY])
        moment = moment + torque - np.cross(rates, rates @ inertia.T)
        turned = moment @ inverse.T
        position += TICK * velocity + 0.5 * TICK**2 * acceleration
        velocity += TICK * acceleration
        attitude = multiply(attitude, turn(TICK * (rates + 0.5 * TICK * turned)))
        rates = rates + TICK * turned
        if tick in marks:
            there = rows + round(tick * TICK / PERIOD)
            distances.append(np.linalg.norm(position - target[0][there], axis=1))
            tilts.append(tilt_between(attitude, target[1][there]))
    return distances, tilts
