"""Lighthouse sweeps (docs/reference/estimators.md#5.11 and #17.H)."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from crazychoir_fw._core import ffi, lib


class Sweep:
    """A measurement with everything that it points at; rotation is that of the rotor to the world."""

    def __init__(self, rotation: np.ndarray, rotor: list[float], sensor: list[float], t: float) -> None:
        self.rotation, self.rotor, self.sensor, self.t = rotation, np.array(rotor), np.array(sensor), t
        self._kept = {
            "sensorPos": ffi.new("vec3d *", sensor),
            "rotorPos": ffi.new("vec3d *", rotor),
            "rotorRot": ffi.new("mat3d *", rotation.tolist()),
            "rotorRotInv": ffi.new("mat3d *", rotation.T.tolist()),
            "calib": ffi.new("lighthouseCalibrationSweep_t *"),
        }
        self.data = ffi.new("sweepAngleMeasurement_t *", {**self._kept, "t": t, "stdDev": 0.001})
        self.data.calibrationMeasurementModel = ffi.addressof(lib, "lighthouseCalibrationMeasurementModelLh2")

    def predict(self, X: np.ndarray, R: np.ndarray) -> float:
        """Return the angle of an ideal light plane in float64."""
        x, y, z = self.rotation.T @ (X[:3] + R @ self.sensor - self.rotor)
        return math.atan2(y, x) + math.asin(z * math.tan(self.t) / math.hypot(x, y))


@pytest.fixture
def outlier_filter():
    state = ffi.new("OutlierFilterLhState_t *")
    lib.outlierFilterLighthouseReset(state, 1000)
    return state


@pytest.fixture
def sweep_h():
    sweep = Sweep(np.eye(3), [-2, -1, 2], [0.015, 0.0075, 0.0], -math.pi / 6)
    sweep.data.measuredSweepAngle = 0.5
    return sweep


def test_check_vector_h(helpers, sweep_h, outlier_filter):
    core = helpers.single_update_core()
    lib.kalmanCoreUpdateWithSweepAngles(core, sweep_h.data, 1008, outlier_filter)
    helpers.SingleUpdate(
        (0.444050968, -0.213562712, 1.16301715, -0.00279745087),
        (0.0320903994, 0.0111213056, 0.0165440217, 9.8022609e-4),
        (0.0122197745, 0.00160452013),
    ).assert_same_as(core)
    assert (outlier_filter.openingWindowMs, outlier_filter.openingTimeMs) == (-16, 992)


def test_check_vector_h_has_this_derivative_and_innovation(helpers, sweep_h, outlier_filter):
    core, twin = helpers.single_update_core(), helpers.single_update_core()
    lib.kalmanCoreUpdateWithSweepAngles(core, sweep_h.data, 1008, outlier_filter)
    H = [-0.169832215, 0.349838465, -0.224521667, 0, 0, 0, 0, 0, 0]
    lib.kalmanCoreScalarUpdate(twin, H, 0.0480527282, 0.001)
    np.testing.assert_allclose(helpers.array(core.S), helpers.array(twin.S), rtol=1e-6)
    np.testing.assert_allclose(helpers.array(core.P), helpers.array(twin.P), rtol=1e-5, atol=1e-10)


@pytest.mark.parametrize("seed", range(20))
def test_sweep_is_an_update_with_the_derivative_of_the_angle(helpers, outlier_filter, seed):
    rng = np.random.default_rng(seed)
    core = helpers.random_core(seed)
    # the base station looks at the drone from 2 to 4 m, turned a little
    position = helpers.array(core.S)[:3].astype(float)
    rotation = Rotation.from_euler("zyx", rng.normal(size=3) * 0.3).as_matrix()
    rotor = position - rotation @ np.array([rng.uniform(2, 4), rng.normal() * 0.5, rng.normal() * 0.5])
    sweep = Sweep(rotation, rotor.tolist(), [0.015, -0.0075, 0.0], math.copysign(math.pi / 6, rng.normal()))
    R = helpers.array(core.R).astype(float)
    angle = sweep.predict(position, R) + rng.normal() * 0.01
    sweep.data.measuredSweepAngle, sweep.data.stdDev = angle, 0.1

    S, P = helpers.updated_in_double(core, lambda X: sweep.predict(X, R), angle, 0.1)
    lib.kalmanCoreUpdateWithSweepAngles(core, sweep.data, 1008, outlier_filter)
    np.testing.assert_allclose(helpers.array(core.S), S, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(helpers.array(core.P), P, rtol=1e-3, atol=1e-4)


def test_what_the_filter_refuses_is_not_fused(helpers, sweep_h, outlier_filter):
    core = helpers.single_update_core()
    before = ffi.buffer(core)[:]
    outlier_filter.openingTimeMs, outlier_filter.openingWindowMs = 1040, 40
    lib.kalmanCoreUpdateWithSweepAngles(core, sweep_h.data, 1008, outlier_filter)
    assert ffi.buffer(core)[:] == before
    assert outlier_filter.openingWindowMs == 32


@pytest.mark.parametrize("height", [2.0, math.sqrt(3.0), 1.7320])
def test_beyond_the_reach_of_the_light_plane_there_is_no_update(helpers, outlier_filter, height):
    """A plane tilted by 30 degrees ends at sqrt(3) of the distance above the rotor; the filter is asked before."""
    sweep = Sweep(np.eye(3), [-1, 0, 0], [0, 0, 0], math.pi / 6)
    core = helpers.single_update_core()
    helpers.assign(core.S, np.array([0, 0, height, 0, 0, 0, 0, 0, 0]))
    before = ffi.buffer(core)[:]
    sweep.data.measuredSweepAngle = math.pi / 2
    lib.kalmanCoreUpdateWithSweepAngles(core, sweep.data, 1008, outlier_filter)
    assert ffi.buffer(core)[:] == before
    assert outlier_filter.openingTimeMs == 1008 + outlier_filter.openingWindowMs


def test_on_the_axis_of_the_rotor_there_is_no_update(helpers, outlier_filter):
    sweep = Sweep(np.eye(3), [0.5, -0.3, 1.2], [0, 0, 0], math.pi / 6)
    core = helpers.single_update_core()
    before = ffi.buffer(core)[:]
    lib.kalmanCoreUpdateWithSweepAngles(core, sweep.data, 1008, outlier_filter)
    assert ffi.buffer(core)[:] == before
