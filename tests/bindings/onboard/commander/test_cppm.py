"""Sticks of a remote control (docs/reference/planner-commander.md#9.1 and #16)."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from setpoint_members import ABS, VELOCITY, garbage, members, modes

from crazychoir_fw._core import ffi, lib

STICKS = {"roll": 1600, "pitch": 1450, "yaw": 1550, "thrust": 1500}


@pytest.fixture
def cppm():
    cppm = ffi.new("cf_cppm_t *")
    lib.cf_cppm_init(cppm)
    return cppm


def fly(cppm, sticks):
    setpoint = garbage()
    assert lib.cf_setpoint_cppm(setpoint, cppm, ffi.new("cf_cppm_sticks_t *", sticks)) == lib.CF_OK
    return setpoint


ANGLES = {"attitude.roll": -10.0, "attitude.pitch": 5.0} | modes(roll=ABS, pitch=ABS)
RATES = {"attitudeRate.roll": -144.0, "attitudeRate.pitch": 72.0} | modes(roll=VELOCITY, pitch=VELOCITY)
YAW_AND_THRUST = {"attitudeRate.yaw": -40.0, "thrust": 32767.5} | modes(yaw=VELOCITY)


@pytest.mark.parametrize(
    ("aux", "expected"),
    [([], ANGLES), ([1000], RATES), ([1499], RATES), ([1500], ANGLES), ([2000, 1000], ANGLES), ([1000] * 10, RATES)],
)
def test_first_auxiliary_channel_chooses_between_angles_and_rates(cppm, aux, expected) -> None:
    setpoint = fly(cppm, STICKS | {"n_aux": len(aux), "aux": aux})
    assert members(setpoint) == pytest.approx(expected | YAW_AND_THRUST, rel=1e-6)


@pytest.mark.parametrize(("pulse", "thrust"), [(0, 0.0), (999, 0.0), (1000, 0.0), (2000, 65535.0), (3000, 131070.0)])
def test_thrust_has_a_lower_limit_only(cppm, pulse: int, thrust: float) -> None:
    assert fly(cppm, STICKS | {"thrust": pulse}).thrust == thrust


def test_scales_are_parameters(cppm) -> None:
    cppm.angRoll, cppm.angPitch, cppm.rateYaw = 10.0, 20.0, 100.0
    setpoint = fly(cppm, STICKS)
    assert setpoint.attitude.roll == pytest.approx(-2.0)
    assert setpoint.attitude.pitch == pytest.approx(2.0)
    assert setpoint.attitudeRate.yaw == pytest.approx(-10.0)
    cppm.rateRoll, cppm.ratePitch = 10.0, 20.0
    setpoint = fly(cppm, STICKS | {"n_aux": 1, "aux": [0]})
    assert setpoint.attitudeRate.roll == pytest.approx(-2.0)
    assert setpoint.attitudeRate.pitch == pytest.approx(2.0)


@pytest.mark.parametrize("scale", [math.nan, math.inf, 3e38])
@pytest.mark.parametrize("name", ["rateRoll", "ratePitch", "angRoll", "angPitch", "rateYaw"])
def test_scale_that_makes_no_number_is_refused(cppm, name: str, scale: float) -> None:
    setattr(cppm, name, scale)
    sticks = {"roll": 65535, "pitch": 65535, "yaw": 65535, "n_aux": "rate" in name and name != "rateYaw"}
    setpoint = garbage()
    assert lib.cf_setpoint_cppm(setpoint, cppm, ffi.new("cf_cppm_sticks_t *", sticks)) == lib.CF_ERR_VALUE
    assert bytes(ffi.buffer(setpoint)) == bytes(ffi.buffer(garbage()))


@given(*[st.integers(0, 65535)] * 4, st.lists(st.integers(0, 65535), max_size=10))
def test_any_sticks_make_a_finite_setpoint(roll, pitch, yaw, thrust, aux) -> None:
    cppm = ffi.new("cf_cppm_t *")
    lib.cf_cppm_init(cppm)
    sticks = {"roll": roll, "pitch": pitch, "yaw": yaw, "thrust": thrust, "n_aux": len(aux), "aux": aux}
    setpoint = fly(cppm, sticks)
    assert lib.cf_setpoint_is_finite(setpoint)
    assert setpoint.attitudeRate.yaw == pytest.approx(-(yaw - 1500) / 500 * 400, rel=1e-6)
    assert setpoint.thrust >= 0.0


def test_parameters_have_name_type_flags_and_default(cppm) -> None:
    table = lib.cf_cppm_parameters()
    found = []
    for row in table.rows[0 : table.count]:
        assert (ffi.string(row.group), row.type, row.flags) == (b"cppm", lib.CF_TYPE_FLOAT, lib.CF_PERSISTENT)
        found.append((ffi.string(row.name).decode(), ffi.cast("float *", cppm)[row.offset // 4]))
    assert found == [("rateRoll", 720), ("ratePitch", 720), ("angPitch", 50), ("angRoll", 50), ("rateYaw", 400)]
