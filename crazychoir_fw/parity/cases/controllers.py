"""The controllers: recorded flights, every combination of set-point modes, extremes, and public golden inputs."""

from __future__ import annotations

import functools
import itertools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi
from crazychoir_fw.onboard.core import check
from crazychoir_fw.parity.cases.case import Case, CaseRequest, Outcome, control_signals, joined
from crazychoir_fw.parity.inputs import FlightInputs, Inputs
from crazychoir_fw.parity.side import CONTROLLERS
from crazychoir_fw.parity.structs import joined_rows, pointer, zeros

_NEEDS = ("controller_init", "controller", "controller_type")
_LOGS = {
    "pid": ("controller", "pid_attitude", "pid_rate", "posCtl"),
    "mellinger": ("ctrlMel",),
    "indi": ("ctrlINDI", "posCtrlIndi", "posCtl"),
    "brescianini": ("ctrlBrescianini",),
    "lee": ("ctrlLee",),
}
_AXES = ("x", "y", "z", "roll", "pitch", "yaw", "quat")
_SAMPLES_PER_COMBINATION = 10  # so that loops of 100 Hz have a turn


def controller_cases(inputs: Inputs) -> list[Case]:
    """Return the cases of all controllers."""
    cases = []
    for word in CONTROLLERS:
        common = {"group": "controller", "needs": _NEEDS, "controller": word, "log_groups": _LOGS[word]}
        for flight in inputs.flights.values():
            if flight.has_loop and flight.controller == word and flight.estimator == "kalman":
                run = functools.partial(_recorded, word=word, flight=flight)
                about = f"flight '{flight.name}', {len(flight.tracks['tick'])} ticks"
                cases.append(Case(name=f"{word}: flight {flight.name}", about=about, run=run, **common))
        for name, about, rows in (
            ("modes", "all 2187 combinations of set-point modes, 10 steps each", _mode_rows),
            ("extremes", "errors far beyond any flight", _extreme_rows),
        ):
            run = functools.partial(_made_up, word=word, rows=rows)
            cases.append(Case(name=f"{word}: {name}", about=about, run=run, by_number=True, **common))
        run = functools.partial(_golden, word=word)
        about = "6 public golden cases, each from boot"
        cases.append(Case(name=f"{word}: golden", about=about, run=run, by_number=True, **common))
        run = functools.partial(_position_reset, word=word)
        if word == "pid":
            needs = (*_NEEDS, "reset_position_control")
            about = "position loops that forget in the middle"
            cases.append(
                Case(name="pid: position reset", about=about, run=run, by_number=True, **{**common, "needs": needs})
            )
    return cases


def _run(
    request: CaseRequest,
    word: str,
    setpoints: NDArray[Any],
    sensors: NDArray[Any],
    estimates: NDArray[Any],
    steps: NDArray[Any],
    flight: FlightInputs | None = None,
    reset_at: int = -1,
) -> Outcome:
    block = request.boot(flight)
    function, state = block.functions["controller"], block.state
    check(block.functions["controller_init"](state, CONTROLLERS[word]), f"{request.side.name}: controller {word}")
    count = len(steps)
    logs = request.gatherer(block, count)
    controls = zeros("control_t", count)
    setpoint, sensor = pointer(setpoints, "setpoint_t"), pointer(sensors, "sensorData_t")
    estimate, control = pointer(estimates, "state_t"), pointer(controls, "control_t")
    # one struct that the controller writes into, as in the loop: between its turns it leaves what was there
    present = ffi.new("control_t *")
    with logs:
        for i, step in enumerate(steps.tolist()):
            if i == reset_at:
                block.functions["reset_position_control"](state, ffi.addressof(estimate[i], "position"))
            function(state, present, setpoint + i, sensor + i, estimate + i, step)
            control[i] = present[0]
            logs.take(i)
    return Outcome(np.arange(count), {**control_signals(controls), **logs.signals()}, block.failure)


