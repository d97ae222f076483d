"""From the controller's output to the motors: mixer, battery compensation, cap, test override, idle thrust."""

from __future__ import annotations

import functools
import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.parity.cases.case import Case, CaseRequest, Outcome
from crazychoir_fw.parity.inputs import FlightInputs, Inputs
from crazychoir_fw.parity.structs import columns, pointer, zeros

_OVERRIDES = (0, 1, 2, 3)


def power_cases(inputs: Inputs) -> list[Case]:
    """Return the cases of the mixer and what follows it."""
    cases = []
    for flight in inputs.flights.values():
        if not flight.has_loop or flight.estimator != "kalman" or "peers" in flight.tracks:
            continue
        cases.append(
            Case(
                group="power",
                name=f"mixer to motors: flight {flight.name}",
                about=f"control, voltage and motors of flight '{flight.name}'",
                run=functools.partial(_recorded, flight=flight),
                needs=("power_distribution", "battery_compensate", "power_cap"),
            )
        )
    made_up = {"group": "power", "by_number": True}
    cases += [
        Case(
            name=f"mixer: {name}",
            about="systematic, from all zero to far too much",
            run=functools.partial(_mix, mode=mode),
            needs=("power_distribution",),
            **made_up,
        )
        for name, mode in (
            ("legacy", lib.controlModeLegacy),
            ("force and torque", lib.controlModeForceTorque),
            ("normalized forces", lib.controlModeForce),
            ("duties", lib.controlModePWM),
        )
    ]
    cases += [
        Case(
            name="battery compensation",
            about="thrusts of all sizes at 0 to 5 V",
            run=_compensate,
            needs=("battery_compensate",),
            **made_up,
        ),
        Case(
            name="cap",
            about="duties below, in and above the range, idle thrust",
            run=_cap,
            needs=("power_cap",),
            **made_up,
        ),
        Case(
            name="idle thrust",
            about="parameter powerDist.idleThrust",
            run=_idle,
            needs=("idle_thrust",),
            **made_up,
        ),
        Case(
            name="motor override",
            about="modes 0 to 3 of motorPowerSet",
            run=_override,
            needs=("motor_override",),
            **made_up,
        ),
    ]
    return cases


def _recorded(request: CaseRequest, flight: FlightInputs) -> Outcome:
    tracks, count = flight.tracks, len(flight.tracks["tick"])
    block = request.boot(flight)
    functions, state = block.functions, block.state
    mix, compensate, cap = (functions[name] for name in ("power_distribution", "battery_compensate", "power_cap"))
    uncapped, compensated = zeros("motors_thrust_uncapped_t", count), zeros("motors_thrust_uncapped_t", count)
    pwm, was_capped = zeros("motors_thrust_pwm_t", count), np.zeros(count, bool)
    # each stage is fed with what was recorded, so that a deviation shows in the stage that makes it
    control = pointer(tracks["control"], "control_t")
    to_compensate = pointer(tracks["uncapped"], "motors_thrust_uncapped_t")
    to_cap = pointer(tracks["compensated"], "motors_thrust_uncapped_t")
    mixed, duty = pointer(uncapped, "motors_thrust_uncapped_t"), pointer(compensated, "motors_thrust_uncapped_t")
    motors = pointer(pwm, "motors_thrust_pwm_t")
    block.open()
    for i, voltage in enumerate(tracks["supply_voltage"].tolist()):
        mix(state, control + i, mixed + i)
        compensate(state, to_compensate + i, voltage, duty + i)
        was_capped[i] = cap(state, to_cap + i, motors + i)
    block.close()
    signals = {
        **columns(uncapped, "uncapped"),
        **columns(compensated, "compensated"),
        **columns(pwm, "pwm"),
        "was_capped": was_capped,
    }
    return Outcome(tracks["tick"], signals, block.failure)


@functools.cache
def control_rows(mode: int) -> NDArray[Any]:
    """Return systematic outputs of a controller in one mode."""
    if mode == lib.controlModeLegacy:
        moments = (-32768, -20001, -3, 0, 3, 20001, 32767)
        grid = list(itertools.product(moments, moments, moments, (0.0, 1.0, 100.5, 36000.25, 65535.0, 70000.0)))
        rows = zeros("control_t", len(grid))
        raw = np.zeros((len(grid), 4), np.float32)
        raw.view(np.int16)[:, :3] = np.array([row[:3] for row in grid])
        raw[:, 2] = [row[3] for row in grid]
        rows["normalizedForces"] = raw
    elif mode == lib.controlModeForceTorque:
        torques = (-1e-2, -1.3e-4, 0.0, 1e-5, 2.7e-3)
        grid = list(itertools.product((-0.1, 0.0, 0.07, 0.2845, 0.6, 2.0), torques, torques, torques))
        rows = zeros("control_t", len(grid))
        rows["normalizedForces"] = grid
    else:
        shares = (-0.1, 0.0, 0.3333, 1.0, 1.2)
        grid = list(itertools.product(shares, repeat=4))
        rows = zeros("control_t", len(grid))
        rows["normalizedForces"] = grid
    rows["controlMode"] = mode
    return rows


