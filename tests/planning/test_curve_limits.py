"""What curves ask of a drone."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.attitude import rotation
from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.planning import Limits, Polynomial, State, check_limits, cubic_spline, point_to_point
from crazychoir_fw.planning.limits import GRAVITY, fit_duration

TIGHT = {
    "speed": 0.2,
    "acceleration": 0.2,
    "jerk": 0.5,
    "thrust": 0.29,
    "least_thrust": 0.28,
    "tilt": 0.03,
    "body_rate": 0.05,
}


def go_to(*goal, duration=2.0):
    return point_to_point(State(np.zeros(3)), State(np.array(goal, dtype=float)), duration)


def test_peaks_of_a_rest_to_rest_move():
    report = check_limits(go_to(1.0, 0.0, 0.0), Limits(speed=1.0, acceleration=10.0))
    speed, acceleration = report.loads
    assert speed.peak == pytest.approx(2.1875 / 2.0, rel=1e-6)
    assert speed.time == pytest.approx(1.0, abs=1e-3)
    # 84 sqrt(5) / 25 h / T^2
    assert acceleration.peak == pytest.approx(84 * math.sqrt(5) / 25 / 4, rel=1e-5)
    assert not report.holds
    assert report.binding == speed
    assert "speed: 1.09 of 1 (109%) at 1.00 s" in str(report)


def test_thrust_tilt_and_body_rates_follow_from_the_curve():
    # in a circle of radius r at rate w, the drone leans in by atan(w^2 r / g), and its lean turns once a round
    r, w = 0.5, 3.0
    k = np.arange(24)
    signs = np.where(k % 4 < 2, 1.0, -1.0)
    series = r * signs * w**k / np.array([math.factorial(n) for n in k])
    circle = Polynomial([1.0], [[series * (k % 2 == 0), series * (k % 2 == 1), np.eye(24)[0]]])
    mass, lean = 0.03, math.atan2(w * w * r, GRAVITY)
    limits = Limits(thrust=9.0, least_thrust=0.01, tilt=9.0, body_rate=9.0, mass=mass)
    peaks = {load.name: load.peak for load in check_limits(circle, limits).loads}
    assert peaks["tilt"] == pytest.approx(lean, rel=1e-4)
    assert peaks["thrust"] == pytest.approx(mass * GRAVITY / math.cos(lean), rel=1e-4)
    assert peaks["least_thrust"] == pytest.approx(mass * GRAVITY / math.cos(lean), rel=1e-4)
    # the direction of thrust runs around a cone: sin(lean) times the rate
    assert peaks["body_rate"] == pytest.approx(w * math.sin(lean), rel=1e-3)


@pytest.mark.parametrize(("name", "limit"), TIGHT.items())
def test_time_is_stretched_until_every_kind_of_limit_holds_and_binds(name, limit):
    curve = go_to(1.0, 0.5, -0.7, duration=1.0)
    limits = Limits(**{name: limit}, mass=0.029)
    assert not check_limits(curve, limits).holds
    slow, factor, report = fit_duration(curve.stretched, limits)
    assert slow.duration == pytest.approx(factor * curve.duration)
    assert report.holds
    assert report.binding.name == name
    assert check_limits(curve.stretched(factor * 0.99), limits).holds is False


@settings(max_examples=30)
@given(st.integers(2, 6), st.integers(0, 1000), st.floats(0.2, 3.0), st.floats(0.2, 5.0))
def test_limits_hold_everywhere_on_the_stretched_curve(count, seed, speed, acceleration):
    rng = np.random.default_rng(seed)
    curve = cubic_spline(np.cumsum(rng.uniform(0.2, 1.0, count)), rng.uniform(-2, 2, (count, 3)))
    slow, factor, report = fit_duration(curve.stretched, Limits(speed=speed, acceleration=acceleration))
    assert factor >= 1.0
    assert report.holds
    times = np.linspace(0, slow.duration, 2001)
    assert np.linalg.norm(slow.velocity(times), axis=1).max() <= speed * 1.001
    assert np.linalg.norm(slow.acceleration(times), axis=1).max() <= acceleration * 1.001


def test_a_gentle_curve_is_left_alone_unless_it_may_shrink():
    curve = go_to(0.1, 0.0, 0.0, duration=10.0)
    limits = Limits(speed=1.0)
    assert fit_duration(curve.stretched, limits)[1] == 1.0
    _, factor, report = fit_duration(curve.stretched, limits, may_shrink=True)
    assert factor == pytest.approx(0.021875, rel=1e-3)
    assert report.holds


@pytest.mark.parametrize(("platform", "thrust"), [("cf2", 0.8 * 0.48), ("cf21bl", 0.8 * 0.8)])
def test_limits_of_platforms_come_from_the_vehicle_tables(platform, thrust):
    limits = Limits.of_platform(platform)
    assert limits.thrust == pytest.approx(thrust, rel=1e-6)
    assert limits.least_thrust < limits.mass * GRAVITY < limits.thrust
    assert Limits.of_platform(platform, mass=limits.mass + 0.005).mass == pytest.approx(limits.mass + 0.005)


def test_tilt_is_the_angle_of_the_body_axis():
    lean = 0.2
    push = rotation(np.array([0.0, lean, 0.0])) @ [0.0, 0.0, 1.0] * GRAVITY / math.cos(lean)
    x, y, z = push - [0.0, 0.0, GRAVITY]
    curve = Polynomial([1.0], [[[0, 0, a / 2] for a in (x, y, z)]])
    assert check_limits(curve, Limits(tilt=1.0)).binding.peak == pytest.approx(lean)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"speed": 0.0}, "speed is 0"),
        ({"jerk": math.nan}, "jerk is nan"),
        ({"thrust": 0.4}, "need the mass"),
        ({"thrust": 0.2, "mass": 0.03}, "to hover"),
        ({"least_thrust": 0.3, "mass": 0.03}, "to hover"),
    ],
)
def test_limits_that_nothing_can_keep_are_refused(values, message):
    with pytest.raises(RangeError, match=message):
        Limits(**values)


def test_unknown_platforms_are_refused():
    with pytest.raises(UnknownNameError, match="cf3"):
        Limits.of_platform("cf3")
