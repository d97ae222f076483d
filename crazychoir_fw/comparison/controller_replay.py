"""Comparison 1: recorded estimate and setpoints into our controller, and what the real firmware made of them.

PID flights log the desired attitude and thrust of the cascade. Mellinger flights log nothing of their controller, so
that its thrust is taken from the motors (`motor_replay.commanded_thrust`).

The streams of a log reach the ground with delays of their own. Estimate and setpoint are shifted by what makes the
desired roll and pitch agree best; the thrust takes no part in that.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.comparison.motor_replay import commanded_thrust, supply_of
from crazychoir_fw.comparison.nanobench import PERIOD, RecordedFlight
from crazychoir_fw.comparison.phases import Phases
from crazychoir_fw.comparison.signals import Array, local_polynomial, rms, shifted

_TICKS = 10  # of the onboard loop per row
_SHIFTS = (-0.02, -0.01, -0.005, 0.0, 0.005, 0.01, 0.02)  # [s]
_SATURATED = 65000.0  # [counts]
_SPIKE = 1.0  # [deg], more does not decide the alignment


@dataclass(frozen=True)
class ControllerReplay:
    """What our controller made of recorded inputs. Figures are over logged rows of the trajectory."""

    roll_rms_deg: float | None
    """Desired roll, ours against the real one; None where it was not logged."""
    pitch_rms_deg: float | None
    """Desired pitch."""
    roll_median_deg: float | None
    """Median of the absolute difference, which excludes the moments when a stream jumps."""
    pitch_median_deg: float | None
    """The same of pitch."""
    thrust_rms_percent: float
    """Thrust, after what the two vertical integrators held at the start is taken out (an offset and a ramp)."""
    thrust_offset_rms_percent: float
    """The same with only the offset taken out."""
    estimate_lag_s: float
    """By which the estimate arrived after the desired attitude."""
    setpoint_lag_s: float
    """The same of the setpoint."""
    time: Array
    """Clock of the following (s), shape (T,)."""
    ours: Array
    """Desired roll and pitch (deg) and thrust (counts), shape (T, 3); NaN for what is not compared."""
    logged: Array
    """The same of the real firmware."""
    rows: NDArray[np.bool_]
    """Rows that were compared, shape (T,)."""


def replay_controller(flight: RecordedFlight, phases: Phases) -> ControllerReplay:
    """Replay a flight into our PID or Mellinger controller.

    Raises:
        RangeError: If what it takes was not recorded, or there is no trajectory to compare.
    """
    sentence = flight.missing("estimate", "attitude", "setpoint")
    if flight.controller != "pid":
        sentence = sentence or flight.missing("motors", "voltage", "gyro")
    if sentence:
        raise RangeError(sentence)
    begin, end = phases.compared
    rows = (flight.time >= begin) & (flight.time < end)
    if flight.controller == "pid":
        return _pid(flight, phases, rows)
    return _mellinger(flight, phases, rows)


def _figures(
    time: Array, ours: Array, logged: Array, rows: NDArray[np.bool_], lags: tuple[float, float]
) -> ControllerReplay:
    if rows.sum() < 50:
        raise RangeError("less than half a second to compare")
    angle = (ours - logged)[rows][:, :2]
    has_angles = bool(np.isfinite(angle).all())
    difference = (ours - logged)[rows][:, 2]
    level = float(np.mean(logged[rows][:, 2]))
    ramp = np.polyval(np.polyfit(time[rows], difference, 1), time[rows])
    return ControllerReplay(
        roll_rms_deg=rms(angle[:, 0]) if has_angles else None,
        pitch_rms_deg=rms(angle[:, 1]) if has_angles else None,
        roll_median_deg=float(np.median(np.abs(angle[:, 0]))) if has_angles else None,
        pitch_median_deg=float(np.median(np.abs(angle[:, 1]))) if has_angles else None,
        thrust_rms_percent=100 * rms(difference - ramp) / level,
        thrust_offset_rms_percent=100 * float(np.std(difference)) / level,
        estimate_lag_s=lags[0],
        setpoint_lag_s=lags[1],
        time=time,
        ours=ours,
        logged=logged,
        rows=rows,
    )


# -------------------------------------------------------------------------------------------- PID


def _pid(flight: RecordedFlight, phases: Phases, rows: NDArray[np.bool_]) -> ControllerReplay:
    desired = flight.desired
    assert desired is not None
    # rows that were interpolated are no evidence; their neighbors bend towards them
    lost = np.zeros(len(rows), bool)
    for group in ("estimate", "desired"):
        filled = flight.filled.get(group, np.zeros(len(rows), bool))
        lost |= np.convolve(filled, np.ones(3), "same") > 0
    rows = rows & ~lost & (desired[:, 3] < _SATURATED) & (desired[:, 3] > 1000)
    logged = desired[:, [0, 1, 3]]

    def cost(shift: tuple[float, float]) -> float:
        angle = (_run_pid(flight, *shift) - logged)[rows][:, :2]
        return float(np.mean(np.minimum(np.abs(angle), _SPIKE) ** 2)) if len(angle) else 0.0

    best = min(itertools.product(_SHIFTS, _SHIFTS), key=cost)
    ours = _run_pid(flight, *best)
    if not phases.starts_on_floor and rows.any():
        # the integrators of a flight that was joined in the air hold unknown values
        first = np.flatnonzero(rows)[:100]
        ours[:, :2] += np.median((logged - ours)[first, :2], axis=0)
    return _figures(flight.time, ours, logged, rows, best)


def _run_pid(flight: RecordedFlight, estimate_lag: float, setpoint_lag: float) -> Array:
    """Return desired roll, pitch (deg) and thrust (counts) of our cascade, shape (T, 3)."""
    estimate = shifted(flight.time, flight.estimate, estimate_lag)
    attitude = shifted(flight.time, flight.attitude, estimate_lag)
    setpoint = shifted(flight.time, flight.setpoint, setpoint_lag)
    desired = flight.desired
    pid, control = ffi.new("cf_controller_pid_t *"), ffi.new("control_t *")
    target, sensors, state = ffi.new("setpoint_t *"), ffi.new("sensorData_t *"), ffi.new("state_t *")
    lib.cf_controller_pid_init(pid, lib.CF_PLATFORM_CF2)
    result = np.empty((len(estimate), 3))
    for row in range(len(estimate)):
        _set_state(state, estimate[row], attitude[row])
        is_on = desired[row, 3] > 1000
        _set_target(target, setpoint[row], desired[row, 2], is_on)
        lib.cf_controller_pid_update(pid, control, target, sensors, state, _TICKS * (row + 1))
        result[row] = pid.attitude_desired.roll, pid.attitude_desired.pitch, pid.actuator_thrust
    return result


def _set_state(state: Any, estimate: Array, attitude: Array) -> None:
    state.position.x, state.position.y, state.position.z = estimate[:3]
    state.velocity.x, state.velocity.y, state.velocity.z = estimate[3:]
    state.attitude.roll, state.attitude.pitch, state.attitude.yaw = attitude


def _set_target(target: Any, position: Array, yaw: float, is_on: bool) -> None:
    target.position.x, target.position.y, target.position.z = position
    target.attitude.yaw = yaw
    mode = lib.modeAbs if is_on else lib.modeDisable
    target.mode.x = target.mode.y = target.mode.z = target.mode.yaw = mode


# -------------------------------------------------------------------------------------- Mellinger


def _mellinger(flight: RecordedFlight, phases: Phases, rows: NDArray[np.bool_]) -> ControllerReplay:
    commands = commanded_thrust(flight.motors, supply_of(flight))
    running = (flight.motors.max(axis=1) < _SATURATED) & (flight.motors.min(axis=1) > 1000)
    # the motors carry the noise of the gyro, thrust does not: it is compared below 5 Hz
    logged = np.full((len(rows), 3), np.nan)
    logged[:, 2] = local_polynomial(commands.mean(axis=1), PERIOD, 21, 3)
    rows = rows & (np.convolve(~running, np.ones(21), "same") == 0)

    def difference(shift: tuple[float, float]) -> Array:
        return (_run_mellinger(flight, *shift) - logged[:, 2])[rows]

    shifts = (-0.02, 0.0, 0.02)
    best = min(
        itertools.product(shifts, shifts), key=lambda shift: float(np.var(difference(shift))) if rows.any() else 0
    )
    ours = np.full((len(rows), 3), np.nan)
    ours[:, 2] = local_polynomial(_run_mellinger(flight, *best), PERIOD, 21, 3)
    return _figures(flight.time, ours, logged, rows, best)


def _run_mellinger(flight: RecordedFlight, estimate_lag: float, setpoint_lag: float) -> Array:
    """Return the thrust (counts) of our Mellinger controller, shape (T,)."""
    estimate = shifted(flight.time, flight.estimate, estimate_lag)
    attitude = shifted(flight.time, flight.attitude, estimate_lag)
    setpoint = shifted(flight.time, flight.setpoint, setpoint_lag)
    half = np.radians(attitude * np.array([1.0, -1.0, 1.0])) / 2  # pitch has the firmware's sign
    (cr, cp, cy), (sr, sp, sy) = np.cos(half).T, np.sin(half).T
    quaternion = np.stack(
        [
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        ],
        axis=1,
    )
    gyro = np.degrees(shifted(flight.time, flight.gyro, estimate_lag))
    controller, control = ffi.new("controllerMellinger_t *"), ffi.new("control_t *")
    target, sensors, state = ffi.new("setpoint_t *"), ffi.new("sensorData_t *"), ffi.new("state_t *")
    lib.controllerMellingerInit(controller)
    result = np.empty(len(estimate))
    for row in range(len(estimate)):
        _set_state(state, estimate[row], attitude[row])
        q = state.attitudeQuaternion
        q.x, q.y, q.z, q.w = quaternion[row]
        sensors.gyro.x, sensors.gyro.y, sensors.gyro.z = gyro[row]
        _set_target(target, setpoint[row], attitude[row, 2], True)
        # its integrals count steps of 500 Hz
        for _ in range(_TICKS // 2):
            lib.controllerMellinger(controller, control, target, sensors, state, 2 * (row + 1))
        result[row] = control.thrust
    return result
