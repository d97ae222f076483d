"""What may be taken from a flight's own hover: thrust scale, trim torque, pack voltage, where the thrust axis points.

Motors and truth have clocks of their own: the logs came by radio. The lag between both is that of the gyro against the
true rates.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.comparison.nanobench import PERIOD, RecordedFlight
from crazychoir_fw.comparison.phases import Phases
from crazychoir_fw.comparison.signals import (
    Array,
    at,
    conjugate,
    lag_of,
    local_polynomial,
    matrices,
    multiply,
    smooth,
    turn,
)
from crazychoir_fw.comparison.vehicle_model import TICK, RotorHistory, VehicleModel

GRAVITY = 9.81
TICKS_PER_ROW = round(PERIOD / TICK)
"""Ticks of the plant in a row of a flight."""
_LONGEST_HOVER = 20.0  # [s]
_SCALINGS = 4
_STILL = 0.1  # [m/s], at which a moment counts half of one at rest
_STARTS, _USUAL_START = (3, 5, 7, 9, 11, 13, 15, 17, 21, 25, 31), 17  # rows
_TRUSTED = 0.95  # of the samples of a gyroscope


@dataclass(frozen=True)
class TrueMotion:
    """Smooth true motion on the rows of a flight; all arrays have T rows."""

    position: Array
    """World (m)."""
    velocity: Array
    """World (m/s)."""
    acceleration: Array
    """World (m/s²)."""
    quat_xyzw: Array
    """Body to world."""
    rates: Array
    """Body (rad/s)."""
    angular_acceleration: Array
    """Body (rad/s²)."""


def true_motion(
    flight: RecordedFlight, misalignment: Array | None = None, rows: int = 11, order: int = 3
) -> TrueMotion:
    """Return position and attitude with their derivatives, from polynomials around each row.

    Args:
        flight: The flight.
        misalignment: Quaternion from the body's frame to that of the markers (x, y, z, w); None takes them as equal.
        rows: Odd number of rows that each polynomial is fitted to; the usual 0.11 s keep accelerations.
        order: Order of the polynomials.
    """

    def fitted(values: Array, derivative: int = 0) -> Array:
        return local_polynomial(values, PERIOD, rows, order, derivative)

    quaternion = true_attitude(flight, misalignment)
    smooth_quaternion = fitted(quaternion)
    smooth_quaternion /= np.linalg.norm(smooth_quaternion, axis=1, keepdims=True)
    change = fitted(quaternion, derivative=1)
    rates = 2.0 * multiply(conjugate(smooth_quaternion), change)[:, :3]
    return TrueMotion(
        position=fitted(flight.position),
        velocity=fitted(flight.position, derivative=1),
        acceleration=fitted(flight.position, derivative=2),
        quat_xyzw=smooth_quaternion,
        rates=rates,
        angular_acceleration=fitted(rates, derivative=1),
    )


def true_attitude(flight: RecordedFlight, misalignment: Array | None = None) -> Array:
    """Return the attitude of the body as recorded, quaternions, shape (T, 4); `misalignment` as in `true_motion`."""
    if misalignment is None:
        return flight.quat_xyzw
    return multiply(flight.quat_xyzw, np.broadcast_to(misalignment, flight.quat_xyzw.shape))


@dataclass(frozen=True)
class Tuning:
    """What one flight says of its own vehicle in hover."""

    log_lag: float
    """By which the logs come after the truth (s)."""
    thrust_scale: float
    """Delivered over commanded thrust."""
    trim_torque: tuple[float, ...]
    """Constant torque (N m, body) at a thrust that carries the weight; it goes with thrust."""
    misalignment: tuple[float, ...]
    """Quaternion from the body's frame to that of the markers (x, y, z, w)."""
    hover_voltage: float
    """Mean voltage of the pack in hover (V)."""
    hover_thrust: float
    """Mean thrust (N) at that voltage: a drone that still sinks after its take-off needs less than its weight."""
    hover_seconds: float
    """Time at rest that this was taken from (s): each moment counts by how still it is."""

    @property
    def misalignment_deg(self) -> float:
        """Angle between the thrust axis and the markers' z axis (deg)."""
        return float(np.degrees(2 * np.arccos(min(1.0, self.misalignment[3]))))

    def overrides(self) -> dict[str, Any]:
        """Return the parameters of the vehicle."""
        return {"rotors.thrust_scale": self.thrust_scale, "trim.torque": self.trim_torque}


