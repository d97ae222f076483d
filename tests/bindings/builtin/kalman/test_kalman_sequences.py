"""What holds for the filter whatever the sensors say: bounds of the covariance, norm of the attitude."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

IDENTITY = ffi.new("mat3d *", [[1, 0, 0], [0, 1, 0], [0, 0, 1]])
CALIBRATION = ffi.new("lighthouseCalibrationSweep_t *")
LH2 = ffi.addressof(lib, "lighthouseCalibrationMeasurementModelLh2")


def point(x: float, y: float, z: float) -> dict[str, float]:
    return {"x": x, "y": y, "z": z}


# name of each type, and how its data come from eight numbers v and a deviation s
DATA = {
    "TDOA": ("tdoa", lambda v, s: {"anchorPositions": [point(*v[:3]), point(*v[3:6])], "distanceDiff": v[6]}),
    "Position": ("position", lambda v, s: {"pos": v[:3]}),
    "Pose": (
        "pose",
        lambda v, s: {
            "pos": v[:3],
            "quat": {"x": 0.3 * math.sin(v[3]), "y": 0.3 * math.sin(v[4]), "z": 0.3 * math.sin(v[5]), "w": 1.0},
            "stdDevPos": s,
            "stdDevQuat": s,
        },
    ),
    "Distance": ("distance", lambda v, s: {"pos": v[:3], "distance": v[3]}),
    "TOF": ("tof", lambda v, s: {"distance": v[0], "coneHalfAngle": math.radians(7.5)}),
    "AbsoluteHeight": ("height", lambda v, s: {"height": v[0]}),
    "Flow": ("flow", lambda v, s: {"dpixel": v[:2], "stdDevX": s, "stdDevY": s, "dt": 0.01}),
    "YawError": ("yawError", lambda v, s: {"yawError": math.sin(v[0])}),
    "Barometer": ("barometer", lambda v, s: {"baro": {"asl": v[0]}}),
}


def measurement(name: str, v: list[float], std_dev: float) -> ffi.CData:
    member, data = DATA[name]
    told = data(v, std_dev)
    if name not in ("Pose", "Flow", "Barometer"):
        told["stdDev"] = std_dev
    return ffi.new("measurement_t *", {"type": getattr(lib, f"MeasurementType{name}"), "data": {member: told}})


def sweep_angle(v: list[float], std_dev: float) -> tuple[ffi.CData, Any]:
    """Return a measurement and what it points at, to be kept."""
    kept = {"sensorPos": ffi.new("vec3d *", v[:3]), "rotorPos": ffi.new("vec3d *", v[3:6])}
    kept |= {"rotorRot": IDENTITY, "rotorRotInv": IDENTITY, "calib": CALIBRATION, "calibrationMeasurementModel": LH2}
    data = {**kept, "t": math.pi / 6, "measuredSweepAngle": v[6], "stdDev": std_dev}
    return ffi.new("measurement_t *", {"type": lib.MeasurementTypeSweepAngle, "data": {"sweepAngle": data}}), kept


def steps(largest: float, smallest_deviation: float) -> st.SearchStrategy:
    """Return flights: a list of (milliseconds, type, numbers, deviation)."""
    number = st.floats(-largest, largest, width=32)
    deviation = st.floats(smallest_deviation, 10.0, width=32)
    kind = st.sampled_from([*DATA, "SweepAngle"])
    return st.lists(
        st.tuples(st.integers(0, 12), kind, st.lists(number, min_size=8, max_size=8), deviation), max_size=30
    )


class Filter:
    """A filter and its loop, with the resets of the task."""

    def __init__(self, robust: bool) -> None:
        self.kalman = ffi.new("cf_kalman_t *")
        self.now_ms = 1000
        self.is_lost = False
        lib.cf_kalman_boot(self.kalman, self.now_ms)
        self.kalman.robust_tdoa = self.kalman.robust_twr = robust
        self.kalman.fuses_barometer = True
        self.acc = ffi.new("Axis3f *", {"x": 0.1, "y": -0.2, "z": 9.9})
        self.gyro = ffi.new("Axis3f *", {"x": 0.2, "y": -0.1, "z": 0.3})

    def start_tick(self) -> None:
        self.now_ms += 1
        if self.is_lost:
            lib.cf_kalman_init(self.kalman, self.now_ms)
        if self.now_ms % 10 == 0:
            lib.cf_kalman_predict(self.kalman, self.acc, self.gyro, self.now_ms, True)
        lib.cf_kalman_add_process_noise(self.kalman, self.now_ms)

    def end_tick(self) -> bool:
        """Return whether there was anything to finalize."""
        finalized = lib.cf_kalman_finalize(self.kalman)
        self.is_lost = not lib.cf_kalman_is_within_bounds(self.kalman)
        return finalized

    def fuse(self, name: str, v: list[float], std_dev: float) -> None:
        item, _kept = sweep_angle(v, std_dev) if name == "SweepAngle" else (measurement(name, v, std_dev), None)
        lib.cf_kalman_update(self.kalman, item, self.gyro, self.now_ms)

    def covariance(self) -> np.ndarray:
        return np.array([list(row) for row in self.kalman.core.P])

    def fly(self, flight: list) -> Iterator[None]:
        """Fuse the measurements of a flight; yield after each tick with something to finalize."""
        for milliseconds, name, v, std_dev in flight:
            for tick in range(milliseconds + 1):
                self.start_tick()
                if tick == milliseconds:
                    self.fuse(name, v, std_dev)
                if self.end_tick():
                    yield


def assert_bounded(kalman: ffi.CData, P: np.ndarray) -> None:
    np.testing.assert_array_equal(P, P.T)
    assert P.diagonal().min() >= np.float32(1e-6)
    assert P.max() <= 100.0  # NaN fails as well
    assert abs(np.linalg.norm(list(kalman.core.q)) - 1.0) < 1e-5


@given(steps(largest=2.0**50, smallest_deviation=2.0**-10))
def test_plain_models_keep_estimate_and_covariance_finite_while_squares_do_not_overflow(flight):
    estimator = Filter(robust=False)
    for _ in estimator.fly(flight):
        assert np.all(np.isfinite(list(estimator.kalman.core.S)))
        assert np.all(np.isfinite(estimator.covariance()))
        assert_bounded(estimator.kalman, estimator.covariance())


@given(steps(largest=2.0**100, smallest_deviation=2.0**-20), st.booleans())
def test_covariance_is_bounded_from_above_whatever_is_measured(flight, robust):
    """Off the diagonal the firmware knows no lower bound, and huge numbers find that out."""
    estimator = Filter(robust)
    for _ in estimator.fly(flight):
        assert_bounded(estimator.kalman, estimator.covariance())


@given(steps(largest=8.0, smallest_deviation=2.0**-7))
def test_plain_models_keep_the_covariance_positive_in_a_room(flight):
    estimator = Filter(robust=False)
    for _ in estimator.fly(flight):
        values = np.linalg.eigvalsh(estimator.covariance())
        assert values[0] >= -1e-5 * values[-1]
