"""The Kalman filter: recorded measurements of every positioning system, and made-up ones of every type."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.parity.cases.case import Case, CaseRequest, Outcome
from crazychoir_fw.parity.inputs import FlightInputs, Inputs
from crazychoir_fw.parity.structs import columns, pointer, zeros

_NEEDS = (
    "kalman_init",
    "kalman_predict",
    "kalman_add_process_noise",
    "kalman_update",
    "kalman_finalize",
    "kalman_is_within_bounds",
    "kalman_externalize",
)
_LOGS = ("kalman", "kalman_pred", "outlierf", "tdoa")
_PREDICTION = 10  # [ms]
_GRAVITY = 9.81
_DEG_TO_RAD = float(np.float32(np.pi / 180.0))

_TYPES = {
    "difference of distances": lib.MeasurementTypeTDOA,
    "position": lib.MeasurementTypePosition,
    "pose": lib.MeasurementTypePose,
    "distance": lib.MeasurementTypeDistance,
    "range": lib.MeasurementTypeTOF,
    "height": lib.MeasurementTypeAbsoluteHeight,
    "flow": lib.MeasurementTypeFlow,
    "yaw error": lib.MeasurementTypeYawError,
    "sweep angle": lib.MeasurementTypeSweepAngle,
    "barometer": lib.MeasurementTypeBarometer,
}
_ROBUST = {"difference of distances": "kalman.robustTdoa", "distance": "kalman.robustTwr"}
MADE_UP_TICKS = 600


def kalman_cases(inputs: Inputs) -> list[Case]:
    """Return the cases of the filter."""
    common = {"group": "kalman", "needs": _NEEDS, "log_groups": _LOGS}
    flights = {}
    for flight in inputs.flights.values():
        if flight.estimator == "kalman" and (not flight.has_loop or flight.name == "pid"):
            flights[flight.name] = flight
    cases = [
        Case(
            name=f"flight {flight.name}",
            about=_describe(flight),
            run=functools.partial(_replay, flight=flight),
            **common,
        )
        for flight in flights.values()
    ]
    for word, kind in _TYPES.items():
        for parameter in [None, *([_ROBUST[word]] if word in _ROBUST else [])]:
            name = f"{word}, robust model" if parameter else word
            run = functools.partial(_made_up, kind=kind, parameter=parameter)
            about = "made up: good, wrong by far and degenerate ones"
            cases.append(Case(name=f"made up: {name}", about=about, run=run, **common))
    cases.append(
        Case(
            name="out of bounds",
            about="a drone that is said to be 130 m away",
            run=functools.partial(_made_up, kind=lib.MeasurementTypePosition, parameter=None, far=130.0),
            **common,
        )
    )
    cases.append(
        Case(
            name="without attitude reversion",
            about="the same as 'made up: range', with kalman_disable_attitude_reversion",
            run=functools.partial(_made_up, kind=lib.MeasurementTypeTOF, parameter=None, is_reverting=False),
            **{**common, "needs": (*_NEEDS, "kalman_disable_attitude_reversion")},
        )
    )
    return cases


def measurement_types(flight: FlightInputs) -> NDArray[np.uint32]:
    """Return the type of each measurement of a flight, shape (M,)."""
    return np.ascontiguousarray(flight.measurements["measurement"][:, :4]).view(np.uint32)[:, 0]


def _describe(flight: FlightInputs) -> str:
    present = set(measurement_types(flight).tolist())
    words = [word for word, kind in _TYPES.items() if kind in present]
    return f"{len(flight.measurements)} measurements: inertial, {', '.join(words)}"


class _Task:
    """One loop of the filter's task per tick, in the firmware's order, with the functions of one provider."""

    def __init__(self, request: CaseRequest, flight: FlightInputs | None, samples: int, start: int) -> None:
        self.block = request.boot(flight)
        self._f = self.block.functions
        self._state = self.block.state
        self._acc, self._gyro = ffi.new("Axis3fSubSampler_t *"), ffi.new("Axis3fSubSampler_t *")
        self._acc_latest, self._gyro_latest = ffi.new("Axis3f *"), ffi.new("Axis3f *")
        self._resolved = ffi.new("cf_resolved_sweep_t *")
        self.logs = request.gatherer(self.block, samples)
        self._next_prediction = start
        self._is_reset_due = False
        self._sample = 0
        self.estimates = zeros("state_t", samples)
        self._estimate = pointer(self.estimates, "state_t")
        self.is_finalized = np.zeros(samples, bool)
        self.is_within = np.zeros(samples, bool)
        self._restart(0)

    def _restart(self, now: int) -> None:
        lib.axis3fSubSamplerInit(self._acc, _GRAVITY)
        lib.axis3fSubSamplerInit(self._gyro, _DEG_TO_RAD)
        self._f["kalman_init"](self._state, now)

    def loop(self, now: int, is_flying: bool, queue: list[tuple[int, Any, Any]], stations: Any) -> None:
        """Run one loop.

        Args:
            now: Tick (ms).
            is_flying: What the supervisor thinks.
            queue: Type, measurement and, of inertial samples, their `Axis3f`.
            stations: What sweep angles refer to.
        """
        f, state = self._f, self._state
        if self._is_reset_due:
            self._restart(now)
        if now >= self._next_prediction:
            acc, gyro = lib.axis3fSubSamplerFinalize(self._acc), lib.axis3fSubSamplerFinalize(self._gyro)
            f["kalman_predict"](state, acc, gyro, now, is_flying)
            self._next_prediction = now + _PREDICTION
        f["kalman_add_process_noise"](state, now)
        for kind, measurement, axes in queue:
            if kind == lib.MeasurementTypeGyroscope:
                self._gyro_latest[0] = axes[0]
                lib.axis3fSubSamplerAccumulate(self._gyro, axes)
            elif kind == lib.MeasurementTypeAcceleration:
                self._acc_latest[0] = axes[0]
                lib.axis3fSubSamplerAccumulate(self._acc, axes)
            else:
                if kind == lib.MeasurementTypeSweepAngle:
                    measurement = lib.cf_lighthouse_resolve(self._resolved, measurement, stations)
                f["kalman_update"](state, measurement, self._gyro_latest, now)
        i = self._sample
        self.is_finalized[i] = f["kalman_finalize"](state)
        self.is_within[i] = f["kalman_is_within_bounds"](state)
        self._is_reset_due = not self.is_within[i]
        f["kalman_externalize"](state, self._estimate + i, self._acc_latest)
        self.logs.take(i)
        self._sample += 1

    def outcome(self, ticks: NDArray[Any]) -> Outcome:
        signals = {
            **columns(self.estimates, "estimate"),
            "is_finalized": self.is_finalized,
            "is_within_bounds": self.is_within,
            **self.logs.signals(),
        }
        return Outcome(ticks, signals, self.block.failure)


def _replay(request: CaseRequest, flight: FlightInputs) -> Outcome:
    ticks = flight.tracks["tick"]
    rows = np.ascontiguousarray(flight.measurements["measurement"])
    first = ffi.cast("measurement_t *", rows.ctypes.data)
    # the samples of both inertial sensors begin where the union of the measurements does
    offset = ffi.offsetof("measurement_t", "data")
    axes = np.ascontiguousarray(rows[:, offset : offset + ffi.sizeof("Axis3f")])
    axis = ffi.cast("Axis3f *", axes.ctypes.data)
    kinds = measurement_types(flight).tolist()
    stations = pointer(flight.base_stations, "cf_base_stations_t")
    begins, ends = (places.tolist() for places in flight.measurements_at())
    flying = (flight.tracks["is_flying"] != 0).tolist()
    task = _Task(request, flight, len(ticks), start=0)
    with task.logs:
        for i, now in enumerate(ticks.tolist()):
            queue = [(kinds[k], first + k, axis + k) for k in range(begins[i], ends[i])]
            task.loop(now, flying[i], queue, stations)
    return task.outcome(ticks)


# --------------------------------------------------------------------------------------- made-up inputs


def _made_up(
    request: CaseRequest, kind: int, parameter: str | None, far: float | None = None, is_reverting: bool = True
) -> Outcome:
    ticks = np.arange(1, MADE_UP_TICKS + 1)
    task = _Task(request, None, len(ticks), start=0)
    if parameter is not None and parameter in request.side.parameter_table:
        task.block.set_parameter(parameter, 1)
    if not is_reverting:
        task.block.functions["kalman_disable_attitude_reversion"](task.block.state)
    dice = np.random.default_rng(100 + kind)
    stations = _stations()
    at = pointer(stations, "cf_base_stations_t")
    sample, gyro, acc = ffi.new("measurement_t *"), ffi.new("Axis3f *"), ffi.new("Axis3f *")
    with task.logs:
        for now in ticks.tolist():
            gyro.x, gyro.y, gyro.z = (float(value) for value in dice.normal(0.0, 20.0, 3))
            acc.x, acc.y, acc.z = (float(value) for value in dice.normal((0.0, 0.0, 1.0), 0.05))
            queue = [(lib.MeasurementTypeGyroscope, None, gyro), (lib.MeasurementTypeAcceleration, None, acc)]
            if now % 3 == 0:
                _roll(sample, kind, dice, now)
                if far is not None and now > MADE_UP_TICKS // 2:
                    sample.data.position.x = far
                queue.append((kind, sample, None))
            task.loop(now, now > 100, queue, at)
    return task.outcome(ticks)


def _stations() -> NDArray[Any]:
    """Return two base stations in opposite corners of a room, one with a calibration."""
    stations = zeros("cf_base_stations_t", 1)
    row = pointer(stations, "cf_base_stations_t")[0]
    for i, corner in enumerate(((-2.0, -2.0, 2.5), (2.0, 2.0, 2.5))):
        station = row.list[i]
        station.origin = corner
        lib.cf_lighthouse_look_at(corner, (0.0, 0.0, 0.5), station.rotation)
        station.has_geometry = True
        station.calibration.valid = True
    calibration = row.list[1].calibration
    for i in range(2):
        for k, name in enumerate(("phase", "tilt", "curve", "gibmag", "gibphase", "ogeemag", "ogeephase")):
            setattr(calibration.sweep[i], name, 0.004 * (k + 1) * (-1) ** (i + k))
    return stations


def _roll(sample: Any, kind: int, dice: np.random.Generator, now: int) -> None:
    """Make up one measurement near a drone that stands at the origin; one in twelve is far off, one in thirty odd."""
    ffi.memmove(sample, bytes(ffi.sizeof("measurement_t")), ffi.sizeof("measurement_t"))
    sample.type = kind
    spread = 5.0 if dice.random() < 1 / 12 else 0.02
    is_odd = dice.random() < 1 / 30
    x, y, z = (float(value) for value in dice.normal(0.0, spread, 3))
    _ROLLS[kind](sample.data, dice, now, is_odd, x, y, z)


def _tdoa(data: Any, dice: np.random.Generator, now: int, is_odd: bool, x: float, y: float, z: float) -> None:
    a, b = dice.uniform(-3.0, 3.0, 3), dice.uniform(-3.0, 3.0, 3)
    b = a if is_odd else b
    for point, place in ((data.tdoa.anchorPositions[0], a), (data.tdoa.anchorPositions[1], b)):
        point.x, point.y, point.z = place.tolist()
    data.tdoa.anchorIds = [0, 1]
    data.tdoa.distanceDiff = float(np.linalg.norm(b) - np.linalg.norm(a)) + x
    data.tdoa.stdDev = 0.15


def _position(data: Any, dice: np.random.Generator, now: int, is_odd: bool, x: float, y: float, z: float) -> None:
    data.position.x, data.position.y, data.position.z, data.position.stdDev = x, y, z, 0.01


def _pose(data: Any, dice: np.random.Generator, now: int, is_odd: bool, x: float, y: float, z: float) -> None:
    half = dice.normal(0.0, 0.02, 3)
    data.pose.x, data.pose.y, data.pose.z = x, y, z
    data.pose.quat.x, data.pose.quat.y, data.pose.quat.z = half.tolist()
    data.pose.quat.w = float(np.sqrt(1.0 - half @ half))
    data.pose.stdDevPos, data.pose.stdDevQuat = 0.01, 4.5e-3


def _distance(data: Any, dice: np.random.Generator, now: int, is_odd: bool, x: float, y: float, z: float) -> None:
    anchor = np.zeros(3) if is_odd else dice.uniform(-3.0, 3.0, 3)
    data.distance.x, data.distance.y, data.distance.z = anchor.tolist()
    data.distance.distance, data.distance.stdDev = float(np.linalg.norm(anchor)) + x, 0.25


def _range(data: Any, dice: np.random.Generator, now: int, is_odd: bool, x: float, y: float, z: float) -> None:
    data.tof.timestamp, data.tof.distance = now, 0.0 if is_odd else abs(z) + 0.02
    data.tof.stdDev, data.tof.coneHalfAngle = 0.0025, 0.2


def _height(data: Any, dice: np.random.Generator, now: int, is_odd: bool, x: float, y: float, z: float) -> None:
    data.height.timestamp, data.height.height, data.height.stdDev = now, z, 0.01


def _flow(data: Any, dice: np.random.Generator, now: int, is_odd: bool, x: float, y: float, z: float) -> None:
    data.flow.timestamp, data.flow.dpixelx, data.flow.dpixely = now, 50.0 * x, 50.0 * y
    data.flow.stdDevX = data.flow.stdDevY = 2.0
    data.flow.dt = 0.0 if is_odd else 0.01


def _yaw_error(data: Any, dice: np.random.Generator, now: int, is_odd: bool, x: float, y: float, z: float) -> None:
    data.yawError.timestamp, data.yawError.yawError, data.yawError.stdDev = now, x, 0.01


def _sweep_angle(data: Any, dice: np.random.Generator, now: int, is_odd: bool, x: float, y: float, z: float) -> None:
    sweep = data.sweepAngle
    sweep.timestamp, sweep.sensorId = now, int(dice.integers(4))
    sweep.baseStationId, sweep.sweepId = int(dice.integers(2)), int(dice.integers(2))
    sweep.t = lib.cf_lighthouse_tilt(sweep.sweepId)
    sweep.measuredSweepAngle, sweep.stdDev = 0.1 * x, 1e-4


def _barometer(data: Any, dice: np.random.Generator, now: int, is_odd: bool, x: float, y: float, z: float) -> None:
    data.barometer.baro.pressure, data.barometer.baro.temperature = 1000.0 + x, 25.0
    data.barometer.baro.asl = 100.0 + z


_ROLLS = {
    lib.MeasurementTypeTDOA: _tdoa,
    lib.MeasurementTypePosition: _position,
    lib.MeasurementTypePose: _pose,
    lib.MeasurementTypeDistance: _distance,
    lib.MeasurementTypeTOF: _range,
    lib.MeasurementTypeAbsoluteHeight: _height,
    lib.MeasurementTypeFlow: _flow,
    lib.MeasurementTypeYawError: _yaw_error,
    lib.MeasurementTypeSweepAngle: _sweep_angle,
    lib.MeasurementTypeBarometer: _barometer,
}
