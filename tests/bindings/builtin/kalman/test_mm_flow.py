"""Optical flow (docs/reference/estimators.md#5.7 and #17.E)."""

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib

F = np.float32


def test_check_vector_e(flight, helpers):
    core = flight.after("E")
    assert flight.flow_log.predicted_x == pytest.approx(0.0971603, rel=1e-6)
    assert flight.flow_log.predicted_y == pytest.approx(0.0485801, rel=1e-6)
    assert flight.flow_log.measured_x == pytest.approx(0.4)
    assert flight.flow_log.measured_y == pytest.approx(-0.3)
    state = [1.0000006, 1.99999619, 3.00165868, 1.89580e-4, -2.18044e-4, 0.00494193798, 0, 0, 0]
    np.testing.assert_allclose(helpers.array(core.S), state, rtol=2e-6)
    assert core.P[3][3] == pytest.approx(1.53845336e-4, rel=1e-6)
    assert core.P[4][4] == pytest.approx(1.53844740e-4, rel=1e-6)


def measured(dx: float, dy: float) -> ffi.CData:
    return ffi.new("flowMeasurement_t *", {"dpixelx": dx, "dpixely": dy, "stdDevX": 2.0, "stdDevY": 3.0, "dt": 0.01})


@pytest.mark.parametrize("lever", [(0.0, 0.0, 0.0), (0.03, -0.02, 0.01)])
@pytest.mark.parametrize("seed", range(10))
def test_flow_is_two_updates_with_what_was_known_before_the_first(helpers, seed, lever):
    core = helpers.random_core(seed)
    core.S[2] = abs(core.S[2])
    twin = helpers.DenseFilter.of(core)
    gyro = np.array([20.0, -30.0, 50.0], F)
    log = ffi.new("cf_flow_log_t *")
    lib.cf_mm_flow_update(core, measured(4.0, -3.0), helpers.axis3f(*gyro), helpers.axis3f(*lever), log)

    rate = gyro * (F(3.14159265358979) / F(180.0))
    rx, ry, rz = (F(r) for r in lever)
    z, r22 = max(twin.S[2], F(0.1)), twin.R[2, 2]
    k = F(0.01) * F(35.0) / F(0.71674)
    velocity = [twin.S[3] + (rate[1] * rz - rate[2] * ry), twin.S[4] + (rate[2] * rx - rate[0] * rz)]
    turn = [-rate[1], rate[0]]
    for i, (pixels, std_dev) in enumerate([(4.0, 2.0), (-3.0, 3.0)]):
        H = np.zeros(9, F)
        H[2] = k * (r22 * velocity[i] / (-z * z))
        H[3 + i] = k * (r22 / z)
        error = F(pixels) * F(0.1) - k * (velocity[i] * r22 / z + turn[i])
        twin.scalar_update(H, error, F(std_dev) * F(0.1))
    twin.assert_same_as(core)


def test_near_the_ground_the_height_counts_as_a_decimeter(helpers):
    cores = [helpers.random_core(0), helpers.random_core(0)]
    logs = [ffi.new("cf_flow_log_t *"), ffi.new("cf_flow_log_t *")]
    zero = helpers.axis3f(0, 0, 0)
    for core, log, z in zip(cores, logs, (0.02, 0.1), strict=True):
        core.S[2] = z
        lib.cf_mm_flow_update(core, measured(4.0, -3.0), zero, zero, log)
    assert ffi.buffer(logs[0])[:] == ffi.buffer(logs[1])[:]


def test_the_firmware_function_has_its_sensor_at_the_center(helpers):
    first, second = helpers.random_core(0), helpers.random_core(0)
    gyro = helpers.axis3f(10, 20, 30)
    lib.kalmanCoreUpdateWithFlow(first, measured(1.0, 2.0), gyro)
    lib.cf_mm_flow_update(second, measured(1.0, 2.0), gyro, helpers.axis3f(0, 0, 0), ffi.new("cf_flow_log_t *"))
    assert ffi.buffer(first)[:] == ffi.buffer(second)[:]