def _recorded(request: CaseRequest, word: str, flight: FlightInputs) -> Outcome:
    tracks = flight.tracks
    outcome = _run(request, word, tracks["setpoint"], tracks["sensors"], tracks["estimate"], tracks["step"], flight)
    outcome.ticks = tracks["tick"]
    return outcome


def _made_up(request: CaseRequest, word: str, rows: Any) -> Outcome:
    setpoints, sensors, estimates = rows()
    return _run(request, word, setpoints, sensors, estimates, np.arange(1, len(setpoints) + 1))


def _position_reset(request: CaseRequest, word: str) -> Outcome:
    setpoints, sensors, estimates = _smooth_rows(1000, seed=5, size=1.0)
    setpoints["mode"]["x"] = setpoints["mode"]["y"] = setpoints["mode"]["z"] = 1
    return _run(request, word, setpoints, sensors, estimates, np.arange(1, 1001), reset_at=500)


# ------------------------------------------------------------------------------------- systematic inputs


def _smooth_rows(count: int, seed: int, size: float) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return set-points, sensors and estimates that wander, `size` times what a flight sees."""
    dice = np.random.default_rng(seed)
    t = np.arange(count) / 1000.0

    def wave(scale: float) -> NDArray[np.float32]:
        rates, phases = dice.uniform(1.0, 20.0, 3), dice.uniform(0.0, 2 * np.pi, 3)
        waves = np.sin(t[:, None] * rates + phases).sum(axis=1) / 3
        return (size * scale * waves).astype(np.float32)

    setpoints, sensors, estimates = zeros("setpoint_t", count), zeros("sensorData_t", count), zeros("state_t", count)
    for axis in "xyz":
        estimates["position"][axis], setpoints["position"][axis] = wave(0.5), wave(0.5)
        estimates["velocity"][axis], setpoints["velocity"][axis] = wave(0.6), wave(0.6)
        estimates["acc"][axis], setpoints["acceleration"][axis] = wave(0.1), wave(1.0)
        setpoints["jerk"][axis] = wave(2.0)
        sensors["gyro"][axis] = wave(60.0)
        sensors["acc"][axis] = wave(0.1) + (1.0 if axis == "z" else 0.0)
    for angle in ("roll", "pitch", "yaw"):
        estimates["attitude"][angle] = wave(12.0 if angle != "yaw" else 60.0)
        setpoints["attitude"][angle] = wave(12.0 if angle != "yaw" else 60.0)
        setpoints["attitudeRate"][angle] = wave(60.0)
    _fill_quaternions(estimates)
    _fill_quaternions(setpoints)
    setpoints["thrust"] = np.clip(36000.0 + wave(20000.0), 0.0, 65535.0)
    setpoints["timestamp"] = np.arange(count)
    return setpoints, sensors, estimates


def _fill_quaternions(rows: NDArray[Any]) -> None:
    """Give rows the quaternion of their attitude, which has the pitch of the legacy frame."""
    attitude = rows["attitude"]
    half = [np.radians(attitude[name].astype(np.float64)) / 2 for name in ("roll", "pitch", "yaw")]
    (sr, sp, sy), (cr, cp, cy) = [[f(angle) for angle in half] for f in (np.sin, np.cos)]
    sp = -sp
    quaternion = rows["attitudeQuaternion"]
    quaternion["w"] = cr * cp * cy + sr * sp * sy
    quaternion["x"] = sr * cp * cy - cr * sp * sy
    quaternion["y"] = cr * sp * cy + sr * cp * sy
    quaternion["z"] = cr * cp * sy - sr * sp * cy


@functools.cache
def _mode_rows() -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    combinations = np.array(list(itertools.product(range(3), repeat=len(_AXES))))
    modes = np.repeat(combinations, _SAMPLES_PER_COMBINATION, axis=0)
    setpoints, sensors, estimates = _smooth_rows(len(modes), seed=1, size=1.0)
    for i, axis in enumerate(_AXES):
        setpoints["mode"][axis] = modes[:, i]
    which = np.arange(len(modes)) // _SAMPLES_PER_COMBINATION
    setpoints["velocity_body"] = which % 2 == 1
    setpoints["thrust"][which % 5 == 0] = 0.0
    return setpoints, sensors, estimates


@functools.cache
def _extreme_rows() -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    parts = [_smooth_rows(600, seed=seed, size=size) for seed, size in ((2, 3.0), (3, 10.0), (4, 30.0))]
    setpoints, sensors, estimates = (joined_rows(rows) for rows in zip(*parts, strict=True))
    which = np.arange(len(setpoints)) // 100 % 3
    for axis in ("x", "y", "z"):
        setpoints["mode"][axis] = np.where(which == 2, 2, 1)
    setpoints["mode"]["yaw"] = np.where(which == 0, 1, 2)
    estimates["attitude"]["yaw"] = (estimates["attitude"]["yaw"] + 180.0) % 360.0 - 180.0
    return setpoints, sensors, estimates


# (position, velocity, roll pitch yaw [rad], rates [rad/s], reference position, velocity, acceleration, yaw [deg],
# yaw rate [deg/s], repeats, jerk); docs/reference/cffirmware-api.md#12
_GOLDEN: tuple[tuple[Any, ...], ...] = (
    ((0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0), 0, 0, 1, (0, 0, 0)),
    (
        (0.1, -0.2, 0.3), (0.15, -0.05, 0.08), (0.15, -0.1, 0.2), (0.12, -0.08, 0.21), (0.5, -0.1, 0.7),
        (0.3, -0.2, 0.1), (0.4, -0.3, 0.2), 35, 12, 3, (0.8, -0.5, 0.25),
    ),
    (
        (-0.15, 0.25, 0.1), (-0.1, 0.06, -0.03), (-0.12, 0.09, -0.25), (-0.2, 0.14, -0.18), (0.25, -0.35, 0.5),
        (0.2, -0.18, 0.08), (-0.3, 0.25, 0.15), -40, -10, 2, (0, 0, 0),
    ),
    ((0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, -20), 45, 0, 1, (0, 0, 0)),
    ((0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0), (12, 0, -9.81), 0, 0, 1, (0, 0, 0)),
    (
        (-250, 250, -250), (-180, 180, -180), (-0.1, 0.12, -0.2), (-0.2, 0.15, -0.1), (250, -250, 250),
        (180, -180, 180), (0, 0, 0), -30, -8, 1, (0, 0, 0),
    ),
)  # fmt: skip


def golden_rows(case: int, is_pitch_negated: bool) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return set-points, sensors and estimates of a public golden case, one row per repetition."""
    position, velocity, angles, rates, wanted, speed, acceleration, yaw, yaw_rate, repeats, jerk = _GOLDEN[case]
    setpoints, sensors, estimates = (zeros(name, repeats) for name in ("setpoint_t", "sensorData_t", "state_t"))
    for i, axis in enumerate("xyz"):
        estimates["position"][axis], estimates["velocity"][axis] = position[i], velocity[i]
        setpoints["position"][axis], setpoints["velocity"][axis] = wanted[i], speed[i]
        setpoints["acceleration"][axis], setpoints["jerk"][axis] = acceleration[i], jerk[i]
        setpoints["mode"][axis] = 1
        sensors["gyro"][axis] = math.degrees(rates[i])
    setpoints["mode"]["yaw"] = 1
    setpoints["attitude"]["yaw"], setpoints["attitudeRate"]["yaw"] = yaw, yaw_rate
    degrees = [math.degrees(angle) for angle in angles]
    estimates["attitude"]["roll"], estimates["attitude"]["yaw"] = degrees[0], degrees[2]
    estimates["attitude"]["pitch"] = -degrees[1]
    _fill_quaternions(estimates)
    if not is_pitch_negated:
        estimates["attitude"]["pitch"] = degrees[1]
    return setpoints, sensors, estimates


def _golden(request: CaseRequest, word: str) -> Outcome:
    outcomes = []
    for case in range(len(_GOLDEN)):
        rows = golden_rows(case, is_pitch_negated=word != "lee")
        outcomes.append(_run(request, word, *rows, np.arange(0, 2 * len(rows[0]), 2)))
    return joined(outcomes)
