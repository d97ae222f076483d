"""The PID block (docs/reference/control-pid.md#6), next to a plain float32 twin of its ten steps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

F = np.float32
GAINS = {"kp": 2.0, "ki": 0.5, "kd": 0.25, "kff": 0.125}
DT = 0.01
values = st.floats(-1e4, 1e4, width=32)
angles = st.floats(-180, 180, width=32)


def make_pid(desired=0.0, kp=2.0, ki=0.5, kd=0.25, kff=0.125, dt=DT, cutoff=20.0, filtered=False):
    pid = ffi.new("PidObject *")
    lib.pidInit(pid, desired, kp, ki, kd, kff, dt, 100.0, cutoff, filtered)
    return pid


def wrapped_once(angle):
    return F(angle - F(360)) if angle > 180 else F(angle + F(360)) if angle < -180 else angle


def expected_outputs(desired, measurements, is_yaw_angle, output_limit=0.0, integral_limit=5000.0):
    """Return the outputs of the unfiltered block, computed in float32 in the order of the reference."""
    previous, integral, outputs = F(0), F(0), []
    kp, ki, kd, kff = (F(GAINS[name]) for name in ("kp", "ki", "kd", "kff"))
    for measured in map(F, measurements):
        error = F(desired) - measured
        delta = -(measured - previous)
        if is_yaw_angle:
            error, delta = wrapped_once(error), wrapped_once(delta)
        integral = np.clip(integral + error * F(DT), F(-integral_limit), F(integral_limit))
        out = kp * error + kd * (delta / F(DT)) + ki * integral + kff * F(desired)
        outputs.append(float(np.clip(out, F(-output_limit), F(output_limit)) if output_limit else out))
        previous = measured
    return outputs


@given(desired=values, measurements=st.lists(values, min_size=1, max_size=8), is_yaw_angle=st.booleans())
def test_updates_equal_a_float32_twin_to_the_last_bit(desired, measurements, is_yaw_angle):
    pid = make_pid(desired)
    outputs = [lib.pidUpdate(pid, measured, is_yaw_angle) for measured in measurements]
    assert outputs == expected_outputs(desired, measurements, is_yaw_angle)


@given(desired=values, measurements=st.lists(values, min_size=1, max_size=5), limit=st.floats(0.5, 100, width=32))
def test_output_limit_bounds_the_sum(desired, measurements, limit):
    pid = make_pid(desired)
    pid.outputLimit = limit
    outputs = [lib.pidUpdate(pid, measured, False) for measured in measurements]
    assert outputs == expected_outputs(desired, measurements, False, output_limit=limit)


def test_init_sets_everything_but_the_logged_terms():
    pid = make_pid(desired=1.0)
    pid.outP = 7.0
    lib.pidUpdate(pid, 0.5, False)
    logged = (pid.outP, pid.outI, pid.outD, pid.outFF)
    lib.pidInit(pid, 3.0, 1.0, 2.0, 4.0, 8.0, 0.002, 500.0, 30.0, True)

    assert (pid.desired, pid.error, pid.prevMeasured, pid.integ, pid.deriv) == (3.0, 0.0, 0.0, 0.0, 0.0)
    assert (pid.kp, pid.ki, pid.kd, pid.kff) == (1.0, 2.0, 4.0, 8.0)
    assert (pid.iLimit, pid.outputLimit, pid.dt) == (5000.0, 0.0, F(0.002))
    assert pid.enableDFilter
    assert pid.dFilter.b0 == pytest.approx(0.027859773, rel=1e-6)
    assert (pid.outP, pid.outI, pid.outD, pid.outFF) == logged


def test_each_term_is_logged_by_itself():
    pid = make_pid(desired=4.0)
    lib.pidUpdate(pid, 1.0, False)
    assert pid.error == 3.0
    assert pid.outP == pytest.approx(6.0)
    assert pid.outI == pytest.approx(0.5 * 0.03)
    assert pid.outD == pytest.approx(0.25 * -100.0)
    assert pid.outFF == pytest.approx(0.5)


def test_reset_leaves_no_derivative_kick_at_the_given_value():
    pid = make_pid(desired=10.0)
    lib.pidUpdate(pid, 2.0, False)
    lib.pidReset(pid, 7.0)
    assert (pid.error, pid.integ, pid.deriv, pid.prevMeasured) == (0.0, 0.0, 0.0, 7.0)
    lib.pidUpdate(pid, 7.0, False)
    assert pid.outD == 0.0


def test_reset_keeps_filter_target_and_logged_terms():
    pid = make_pid(desired=10.0, filtered=True)
    lib.pidUpdate(pid, 2.0, False)
    before = (pid.dFilter.delay_element_1, pid.desired, pid.outP, pid.outD)
    lib.pidReset(pid, 0.0)
    assert (pid.dFilter.delay_element_1, pid.desired, pid.outP, pid.outD) == before
    assert before[0] != 0.0


def test_derivative_follows_the_measurement_not_the_target():
    pid = make_pid(desired=0.0)
    lib.pidUpdate(pid, 0.0, False)
    lib.pidSetDesired(pid, 100.0)
    lib.pidUpdate(pid, 0.0, False)
    assert pid.outD == 0.0


def test_integral_stops_at_its_limit():
    pid = make_pid(desired=100.0)
    lib.pidSetIntegralLimit(pid, 2.5)
    for _ in range(10):
        lib.pidUpdate(pid, 0.0, False)
    assert pid.integ == 2.5
    lib.pidSetDesired(pid, -100.0)
    for _ in range(10):
        lib.pidUpdate(pid, 0.0, False)
    assert pid.integ == -2.5


def test_an_integral_limit_of_zero_means_none():
    pid = make_pid(desired=1e6)
    lib.pidSetIntegralLimit(pid, 0.0)
    for _ in range(3):
        lib.pidUpdate(pid, 0.0, False)
    assert pid.integ == pytest.approx(30000.0)


def test_integral_includes_the_present_error_and_grows_in_saturation():
    pid = make_pid(desired=10.0)
    pid.outputLimit = 1.0
    for step in range(1, 4):
        assert lib.pidUpdate(pid, 0.0, False) == 1.0
        assert pid.integ == pytest.approx(0.1 * step)


@pytest.mark.parametrize(
    ("desired", "measured", "error"),
    [(170, -170, -20), (-170, 170, 20), (180, 0, 180), (-180, 0, -180), (181, 0, -179), (541, 0, 181)],
)
def test_yaw_error_is_wrapped_once_and_strictly(desired, measured, error):
    pid = make_pid(desired)
    lib.pidUpdate(pid, measured, True)
    assert pid.error == error


@given(desired=angles, first=angles, second=angles)
def test_yaw_terms_never_see_more_than_half_a_turn(desired, first, second):
    pid = make_pid(desired)
    lib.pidUpdate(pid, first, True)
    lib.pidUpdate(pid, second, True)
    assert abs(pid.error) <= 180.0
    assert abs(pid.deriv) <= 180.0 / DT * (1 + 1e-6)


def test_a_derivative_that_is_not_a_number_counts_as_zero():
    pid = make_pid(desired=1.0, dt=0.0)
    lib.pidUpdate(pid, 0.0, False)
    assert pid.deriv == 0.0


def test_the_filtered_derivative_is_the_low_pass_of_the_raw_one():
    twin = ffi.new("lpf2pData *")
    lib.lpf2pInit(twin, 100.0, 20.0)
    pid = make_pid(filtered=True)
    previous = F(0)
    for measured in map(F, (0.5, 0.7, 0.4, 0.4)):
        lib.pidUpdate(pid, measured, False)
        assert pid.deriv == lib.lpf2pApply(twin, -(measured - previous) / F(DT))
        previous = measured


def test_filter_reset_clears_and_retunes_the_filter():
    pid = make_pid(filtered=True)
    lib.pidUpdate(pid, 1.0, False)
    lib.filterReset(pid, 100.0, 10.0, True)
    assert (pid.dFilter.delay_element_1, pid.dFilter.delay_element_2) == (0.0, 0.0)
    assert pid.dFilter.b0 == pytest.approx(0.06745528, rel=1e-6)


def test_filter_reset_can_switch_the_filter_off():
    pid = make_pid(filtered=True)
    lib.filterReset(pid, 100.0, 20.0, False)
    lib.pidUpdate(pid, 1.0, False)
    assert pid.deriv == -1.0 / F(DT)


@pytest.mark.parametrize(
    ("kp", "ki", "kd", "active"),
    [(0, 0, 0, False), (0.00009, 0, 0, False), (0.0001, 0, 0, True), (0, 1, 0, True), (0, 0, 1, True)],
)
def test_a_pid_is_active_with_any_gain_of_weight(kp, ki, kd, active):
    assert lib.pidIsActive(make_pid(kp=kp, ki=ki, kd=kd, kff=5.0)) == active


def test_setters_write_their_member():
    pid = make_pid()
    lib.pidSetKp(pid, 1.0)
    lib.pidSetKi(pid, 2.0)
    lib.pidSetKd(pid, 3.0)
    lib.pidSetKff(pid, 4.0)
    lib.pidSetDt(pid, 5.0)
    lib.pidSetDesired(pid, 6.0)
    assert (pid.kp, pid.ki, pid.kd, pid.kff, pid.dt) == (1.0, 2.0, 3.0, 4.0, 5.0)
    assert lib.pidGetDesired(pid) == 6.0
