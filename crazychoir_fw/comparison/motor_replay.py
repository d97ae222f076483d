"""Comparison 2: thrust and torque commands through our mixer and battery compensation to the four motors.

A log holds the thrust command, the four ratios that came out and the voltage, but not the torque commands. Those are
computed from the four ratios: converted to thrust, less their mean; the thrust is the logged one. So the comparison
tests that the mixer is linear before the compensation, the curve, its largest thrust and the filter of the voltage.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.comparison.nanobench import RecordedFlight
from crazychoir_fw.comparison.phases import Phases
from crazychoir_fw.comparison.signals import Array

COUNTS = 65535.0
OLDER_THRUST_MAX = 0.1125
"""Largest thrust of a motor (N) that builds of mid 2025 believe in; a fact of a flight's firmware, not of ours."""

_START_VOLTAGE = 4.2  # [V], of the filter
_KEPT_PER_ROW = 0.99**10  # of the filter, in the ten control steps of a row
_SATURATED = 65000.0


@dataclass(frozen=True)
class MotorReplay:
    """Our motor ratios against the logged ones. Figures are over unsaturated rows of the trajectory."""

    mean_percent: tuple[float, ...]
    """Mean difference of each motor, in percent of its ratio."""
    rms_percent: tuple[float, ...]
    """Root mean square of the difference: what logs that are not simultaneous add."""
    saturated_share: float
    """Share of rows left out because a motor was at its top."""
    thrust_max: float
    """Largest thrust of a motor (N) that the flight's firmware believes in."""
    time: Array
    ours: Array
    """Ratios, shape (T, 4)."""
    logged: Array
    rows: NDArray[np.bool_]

    @property
    def worst_mean_percent(self) -> float:
        """Largest mean difference of a motor."""
        return float(np.max(np.abs(self.mean_percent)))


def supply_of(flight: RecordedFlight) -> Array:
    """Return the voltage (V) that the compensation saw: the pack's, through its filter."""
    assert flight.voltage is not None
    filtered = np.empty_like(flight.voltage)
    # a flight that was joined in the air has long left the start value behind
    value = _START_VOLTAGE if flight.motors is None or flight.motors[0].mean() < 1000 else flight.voltage[0]
    for row, voltage in enumerate(flight.voltage):
        value = voltage + (value - voltage) * _KEPT_PER_ROW
        filtered[row] = value
    return filtered


def commanded_thrust(motors: Array, supply: Array, thrust_max: float | None = None) -> Array:
    """Return the thrust commands (counts) that the compensation turned into ratios: the curve, forwards.

    Args:
        motors: Ratios, shape (T, 4).
        supply: Voltage that the compensation saw (V), shape (T,).
        thrust_max: Largest thrust of a motor (N) that the firmware believes in; ours by default.
    """
    curve = lib.cf_platform_facts(lib.CF_PLATFORM_CF2).thrust
    volts = motors / COUNTS * supply[:, None]
    newtons = curve.c0 + volts * (curve.c1 + volts * (curve.c2 + volts * curve.c3))
    return np.maximum(newtons, 0.0) / (thrust_max or curve.thrust_max) * COUNTS


def replay_motors(flight: RecordedFlight, phases: Phases) -> MotorReplay:
    """Replay the commands of a PID flight.

    Raises:
        RangeError: If what it takes was not recorded, or all motors are saturated.
    """
    sentence = flight.missing("motors", "voltage", "desired")
    if sentence:
        raise RangeError(f"{sentence}: no thrust command to start from")
    begin, end = phases.compared
    in_time = (flight.time >= begin) & (flight.time < end)
    thrust = flight.desired[:, 3]
    unsaturated = (flight.motors.max(axis=1) < _SATURATED) & (thrust < _SATURATED) & (flight.motors.min(axis=1) > 1000)
    rows = in_time & unsaturated & ~flight.filled["motors"] & ~flight.filled["desired"]
    if rows.sum() < 50:
        raise RangeError(f"{flight.name}: motors are saturated nearly all the time")

    supply = supply_of(flight)
    candidates = (lib.cf_platform_facts(lib.CF_PLATFORM_CF2).thrust.thrust_max, OLDER_THRUST_MAX)
    tries = [_compensated(flight.motors, thrust, supply, top) for top in candidates]
    errors = [float(np.mean(np.abs((ours - flight.motors)[rows]))) for ours in tries]
    best = int(np.argmin(errors))
    relative = 100 * ((tries[best] - flight.motors) / np.maximum(flight.motors, 1.0))[rows]
    means, squares = relative.mean(axis=0), np.sqrt(np.mean(relative**2, axis=0))
    return MotorReplay(
        mean_percent=tuple(float(mean) for mean in means),
        rms_percent=tuple(float(square) for square in squares),
        saturated_share=float((in_time & ~unsaturated).sum() / max(in_time.sum(), 1)),
        thrust_max=round(float(candidates[best]), 6),
        time=flight.time,
        ours=tries[best],
        logged=flight.motors,
        rows=rows,
    )


def _compensated(motors: Array, thrust: Array, supply: Array, thrust_max: float) -> Array:
    power = ffi.new("cf_power_distribution_t *")
    lib.cf_power_distribution_init(power, lib.CF_PLATFORM_CF2)
    commands = commanded_thrust(motors, supply) * (power.thrust.thrust_max / thrust_max)
    power.thrust.thrust_max = thrust_max
    commands += (thrust - commands.mean(axis=1))[:, None]
    mixed, duty = ffi.new("motors_thrust_uncapped_t *"), ffi.new("motors_thrust_uncapped_t *")
    ratios = ffi.new("motors_thrust_pwm_t *")
    result = np.empty_like(motors)
    for row, command in enumerate(np.clip(commands, -1e6, 1e6).astype(int)):
        for motor in range(4):
            mixed.list[motor] = int(command[motor])
        lib.cf_power_distribution_compensate(power, mixed, float(supply[row]), duty)
        lib.cf_power_distribution_cap(power, duty, ratios)
        result[row] = list(ratios.list)
    return result
