"""Attitude and rate loops (docs/reference/control-pid.md#9 and #17)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

F = np.float32
LOOPS = ("roll_rate", "pitch_rate", "yaw_rate", "roll", "pitch", "yaw")

PARAMETERS = [
    *[
        (f"pid_attitude.{axis}_{gain}", lib.CF_TYPE_FLOAT)
        for axis in ("roll", "pitch", "yaw")
        for gain in ("kp", "ki", "kd", "kff")
    ],
    ("pid_attitude.yawMaxDelta", lib.CF_TYPE_FLOAT),
    ("pid_attitude.attFiltEn", lib.CF_TYPE_INT8),
    ("pid_attitude.attFiltCut", lib.CF_TYPE_FLOAT),
    *[
        (f"pid_rate.{axis}_{gain}", lib.CF_TYPE_FLOAT)
        for axis in ("roll", "pitch", "yaw")
        for gain in ("kp", "ki", "kd", "kff")
    ],
    ("pid_rate.rateFiltEn", lib.CF_TYPE_INT8),
    ("pid_rate.omxFiltCut", lib.CF_TYPE_FLOAT),
    ("pid_rate.omyFiltCut", lib.CF_TYPE_FLOAT),
    ("pid_rate.omzFiltCut", lib.CF_TYPE_FLOAT),
]
LOGS = [
    f"{group}.{axis}_out{term}"
    for group in ("pid_attitude", "pid_rate")
    for axis in ("roll", "pitch", "yaw")
    for term in ("P", "I", "D", "FF")
]


@pytest.fixture
def attitude():
    controller = ffi.new("cf_attitude_controller_t *")
    lib.cf_attitude_controller_init(controller, lib.cf_platform_defaults(lib.CF_PLATFORM_CF2))
    return controller


def angles(roll=0.0, pitch=0.0, yaw=0.0):
    return ffi.new("attitude_t *", {"roll": roll, "pitch": pitch, "yaw": yaw})


def correct_attitude(controller, measured, desired):
    rates = ffi.new("attitude_t *")
    lib.cf_attitude_controller_correct_attitude(controller, measured, desired, rates)
    return (rates.roll, rates.pitch, rates.yaw)


def correct_rate(controller, measured, desired):
    lib.cf_attitude_controller_correct_rate(controller, measured, desired)
    return (controller.roll_output, controller.pitch_output, controller.yaw_output)


def rows(table):
    return [table.rows[i] for i in range(table.count)]


def full_name(row):
    return f"{ffi.string(row.group).decode()}.{ffi.string(row.name).decode()}"


def at(struct, row, ctype):
    return ffi.cast(f"{ctype} *", ffi.cast("char *", struct) + row.offset)


def test_boot_sets_gains_limits_and_period(attitude):
    limits = {loop: getattr(attitude, loop).iLimit for loop in LOOPS}
    assert limits == dict(zip(LOOPS, map(F, (33.3, 33.3, 166.7, 20, 20, 360)), strict=True))
    assert {getattr(attitude, loop).dt for loop in LOOPS} == {F(0.002)}
    assert {getattr(attitude, loop).outputLimit for loop in LOOPS} == {0.0}
    assert {getattr(attitude, loop).enableDFilter for loop in LOOPS} == {False}
    assert (attitude.yaw.kp, attitude.yaw.ki, attitude.yaw.kd) == (6.0, 1.0, F(0.35))


def test_boot_overwrites_everything():
    fresh, used = (ffi.new("cf_attitude_controller_t *") for _ in range(2))
    ffi.memmove(used, b"\xa5" * ffi.sizeof(used[0]), ffi.sizeof(used[0]))
    for controller in (fresh, used):
        lib.cf_attitude_controller_init(controller, lib.cf_platform_defaults(lib.CF_PLATFORM_CF21BL))
    for loop in LOOPS:
        ours, theirs = getattr(fresh, loop), getattr(used, loop)
        for name in ("desired", "error", "integ", "deriv", "prevMeasured", "outP", "outI", "outD", "outFF", "kp"):
            assert getattr(ours, name) == getattr(theirs, name)
    assert (used.roll_output, used.pitch_output, used.yaw_output) == (0, 0, 0)


def test_first_correction_is_proportional_plus_one_step_of_integral(attitude):
    rates = correct_attitude(attitude, angles(), angles(roll=5.0, pitch=-3.0, yaw=10.0))
    assert rates == pytest.approx((6 * 5 + 3 * 5 * 0.002, -6 * 3 - 3 * 3 * 0.002, 6 * 10 + 10 * 0.002), rel=1e-6)


def test_only_the_yaw_angle_wraps(attitude):
    roll, _, yaw = correct_attitude(attitude, angles(roll=-170, yaw=-170), angles(roll=170, yaw=170))
    assert roll > 2000
    assert yaw == pytest.approx(6 * -20 + 0.35 * 170 / 0.002 - 20 * 0.002, rel=1e-6)


@pytest.mark.parametrize(("error", "output"), [(1e6, 32767), (-1e6, -32767)])
def test_rate_outputs_saturate_symmetrically(attitude, error, output):
    assert correct_rate(attitude, angles(), angles(error, error, error)) == (output, output, output)


@given(rate=st.floats(-200, 200, width=32))
def test_rate_outputs_are_cut_toward_zero(rate):
    controller = ffi.new("cf_attitude_controller_t *")
    lib.cf_attitude_controller_init(controller, lib.cf_platform_defaults(lib.CF_PLATFORM_CF2))
    roll, _, yaw = correct_rate(controller, angles(), angles(roll=rate, yaw=rate))
    exact = [F(kp) * F(rate) + F(ki) * (F(rate) * F(0.002)) for kp, ki in ((250, 500), (120, 16.7))]
    assert (roll, yaw) == tuple(int(np.clip(value, F(-32767), F(32767))) for value in exact)


@pytest.mark.parametrize("axis", ["roll", "pitch", "yaw"])
def test_rate_output_that_is_not_a_number_is_zero_and_told(attitude, axis):
    bad = angles(**{axis: float("nan")})
    assert not lib.cf_attitude_controller_correct_rate(attitude, angles(), bad)
    assert getattr(attitude, f"{axis}_output") == 0


def test_rate_output_without_bounds_saturates_and_is_a_number(attitude):
    huge = angles(3e38, -3e38, 3e38)
    assert lib.cf_attitude_controller_correct_rate(attitude, angles(), huge)
    assert (attitude.roll_output, attitude.pitch_output, attitude.yaw_output) == (32767, -32767, 32767)


def test_reset_takes_the_present_angles_but_zero_rates(attitude):
    correct_attitude(attitude, angles(1, 2, 3), angles(9, 9, 9))
    correct_rate(attitude, angles(4, 5, 6), angles(9, 9, 9))
    lib.cf_attitude_controller_reset(attitude, angles(10, 20, 30))
    assert [getattr(attitude, loop).prevMeasured for loop in LOOPS] == [0, 0, 0, 10, 20, 30]
    assert [getattr(attitude, loop).integ for loop in LOOPS] == [0] * 6


def test_roll_and_pitch_can_be_reset_alone(attitude):
    correct_attitude(attitude, angles(), angles(9, 9, 9))
    lib.cf_attitude_controller_reset_roll(attitude, 1.5)
    assert (attitude.roll.prevMeasured, attitude.roll.integ) == (1.5, 0.0)
    assert attitude.pitch.integ != 0.0
    lib.cf_attitude_controller_reset_pitch(attitude, 2.5)
    assert (attitude.pitch.prevMeasured, attitude.pitch.integ) == (2.5, 0.0)


def test_parameter_table_lists_names_and_types_in_order():
    table = rows(lib.cf_attitude_controller_parameters())
    assert [(full_name(row), row.type) for row in table] == PARAMETERS
    assert {row.flags for row in table} == {lib.CF_PERSISTENT}


def test_log_table_lists_names_in_order():
    table = rows(lib.cf_attitude_controller_logs())
    assert [full_name(row) for row in table] == LOGS
    assert {row.type for row in table} == {lib.CF_TYPE_FLOAT}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("pid_attitude.pitch_ki", 3.0),
        ("pid_attitude.yaw_kd", F(0.35)),
        ("pid_attitude.attFiltCut", 15.0),
        ("pid_rate.roll_kp", 250.0),
        ("pid_rate.yaw_ki", F(16.7)),
        ("pid_rate.omzFiltCut", 30.0),
    ],
)
def test_parameters_read_their_defaults(attitude, name, value):
    row = next(row for row in rows(lib.cf_attitude_controller_parameters()) if full_name(row) == name)
    assert at(attitude, row, "float")[0] == value


def test_a_written_gain_acts_at_once(attitude):
    row = next(row for row in rows(lib.cf_attitude_controller_parameters()) if full_name(row) == "pid_rate.roll_kp")
    at(attitude, row, "float")[0] = 100.0
    assert correct_rate(attitude, angles(), angles(roll=10.0))[0] == 1010


def test_a_written_filter_setting_does_not_act_after_boot(attitude):
    row = next(row for row in rows(lib.cf_attitude_controller_parameters()) if full_name(row) == "pid_rate.rateFiltEn")
    at(attitude, row, "int8_t")[0] = 1
    lib.cf_attitude_controller_reset(attitude, angles())
    assert not attitude.roll_rate.enableDFilter


def test_logs_read_the_terms(attitude):
    correct_attitude(attitude, angles(), angles(roll=5.0))
    row = next(row for row in rows(lib.cf_attitude_controller_logs()) if full_name(row) == "pid_attitude.roll_outP")
    assert at(attitude, row, "float")[0] == 30.0
