"""Estimate and setpoint in whole numbers (docs/reference/control-pid.md#16)."""

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib

STATE = {
    "position": {"x": 1.2345, "y": -1.2345, "z": 0.9999},
    "velocity": {"x": 0.0019, "y": -0.0019, "z": 2.0},
    "acc": {"x": 0.1, "y": -0.1, "z": 0.5},
    "attitudeQuaternion": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
}


def compress(gyro=(0.0, 0.0, 0.0), **changes):
    state = ffi.new("state_t *", {**STATE, **changes})
    return lib.cf_compress_state(state, ffi.new("Axis3f *", {"axis": list(gyro)}))


def test_state_is_in_millimeters_cut_towards_zero():
    z = compress()
    assert [z.x, z.y, z.z] == [1234, -1234, 999]
    assert [z.vx, z.vy, z.vz] == [1, -1, 2000]
    assert z.quat == 0xC0000000


def test_acceleration_has_gravity_in_it():
    z = compress()
    assert [z.ax, z.ay, z.az] == [981, -981, 14715]
    assert compress(acc={"x": 0, "y": 0, "z": 0}).az == 9810


def test_rates_are_milliradians_with_legacy_pitch():
    z = compress(gyro=(100.0, 100.0, -57.29578))
    assert [z.rateRoll, z.ratePitch, z.rateYaw] == [1745, -1745, -1000]


@pytest.mark.parametrize(("meters", "millimeters"), [(32.767, 32767), (32.769, -32767), (-32.77, 32766), (65.536, 0)])
def test_beyond_33_meters_it_wraps_around(meters, millimeters):
    # the next float towards the number, so that the cut lands on it
    x = float(np.nextafter(np.float32(meters), np.float32(np.sign(meters) * np.inf)))
    assert compress(position={"x": x, "y": 0, "z": 0}).x == millimeters


@pytest.mark.parametrize(("value", "whole"), [(np.nan, 0), (np.inf, -1), (-np.inf, 0), (3e38, -1)])
def test_what_does_not_fit_32_bits_saturates_there(value, whole):
    """As the processor of the vehicle converts: INT32_MAX ends in 0xffff, INT32_MIN in 0x0000."""
    assert compress(position={"x": value, "y": 0, "z": 0}).x == whole


def test_setpoint_is_in_millimeters():
    setpoint = ffi.new(
        "setpoint_t *",
        {
            "position": {"x": 1.0, "y": -2.0, "z": 0.5},
            "velocity": {"x": 0.25, "y": -0.125, "z": 3.0},
            "acceleration": {"x": 9.5, "y": -9.5, "z": 0.0005},
        },
    )
    z = lib.cf_compress_setpoint(setpoint)
    assert [z.x, z.y, z.z, z.vx, z.vy, z.vz, z.ax, z.ay, z.az] == [1000, -2000, 500, 250, -125, 3000, 9500, -9500, 0]
