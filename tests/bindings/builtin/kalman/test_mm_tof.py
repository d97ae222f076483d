"""Range to the floor (docs/reference/estimators.md#5.6, #16.1 and #17.D)."""

import math

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib


def test_check_vector_d(flight):
    core = flight.after("D")
    assert core.S[2] == pytest.approx(3.00165868, rel=1e-6)
    assert core.S[5] == pytest.approx(0.00494186301, rel=1e-6)
    assert core.P[2][2] == pytest.approx(9.61723345e-5, rel=1e-6)


def tilted_core(helpers, r22: float) -> ffi.CData:
    """Return a filter at 1.5 m whose only variance of interest is that of z."""
    core = ffi.new("kalmanCoreData_t *")
    helpers.assign(core.P, np.eye(9))
    core.S[2] = 1.5
    core.R[2][2] = r22
    return core


def measured(half_cone: float) -> ffi.CData:
    return ffi.new("tofMeasurement_t *", {"distance": 1.6, "stdDev": 0.045, "coneHalfAngle": half_cone})


# docs/reference/estimators.md#16.1, and the cone of 15 degrees that every real deck has
@pytest.mark.parametrize(
    ("tilt", "half_cone", "derivative", "innovation"),
    [
        (0.2, 0.0, 1.0203388, 0.0694917),
        (0.3, 0.1, 1.0203388, 0.0694917),
        (0.05, 0.1, 1.0, 0.1),
        (math.radians(7.5) + 0.2, math.radians(7.5), 1.0203388, 0.0694917),
        (0.1, math.radians(7.5), 1.0, 0.1),
        (0.0, 0.0, 1.0, 0.1),
    ],
)
def test_only_tilt_beyond_half_the_cone_counts(helpers, tilt, half_cone, derivative, innovation):
    core = tilted_core(helpers, math.cos(tilt))
    lib.kalmanCoreUpdateWithTof(core, measured(half_cone))
    # P_ZZ was 1: its new value gives H, and with H the correction gives the innovation
    assert core.P[2][2] == pytest.approx(0.045**2 / (derivative**2 + 0.045**2), rel=1e-4)
    gain = derivative / (derivative**2 + 0.045**2)
    assert (core.S[2] - 1.5) / gain == pytest.approx(innovation, rel=2e-5)


@pytest.mark.parametrize("r22", [0.099, 0.05, 0.0, -0.5, -1.0, math.nan])
def test_range_is_refused_when_the_floor_is_out_of_sight(helpers, r22):
    core = tilted_core(helpers, r22)
    before = ffi.buffer(core)[:]
    lib.kalmanCoreUpdateWithTof(core, measured(0.1))
    assert ffi.buffer(core)[:] == before


def test_the_gate_compares_in_double(helpers):
    # the float nearest to 0.1 lies above the double nearest to 0.1
    core = tilted_core(helpers, float(np.float32(0.1)))
    core.isUpdated = False
    lib.kalmanCoreUpdateWithTof(core, measured(0.1))
    assert core.isUpdated
