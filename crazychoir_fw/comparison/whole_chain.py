"""Comparison 4: recorded setpoints into a simulated drone, with motion capture, Kalman filter, controller and plant.

The setpoints of take-off and landing are sent like all others, as positions: releases before the middle of 2026 do not
start their integrators over when the kind of setpoint changes, ours does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.comparison.motor_replay import commanded_thrust, supply_of
from crazychoir_fw.comparison.nanobench import PERIOD, RecordedFlight
from crazychoir_fw.comparison.phases import Phases
from crazychoir_fw.comparison.signals import (
    Array,
    at,
    lag_of,
    least,
    multiply,
    rms,
    roll_pitch_yaw,
    shifted,
    tilt_between,
)
from crazychoir_fw.comparison.tuning import Tuning
from crazychoir_fw.onboard import vehicles
from crazychoir_fw.simulation import DroneConfig, World
from crazychoir_fw.simulation.drone import Drone

_TICKS = 10  # per row
_BEFORE = 0.5  # [s] on the floor before the first setpoint
_LONGEST_TAKEOFF = 4.0  # [s]
_GREATEST_SHIFT = 0.3  # [s]
_LOST = 3.0  # [m] from the real path


@dataclass(frozen=True)
class ChainComparison:
    """A simulated flight beside the real one, over the compared part of the flight."""

    path_rms_m: float
    """Distance between both paths after one time shift (m)."""
    lag_s: float
    """That shift: by which the simulated path comes after the real one (s)."""
    lag_behind_setpoint_s: tuple[float, float]
    """By which the real and the simulated path come after the setpoints (s)."""
    tracking_rms_m: tuple[float, float]
    """Distance to the setpoint, real and simulated (m)."""
    tilt_rms_deg: tuple[float, float]
    """Angle between thrust axis and vertical, real and simulated (deg)."""
    thrust_counts: tuple[float, float]
    """Mean commanded thrust, real and simulated."""
    voltage_v: tuple[float, float]
    """Mean voltage of the loaded pack, real and simulated (V)."""
    time: Array
    """Clock of the following (s), shape (T,): from the first setpoint to the end of the trajectory."""
    real: dict[str, Array]
    """``position`` (m), ``tilt`` (deg), ``thrust`` (counts), ``voltage`` (V), each T rows."""
    simulated: dict[str, Array]
    """The same, shifted in time by `lag_s`."""
    setpoint: Array
    """Shape (T, 3)."""
    rows: NDArray[np.bool_]
    """Rows that were compared, shape (T,)."""

    @property
    def tracking_percent(self) -> float:
        """Simulated over real tracking error, less one (%)."""
        return _more(self.tracking_rms_m)

    @property
    def tilt_percent(self) -> float:
        """The same of the tilt (%)."""
        return _more(self.tilt_rms_deg)

    @property
    def thrust_percent(self) -> float:
        """The same of the thrust level (%)."""
        return _more(self.thrust_counts)

    @property
    def voltage_difference_v(self) -> float:
        """Simulated less real loaded voltage (V)."""
        return self.voltage_v[1] - self.voltage_v[0]


def _more(pair: tuple[float, float]) -> float:
    return 100.0 * (pair[1] / pair[0] - 1.0) if pair[0] else float("nan")


def pack_for(voltage: float, thrust: float, seconds: float, vehicle: Mapping[str, Any]) -> tuple[float, float]:
    """Return charge and resistance (Ohm) of a pack that shows a voltage (V) at a thrust (N), seconds after take-off.

    The resistance is the common one, unless the voltage is higher than that of a full pack would be: then it is what a
    full pack needs.
    """
    known = vehicles.parameters("cf2")
    values: dict[str, Any] = {**{name: known[name].value for name in known}, **vehicles.overrides(dict(vehicle))}
    power = values["battery.base_power"] + values["battery.power_per_thrust"] * thrust
    fast = values["battery.resistance"]
    slow = values["battery.slow_resistance"] * (1.0 - np.exp(-seconds / values["battery.slow_time"]))
    full = float(lib.cf_open_circuit_voltage(1.0))
    fast = max(0.0, min(fast, (full - voltage) * voltage / power - slow))
    open_circuit = voltage + (fast + slow) * power / voltage
    charges = np.linspace(0.0, 1.0, 401)
    volts = [lib.cf_open_circuit_voltage(float(charge)) for charge in charges]
    return float(np.interp(open_circuit, volts, charges)), fast


def fly_again(
    flight: RecordedFlight,
    phases: Phases,
    vehicle: Mapping[str, Any],
    tuning: Tuning,
    drone: Mapping[str, Any] | None = None,
    thrust_max: float | None = None,
) -> ChainComparison:
    """Fly the recorded setpoints in simulation and compare.

    Args:
        flight: The flight.
        phases: Its parts.
        vehicle: Parameters of the common vehicle that differ from the platform's.
        tuning: What its hover says.
        drone: Attributes of the simulated drone that differ, such as ``{"mocap_latency_ms": 20}``.
        thrust_max: Largest thrust of a motor (N) that the flight's firmware believes in, as `motor_replay` finds it;
            that of ours by default.

    Raises:
        RangeError: If setpoints, motors or voltage were not recorded, or the simulated drone was lost.
    """
    sentence = flight.missing("setpoint", "motors", "voltage")
    if sentence:
        raise RangeError(sentence)
    yaws = _commands(flight, phases, tuning.log_lag)[2]
    seconds = phases.hovering[0] - phases.motors_on
    used = seconds * 3.2 / 900.0  # amperes over coulombs: the little that take-off draws
    attributes = dict(drone or {})
    charge, resistance = pack_for(tuning.hover_voltage, tuning.hover_thrust, seconds, vehicle)
    config = DroneConfig(
        "real",
        position=start_place(flight, phases),
        yaw_deg=float(yaws[0]),
        vehicle={**vehicle, **tuning.overrides(), "battery.resistance": resistance},
        controller=flight.controller,
        positioning=attributes.pop("positioning", "mocap"),
        battery=min(1.0, charge + used),
        attributes=attributes,
    )
    return fly_beside(flight, phases, config, tuning, thrust_max=thrust_max)


def start_place(flight: RecordedFlight, phases: Phases) -> tuple[float, float]:
    """Return where a drone stood before it took off (m)."""
    x, y, _ = np.median(flight.position[: max(round(phases.airborne / PERIOD) - 10, 1)], axis=0)
    return float(x), float(y)


def start_yaw(flight: RecordedFlight, phases: Phases) -> float:
    """Return the heading in which it stood (deg)."""
    before = flight.quat_xyzw[: max(round(phases.airborne / PERIOD) - 10, 1)]
    return float(np.median(roll_pitch_yaw(before)[:, 2]))


def fly_beside(
    flight: RecordedFlight,
    phases: Phases,
    config: DroneConfig,
    tuning: Tuning | None = None,
    seed: int = 0,
    thrust_max: float | None = None,
) -> ChainComparison:
    """Fly the recorded setpoints with a drone as it is configured, and compare.

    Args:
        flight: The flight.
        phases: Its parts.
        config: The simulated drone, at the start of the real one.
        tuning: What the hover says of clocks and of the frame of the markers; None takes both as they should be.
        seed: Of all noise.
        thrust_max: See `fly_again`.

    Raises:
        RangeError: If setpoints were not recorded, or the simulated drone was lost.
    """
    sentence = flight.missing("setpoint")
    if sentence:
        raise RangeError(sentence)
    start, setpoints, yaws = _commands(flight, phases, 0.0 if tuning is None else tuning.log_lag)
    world = World([config], visuals=False, seed=seed)
    body = world.drones[0]
    if thrust_max is not None:
        ffi.cast("cf_builtin_t *", body.struct.provider_state).power.thrust.thrust_max = thrust_max
    world.wait_until_ready()
    lift = _floor(flight, phases) - body.true_position[2]
    rows = []
    for target, yaw in zip(setpoints, yaws, strict=True):
        x, y, z = target
        body.commander.send_position_setpoint(float(x), float(y), float(z - lift), float(yaw))
        world.step(_TICKS)
        motion = _estimate_of(body) if flight.is_estimate else (*body.true_position, *body.true_quat_wxyz)
        rows.append([*motion, body.log["stabilizer.thrust"], body.battery_voltage])
    simulated = np.array(rows)
    simulated[:, 2] += lift
    times = start + PERIOD * np.arange(len(simulated))  # a log shows a setpoint when it is in force
    what = f"{flight.name}: {body.supervisor_state}"
    return compare_paths(flight, phases, tuning, times, setpoints, simulated, what, thrust_max)


def _estimate_of(body: Drone) -> tuple[float, ...]:
    """Return position (m) and attitude (w, x, y, z) as the onboard software believes them."""
    x, y, z, *quat_wxyz = (body.log[f"stateEstimate.{name}"] for name in ("x", "y", "z", "qw", "qx", "qy", "qz"))
    return (x, y, z, *(quat_wxyz if any(quat_wxyz) else (1.0, 0.0, 0.0, 0.0)))


def _floor(flight: RecordedFlight, phases: Phases) -> float:
    """Return the height (m) that the truth shows for a drone on the floor."""
    if phases.starts_on_floor:
        return float(np.median(flight.position[: round(phases.motors_on / PERIOD), 2]))
    return float(flight.position[:, 2].min())


def _commands(flight: RecordedFlight, phases: Phases, lag: float) -> tuple[float, Array, Array]:
    """Return the time of the first setpoint (s), setpoints (m) and yaws (deg), one row per `PERIOD`."""
    end = phases.end + _GREATEST_SHIFT
    start = phases.motors_on if phases.starts_on_floor else 0.0
    times = np.arange(start, end, PERIOD)
    setpoints = at(times + lag, flight.time, flight.setpoint)
    last = round((phases.end - start) / PERIOD)
    setpoints[last:] = setpoints[max(last - 2, 0)]  # what follows the trajectory is not ours to fly
    heading = roll_pitch_yaw(flight.quat_xyzw)[:, 2]
    if flight.setpoint_yaw is not None:
        yaws = at(times + lag, flight.time, flight.setpoint_yaw)
    elif flight.desired is not None:
        yaws = at(times + lag, flight.time, flight.desired[:, 2])
    else:
        yaws = np.full(len(times), float(np.median(heading[:50])))
    if phases.starts_on_floor:
        return start, setpoints, yaws
    earlier = _take_off_before(setpoints)
    return (
        start - len(earlier) * PERIOD,
        np.vstack([earlier, setpoints]),
        np.concatenate([np.full(len(earlier), yaws[0]), yaws]),
    )


def _take_off_before(setpoints: Array) -> Array:
    """Return the part of a take-off that a recording which begins in the air has missed.

    The high-level commander climbs along a polynomial of degree 7 that rests at both ends; its height and duration
    follow from where the recorded part begins, how fast it climbs there and where it rests.
    """
    height = float(np.max(setpoints[:300, 2]))
    share = float(np.clip(setpoints[0, 2] / height, 0.02, 0.98))
    grid = np.linspace(0.0, 1.0, 2001)
    climb = 35 * grid**4 - 84 * grid**5 + 70 * grid**6 - 20 * grid**7
    place = float(np.interp(share, climb, grid))
    slope = float(np.interp(place, grid, np.gradient(climb, grid)))
    speed = float(np.mean(np.diff(setpoints[:10, 2]))) / PERIOD
    duration = min(height * slope / speed, _LONGEST_TAKEOFF) if speed > 0.05 else 2.0
    count = round(place * duration / PERIOD)
    phase = np.arange(count) * PERIOD / duration
    earlier = np.repeat(setpoints[:1], count, axis=0)
    earlier[:, 2] = height * np.interp(phase, grid, climb)
    return earlier


def compare_paths(
    flight: RecordedFlight,
    phases: Phases,
    tuning: Tuning | None,
    times: NDArray[Any],
    setpoints: Array,
    simulated: Array,
    what: str,
    thrust_max: float | None = None,
) -> ChainComparison:
    """Compare a simulated flight with the real one.

    Args:
        flight: The real one.
        phases: Its parts.
        tuning: See `fly_beside`.
        times: Of the simulated rows on the clock of the real flight (s), shape (T,).
        setpoints: Position set-points of the drones (m), shape (T, 3).
        simulated: Position (m), attitude (w, x, y, z), thrust (counts), voltage (V), shape (T, 9).
        what: Begin of the message about a drone that was lost.
        thrust_max: See `fly_again`.

    Raises:
        RangeError: If the simulated drone was lost.
    """
    use = (flight.time >= max(times[0], 0.0)) & (flight.time < phases.end)
    time = flight.time[use]
    begin, end = phases.compared
    rows = (time >= begin) & (time < end)
    position = flight.position[use]

    def cost(lag: float) -> float:
        return rms((at(time + lag, times, simulated[:, :3]) - position)[rows])

    lag = least(cost, -_GREATEST_SHIFT, _GREATEST_SHIFT, 0.01)
    ours = at(time + lag, times, simulated)
    path = rms((ours[:, :3] - position)[rows])
    if not np.isfinite(path) or path > _LOST:
        raise RangeError(f"{what}: the simulated drone was lost")
    target = at(time, times, setpoints)
    simulated_now = at(time, times, simulated[:, :3])
    truth = flight.quat_xyzw if tuning is None else _body_attitude(flight, tuning)
    level = np.tile([0.0, 0.0, 0.0, 1.0], (len(time), 1))
    log_lag = 0.0 if tuning is None else tuning.log_lag
    thrust = _real_thrust(flight, log_lag, thrust_max)[use]
    voltage = (
        np.full(len(time), np.nan) if flight.voltage is None else shifted(flight.time, flight.voltage, log_lag)[use]
    )
    # a normalization after interpolation does no harm: neighbors are a hundredth of a second apart
    attitude = ours[:, [4, 5, 6, 3]] / np.linalg.norm(ours[:, 3:7], axis=1, keepdims=True)
    real = {"position": position, "tilt": tilt_between(truth[use], level), "thrust": thrust, "voltage": voltage}
    model = {
        "position": ours[:, :3],
        "tilt": tilt_between(attitude, level),
        "thrust": ours[:, 7],
        "voltage": ours[:, 8],
    }
    return ChainComparison(
        path_rms_m=path,
        lag_s=lag,
        lag_behind_setpoint_s=(_lag(position, target, time, rows), _lag(simulated_now, target, time, rows)),
        tracking_rms_m=(rms((position - target)[rows]), rms((simulated_now - target)[rows])),
        tilt_rms_deg=(rms(real["tilt"][rows]), rms(model["tilt"][rows])),
        thrust_counts=(float(thrust[rows].mean()), float(model["thrust"][rows].mean())),
        voltage_v=(float(voltage[rows].mean()), float(model["voltage"][rows].mean())),
        time=time,
        real=real,
        simulated=model,
        setpoint=target,
        rows=rows,
    )


def _lag(path: Array, target: Array, time: Array, rows: NDArray[np.bool_]) -> float:
    return lag_of(path, target, time, rows, most=1.2)


def _body_attitude(flight: RecordedFlight, tuning: Tuning) -> Array:
    return multiply(flight.quat_xyzw, np.broadcast_to(np.array(tuning.misalignment), flight.quat_xyzw.shape))


def _real_thrust(flight: RecordedFlight, lag: float, thrust_max: float | None) -> Array:
    """Return the thrust command (counts), from the motors where it was not logged."""
    if flight.desired is not None:
        return shifted(flight.time, flight.desired[:, 3], lag)
    if flight.motors is None or flight.voltage is None:
        return np.full(len(flight.time), np.nan)
    return shifted(flight.time, commanded_thrust(flight.motors, supply_of(flight), thrust_max).mean(axis=1), lag)
