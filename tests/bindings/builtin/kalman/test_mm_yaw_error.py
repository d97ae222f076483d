"""Yaw error (docs/reference/estimators.md#5.5 and #17.H)."""

import pytest

from crazychoir_fw._core import ffi, lib


def measured(yaw_error: float) -> ffi.CData:
    return ffi.new("yawErrorMeasurement_t *", {"yawError": yaw_error, "stdDev": 0.01})


def test_check_vector_h(helpers):
    core = helpers.single_update_core()
    lib.kalmanCoreUpdateWithYawError(core, measured(0.02))
    helpers.SingleUpdate((0.5, -0.3, 1.2, 0.0), (0.04, 0.03, 0.02, 1e-3), (0.0, 0.002)).assert_same_as(core)
    assert core.S[8] == pytest.approx(-0.01, rel=1e-6)
    assert core.P[8][8] == pytest.approx(4.99999987e-5, rel=1e-6)


def test_a_positive_error_turns_the_estimate_clockwise(helpers):
    core = helpers.single_update_core()
    lib.kalmanCoreUpdateWithYawError(core, measured(0.02))
    assert lib.kalmanCoreFinalize(core)
    state = ffi.new("state_t *")
    lib.kalmanCoreExternalizeState(core, state, helpers.axis3f(0, 0, 1))
    assert state.attitude.yaw == pytest.approx(-0.573, abs=1e-3)


def test_a_second_error_before_finalize_pushes_on(helpers):
    """The innovation is state minus measurement, so that a left-over error counts with the wrong sign."""
    core = helpers.single_update_core()
    lib.kalmanCoreUpdateWithYawError(core, measured(0.02))
    lib.kalmanCoreUpdateWithYawError(core, measured(0.0))
    assert core.S[8] < -0.01