def _mix(request: CaseRequest, mode: int) -> Outcome:
    rows = control_rows(mode)
    block = request.boot()
    uncapped = zeros("motors_thrust_uncapped_t", len(rows))
    control, mixed = pointer(rows, "control_t"), pointer(uncapped, "motors_thrust_uncapped_t")
    for i in range(len(rows)):
        block.functions["power_distribution"](block.state, control + i, mixed + i)
    return Outcome(np.arange(len(rows)), columns(uncapped, "uncapped"), block.failure)


def _thrusts(count: int, low: int, high: int) -> NDArray[Any]:
    rows = zeros("motors_thrust_uncapped_t", count)
    rows["list"] = np.random.default_rng(7).integers(low, high, (count, 4))
    edges = (0, 1, -1, 65535, 65536, 32767, low, high)
    for i, edge in enumerate(edges):
        rows["list"][i] = edge
        rows["list"][len(edges) + i, i % 4] = edge
    return rows


def _compensate(request: CaseRequest) -> Outcome:
    voltages = np.repeat(np.float32([0.0, 1.99, 2.0, 2.5, 3.0, 3.3, 3.7, 4.2, 5.0]), 120)
    rows = _thrusts(len(voltages), 0, 70000)
    block = request.boot()
    found = zeros("motors_thrust_uncapped_t", len(rows))
    given, duty = pointer(rows, "motors_thrust_uncapped_t"), pointer(found, "motors_thrust_uncapped_t")
    for i, voltage in enumerate(voltages.tolist()):
        block.functions["battery_compensate"](block.state, given + i, voltage, duty + i)
    return Outcome(np.arange(len(rows)), columns(found, "compensated"), block.failure)


def _cap(request: CaseRequest) -> Outcome:
    rows = _thrusts(3000, -70000, 200000)
    block = request.boot()
    pwm, was_capped = zeros("motors_thrust_pwm_t", len(rows)), np.zeros(len(rows), bool)
    given, motors = pointer(rows, "motors_thrust_uncapped_t"), pointer(pwm, "motors_thrust_pwm_t")
    for i in range(len(rows)):
        if i == len(rows) // 2 and "powerDist.idleThrust" in request.side.parameter_table:
            block.set_parameter("powerDist.idleThrust", 7000)
        was_capped[i] = block.functions["power_cap"](block.state, given + i, motors + i)
    return Outcome(np.arange(len(rows)), {**columns(pwm, "pwm"), "was_capped": was_capped}, block.failure)


def _idle(request: CaseRequest) -> Outcome:
    values = (None, 0, 1, 7000, 65535)
    block = request.boot()
    idle = np.zeros(len(values), np.int64)
    for i, value in enumerate(values):
        if value is not None and "powerDist.idleThrust" in request.side.parameter_table:
            block.set_parameter("powerDist.idleThrust", value)
        idle[i] = block.functions["idle_thrust"](block.state)
    return Outcome(np.arange(len(values)), {"idle": idle}, block.failure)


def _override(request: CaseRequest) -> Outcome:
    per_mode = 200
    count = per_mode * len(_OVERRIDES)
    block = request.boot()
    pwm = zeros("motors_thrust_pwm_t", count)
    dice = np.random.default_rng(9)
    pwm["list"] = dice.integers(0, 65536, (count, 4))
    voltages = dice.uniform(2.8, 4.2, count).astype(np.float32).tolist()
    motors = ffi.cast("motors_thrust_pwm_t *", pointer(pwm, "motors_thrust_pwm_t"))
    names = [f"motorPowerSet.m{i}" for i in range(1, 5)]
    for i in range(count):
        if i % per_mode == 0 and "motorPowerSet.enable" in request.side.parameter_table:
            block.set_parameter("motorPowerSet.enable", _OVERRIDES[i // per_mode])
            for k, name in enumerate(names):
                block.set_parameter(name, 10000 + 9000 * k)
        block.functions["motor_override"](block.state, voltages[i], motors + i)
    return Outcome(np.arange(count), columns(pwm, "pwm"), block.failure)
