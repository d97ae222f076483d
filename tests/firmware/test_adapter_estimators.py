"""Estimators of a checkout beside those of the builtin provider: the same bits.

The filter of the miniature computes with full matrices, that of the builtin provider leaves out zeros.
"""

import numpy as np
import pytest
from flight_inputs import UP, random_measurement
from side_by_side import STEPS, complementary_flight, filter_step, same

from crazychoir_fw._core import ffi, lib


def test_the_filter_gives_the_same_bits_for_every_measurement(pair, rng):
    seen = set()
    for drone in pair:
        drone.variable("parameters", "kalman.initialYaw")[0] = 0.3
        drone.variable("parameters", "flowdeck.flowdeckPos_x")[0] = 0.02
        drone.kalman_init(0)
    for now in range(1, STEPS):
        inputs = [random_measurement(rng) for _ in range(int(rng.integers(0, 3)))]
        seen |= {measurement.type for measurement in inputs}
        acc, gyro = UP + rng.normal(0, 0.05, 3), rng.normal(0, 0.3, 3)
        one, other = (filter_step(drone, now, inputs, acc, gyro) for drone in pair)
        assert same(one[0], other[0]), now
        assert one[1:] == other[1:]
    assert len(seen) == 11
    logs = [
        name
        for name in pair[0].variables("logs")
        if name.split(".")[0] in ("kalman", "kalman_pred", "outlierf", "tdoa")
    ]
    for name in logs:
        assert pair[0].variable("logs", name)[0] == pair[1].variable("logs", name)[0], name
    assert pair[0].variable("logs", "kalman_pred.measNX")[0] != 0


def test_the_robust_models_are_chosen_by_parameter(pair, rng):
    kinds = (lib.MeasurementTypeTDOA, lib.MeasurementTypeDistance)
    estimates = []
    for robust in (0, 1):
        for drone in pair:
            drone.variable("parameters", "kalman.robustTdoa")[0] = robust
            drone.variable("parameters", "kalman.robustTwr")[0] = robust
            drone.kalman_init(0)
        for now in range(1, 100):
            drawn = [random_measurement(np.random.default_rng([now, k])) for k in range(8)]
            inputs = [measurement for measurement in drawn if measurement.type in kinds]
            still = np.array([0.0, 0.0, 1.0]), np.zeros(3)
            one, other = (filter_step(drone, now, inputs, *still) for drone in pair)
            assert same(one[0], other[0]), now
        estimates.append(one[0].position.x)
    assert estimates[0] != estimates[1]


def test_a_drone_without_drift_to_its_first_attitude(pair):
    for drone in pair:
        drone.kalman_disable_attitude_reversion()
    tilted = np.array([0.0, 0.2, 1.0]), np.array([0.2, 0.0, 0.0])
    for now in range(1, 100):
        one, other = (filter_step(drone, now, [], *tilted) for drone in pair)
    assert same(one[0], other[0])
    assert one[0].attitude.roll == pytest.approx(np.degrees(0.2 * 0.09), rel=1e-2)


def test_a_lost_filter_is_told(pair):
    far = ffi.new(
        "measurement_t *",
        {"type": lib.MeasurementTypePosition, "data": {"position": {"pos": (200, 0, 0), "stdDev": 1e-3}}},
    )
    for drone in pair:
        drone.kalman_update(far, ffi.new("Axis3f *"), 1)
        assert not drone.kalman_is_within_bounds()
        drone.variable("parameters", "kalman.maxPos")[0] = 300
        assert drone.kalman_is_within_bounds()
        drone.variable("parameters", "kalman.pNVel")[0] = float("nan")
        drone.kalman_predict(ffi.new("Axis3f *"), ffi.new("Axis3f *"), 10, True)
        estimate = ffi.new("state_t *")
        drone.kalman_externalize(estimate, ffi.new("Axis3f *"))
        assert np.isnan(estimate.position.x), "noise that is no number must not be flown with"


def test_the_complementary_estimator_gives_the_same_bits(pair, rng):
    for one, other in complementary_flight(pair, rng):
        assert same(one, other)
    assert one.position.z != 0 and one.attitude.roll != 0
    assert pair[1].variable("logs", "posEstAlt.estimatedZ")[0] == one.position.z
    assert pair[1].console() == ""