@dataclass(frozen=True)
class Balance:
    """What motion demands and what the model says, row by row."""

    rotation: Array
    """Body to world, shape (T, 3, 3)."""
    velocity: Array
    """Body (m/s), shape (T, 3)."""
    needed_force: Array
    """Without gravity, body (N), shape (T, 3)."""
    model_force: Array
    """Body (N), shape (T, 3)."""
    needed_torque: Array
    """Body (N m), shape (T, 3)."""
    model_torque: Array
    """Body (N m), shape (T, 3)."""
    thrust: Array
    """Of the model (N), shape (T,)."""


def rotor_history(model: VehicleModel, flight: RecordedFlight, lag: float) -> RotorHistory:
    """Drive a model's rotors with the recorded motors and voltage, on the clock of the truth."""
    ticks = np.arange(0, len(flight.time) * TICKS_PER_ROW) * TICK
    motors = at(ticks + lag, flight.time, flight.motors)
    voltage = at(ticks + lag, flight.time, flight.voltage)
    return model.rotor_history(motors, voltage)


def balance(model: VehicleModel, history: RotorHistory, motion: TrueMotion) -> Balance:
    """Compare what the true motion demands with the wrench of a model."""
    rotation = matrices(motion.quat_xyzw)
    into_body = np.swapaxes(rotation, 1, 2)
    ticks = np.arange(len(motion.position)) * TICKS_PER_ROW
    force, torque = history.wrench(ticks, rotation, motion.velocity, motion.rates)
    specific = motion.acceleration + np.array([0.0, 0.0, GRAVITY])
    momentum = motion.rates @ model.inertia.T
    needed = motion.angular_acceleration @ model.inertia.T + np.cross(motion.rates, momentum)
    return Balance(
        rotation=rotation,
        velocity=np.einsum("nij,nj->ni", into_body, motion.velocity),
        needed_force=model.mass * np.einsum("nij,nj->ni", into_body, specific),
        model_force=np.einsum("nij,nj->ni", into_body, force),
        needed_torque=needed,
        model_torque=torque,
        thrust=history.total_thrust()[np.minimum(ticks, history.length - 1)],
    )


def start_window(flight: RecordedFlight, phases: Phases, lag: float) -> tuple[int, int]:
    """Return rows and order of the polynomials with which the true rates agree best with the gyroscope of a flight.

    Markers jitter, and a wide window blurs; what is best depends on both.

    Args:
        flight: The flight.
        phases: Its parts.
        lag: See `log_lag`.
    """
    used = _between(flight, phases.airborne + 0.5, phases.end - 0.3)
    if flight.gyro is None or used.sum() < 100:
        return _USUAL_START, 2
    gyro = at(flight.time + lag, flight.time, flight.gyro)[used, :2]

    def disagreement(rows: int) -> float:
        error = gyro - true_motion(flight, None, rows, 2).rates[used, :2]
        # the radio lost samples, and interpolation made spikes of others
        sizes = np.sort(np.linalg.norm(error - error.mean(axis=0), axis=1))
        return float(np.mean(sizes[: int(_TRUSTED * len(sizes))] ** 2))

    return min(_STARTS, key=disagreement), 2


def log_lag(flight: RecordedFlight, phases: Phases) -> float:
    """Return by how much the logs come after the truth (s): 0 when no gyro was logged."""
    if flight.gyro is None:
        return 0.0
    rows = _between(flight, phases.airborne + 0.5, phases.end - 0.3)
    if rows.sum() < 100:
        return 0.0
    rates = true_motion(flight).rates
    # both smoothed alike: vibration would drown a slow flight
    return lag_of(smooth(flight.gyro, 4), smooth(rates, 4), flight.time, rows)


def tune(flight: RecordedFlight, phases: Phases, vehicle: Mapping[str, Any]) -> Tuning:
    """Take from a flight's hover what may be taken.

    Args:
        flight: The flight.
        phases: Its parts.
        vehicle: Parameters of the common vehicle that differ from the platform's.

    Raises:
        RangeError: If motors or voltage were not recorded, or there is no hover.
    """
    sentence = flight.missing("motors", "voltage")
    if sentence:
        raise RangeError(sentence)
    begin, end = phases.resting
    end = min(end, begin + _LONGEST_HOVER)
    rows = _between(flight, begin, end)
    if rows.sum() < 20:
        # no hover: the first two seconds in the air have to do
        begin, end = phases.airborne + 0.3, phases.airborne + 2.3
        rows = _between(flight, begin, end)
        if rows.sum() < 20:
            raise RangeError(f"{flight.name}: no hover to take thrust scale and trim from")
    lag = log_lag(flight, phases)
    plain = {**vehicle, "rotors.thrust_scale": 1.0, "trim.torque": (0.0, 0.0, 0.0)}
    model = VehicleModel(plain)
    motion = true_motion(flight)
    weights = stillness(motion.velocity[rows])

    def mean(values: Array) -> Any:
        return weights @ values[rows] / weights.sum()

    unscaled = balance(model, rotor_history(model, flight, lag), motion)
    drag = unscaled.model_force - np.stack([0 * unscaled.thrust, 0 * unscaled.thrust, unscaled.thrust], axis=1)
    axis = mean(unscaled.needed_force - drag)
    misalignment = _rotation_to(axis)

    # the warmth of the motors depends on what they deliver, so that the scale is found in steps
    scale, thrust = 1.0, float(mean(unscaled.thrust))
    for _ in range(_SCALINGS):
        scale = min(max(scale * float(np.linalg.norm(axis)) / thrust, 0.2), 2.0)
        scaled = VehicleModel({**plain, "rotors.thrust_scale": scale})
        history = rotor_history(scaled, flight, lag)
        thrust = float(mean(history.total_thrust()[::TICKS_PER_ROW]))
    own = balance(scaled, history, true_motion(flight, misalignment))
    # a drone that still sinks or slows down after its take-off does not carry its weight
    share = thrust / (model.mass * GRAVITY)
    trim = mean(own.needed_torque - own.model_torque) / share
    return Tuning(
        log_lag=lag,
        thrust_scale=scale,
        trim_torque=tuple(float(torque) for torque in np.clip(trim, -0.01, 0.01)),
        misalignment=tuple(float(part) for part in misalignment),
        hover_voltage=float(mean(flight.voltage)),
        hover_thrust=thrust,
        hover_seconds=float(weights.sum() * PERIOD),
    )


def stillness(velocity: Array) -> Array:
    """Return how much each moment counts for what a hover tells, 1 at rest, shape (T,).

    Args:
        velocity: True velocity (m/s), shape (T, 3).
    """
    return 1.0 / (1.0 + np.sum(velocity**2, axis=1) / _STILL**2)


def _between(flight: RecordedFlight, begin: float, end: float) -> NDArray[np.bool_]:
    return (flight.time >= begin) & (flight.time < end)


def _rotation_to(axis: Array) -> Array:
    """Return the smallest rotation that turns the z axis into an axis, as a quaternion."""
    unit = axis / np.linalg.norm(axis)
    angle = float(np.arccos(np.clip(unit[2], -1.0, 1.0)))
    around = np.array([-unit[1], unit[0], 0.0])
    length = float(np.linalg.norm(around))
    return turn((around / length * angle if length > 1e-9 else around)[None, :])[0]
