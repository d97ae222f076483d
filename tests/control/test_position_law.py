"""Force, thrust and attitude of the flatness laws: numbers of the original, what it could not do, and batches."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from crazychoir_fw.common.attitude import quaternion_xyzw
from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.control import FlatnessAccelerationCtrl, FlatnessPositionCtrl, PositionGains

POSE = Pose(
    np.array([0.1, -0.2, 0.9]),
    quaternion_xyzw(np.array([0.1, -0.2, 0.3])),
    np.array([0.05, 0.1, -0.02]),
    np.array([0.3, -0.4, 0.2]),
)
REFERENCE = Reference(np.array([0.0, 0.0, 1.0]), np.array([0.1, 0.0, 0.0]), np.array([0.2, -0.1, 0.3]), yaw=0.25)
LEVEL = Pose(np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3), np.zeros(3))
MASS, GRAVITY = 0.038, 9.80665


@pytest.mark.parametrize(
    ("vicon", "force", "thrust", "attitude"),
    [
        (
            False,
            (-0.0224, 0.0562, 0.5170527),
            0.4991406701,
            (
                (0.968376438, -0.245755134, -0.043028917),
                (0.249049359, 0.962455098, 0.107956479),
                (0.014882541, -0.115258834, 0.993223998),
            ),
        ),
        (
            True,
            (-0.0584, 0.1282, 0.5420527),
            0.5181833273,
            (
                (0.965234441, -0.239685803, -0.104274588),
                (0.257821835, 0.938685673, 0.228904146),
                (0.043015987, -0.247830431, 0.967847975),
            ),
        ),
    ],
    ids=["webots", "vicon"],
)
def test_numbers_of_the_original(vicon, force, thrust, attitude):
    law = FlatnessPositionCtrl(vicon=vicon)
    found_thrust, found_attitude = law.control(POSE, REFERENCE)
    assert law.force(POSE, REFERENCE) == pytest.approx(force, abs=1e-9)
    assert found_thrust == pytest.approx(thrust, abs=1e-9)
    assert found_attitude == pytest.approx(np.array(attitude), abs=1e-8)
    assert law.desired_rates is None


def test_acceleration_law_has_the_numbers_of_the_original():
    thrust, _ = FlatnessAccelerationCtrl().control(POSE, Reference(acceleration=REFERENCE.acceleration))
    assert thrust == pytest.approx(0.373890184, abs=1e-9)


def test_without_an_acceleration_the_drone_is_to_hover():
    thrust, attitude = FlatnessAccelerationCtrl().control(LEVEL, Reference())
    assert thrust == pytest.approx(MASS * GRAVITY)
    assert np.array_equal(attitude, np.eye(3))


# ---------------------------------------------------------------- rates that the reference asks for


def curve(t):
    """A bent and turning path: acceleration, jerk, yaw and its rate."""
    acceleration = np.array([3.0 * np.sin(1.7 * t), 2.0 * np.cos(1.1 * t), 1.5 * np.sin(0.9 * t + 0.4)])
    jerk = np.array([5.1 * np.cos(1.7 * t), -2.2 * np.sin(1.1 * t), 1.35 * np.cos(0.9 * t + 0.4)])
    return Reference(acceleration=acceleration, jerk=jerk, yaw=0.8 * np.sin(2.0 * t), yaw_rate=1.6 * np.cos(2.0 * t))


@pytest.mark.parametrize("t", np.linspace(0.0, 6.0, 13))
def test_desired_rates_are_those_at_which_the_desired_attitude_turns(t):
    law, h = FlatnessAccelerationCtrl(), 1e-5
    before, after = (law.control(LEVEL, curve(t + dt))[1] for dt in (-h, h))
    _, attitude = law.control(LEVEL, curve(t))
    turn = attitude.T @ (after - before) / (2.0 * h)
    assert law.desired_rates == pytest.approx([turn[2, 1], turn[0, 2], turn[1, 0]], abs=1e-8)


def test_a_turning_heading_needs_no_jerk():
    law = FlatnessPositionCtrl()
    law.control(LEVEL, Reference(position=np.zeros(3), yaw=0.3, yaw_rate=0.7))
    assert law.desired_rates == pytest.approx([0.0, 0.0, 0.7])


def test_rates_of_the_reference_before_are_forgotten():
    law = FlatnessPositionCtrl()
    law.control(LEVEL, curve(1.0))
    law.control(LEVEL, REFERENCE)
    assert law.desired_rates is None


# ---------------------------------------------------------------- where the original had no answer


@pytest.mark.parametrize(
    "acceleration",
    [(0.0, 0.0, -GRAVITY), (0.0, 0.0, -30.0), (5.0, 0.0, -GRAVITY), (1e6, 0.0, 0.0), (-1e6, 1e6, -1e6)],
    ids=["free fall", "downwards", "along the heading", "sideways", "all at once"],
)
@pytest.mark.parametrize("gains", ["webots", "mujoco"])
def test_thrust_axis_always_points_up(acceleration, gains):
    law = FlatnessAccelerationCtrl(gains=gains)
    thrust, attitude = law.control(LEVEL, Reference(acceleration=np.array(acceleration)))
    assert np.all(np.isfinite(attitude))
    assert attitude @ attitude.T == pytest.approx(np.eye(3), abs=1e-9)
    assert attitude[2, 2] > 0.0
    assert thrust >= law.gains.least_lift * MASS * GRAVITY * (1 - 1e-12)


def test_a_drone_on_its_back_gets_no_negative_thrust():
    upside_down = Pose(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3))
    thrust, _ = FlatnessPositionCtrl().control(upside_down, Reference(position=np.zeros(3)))
    assert thrust == 0.0


@pytest.mark.parametrize("shape", [(), (2,)])
def test_a_quaternion_that_nobody_has_written_is_level(shape):
    pose = Pose(np.zeros((*shape, 3)), np.zeros((*shape, 4)), np.zeros((*shape, 3)))
    thrust, _ = FlatnessPositionCtrl().control(pose, Reference(position=np.zeros(3)))
    assert thrust == pytest.approx(np.full(shape, MASS * GRAVITY))


def test_tilt_stays_below_its_limit():
    gains = PositionGains((1.0,) * 3, (0.1,) * 3, max_tilt=0.5)
    _, attitude = FlatnessPositionCtrl(gains=gains).control(LEVEL, Reference(position=np.array([50.0, -20.0, 0.0])))
    assert np.arccos(attitude[2, 2]) == pytest.approx(0.5)
    assert attitude[1, 2] / attitude[0, 2] == pytest.approx(-0.4)


# ---------------------------------------------------------------- parts of the law


def test_integral_counts_real_periods_and_does_not_wind_up():
    gains = PositionGains((0.0,) * 3, (0.0,) * 3, k_i=(1.0, 1.0, 1.0), integral_limit=0.3)
    law = FlatnessPositionCtrl(20.0, gains=gains)
    hover = np.array([0.0, 0.0, MASS * GRAVITY])
    pulled = Reference(position=np.array([0.1, 0.0, -0.2]))
    for count in range(1, 11):
        force = law.force(LEVEL, pulled)
        assert force - hover == pytest.approx(np.array([0.1, 0.0, -0.2]) * count / 20.0)
    for _ in range(200):
        force = law.force(LEVEL, pulled)
    assert force - hover == pytest.approx([0.3, 0.0, -0.3])
    law.reset()
    assert law.force(LEVEL, pulled) - hover == pytest.approx([0.005, 0.0, -0.01])


def test_far_goals_are_no_matter_of_the_integral():
    gains = PositionGains((0.0,) * 3, (0.0,) * 3, k_i=(1.0, 1.0, 1.0), integral_zone=0.2)
    law = FlatnessPositionCtrl(gains=gains)
    force = law.force(LEVEL, Reference(position=np.array([0.3, 0.1, -0.3])))
    assert force - [0.0, 0.0, MASS * GRAVITY] == pytest.approx([0.0, 0.001, 0.0])


def test_far_goals_pull_no_harder_than_near_ones():
    law = FlatnessPositionCtrl(gains=PositionGains((0.4,) * 3, (0.1,) * 3, error_limit=0.5))
    force = law.force(LEVEL, Reference(position=np.array([9.0, -0.2, 0.0])))
    assert force[:2] == pytest.approx([0.2, -0.08])


def test_gains_per_kilogram_fit_every_mass():
    def acceleration(mass):
        law = FlatnessPositionCtrl(gains="mujoco", mass=mass)
        return law.force(POSE, REFERENCE) / mass

    assert acceleration(0.029) == pytest.approx(acceleration(0.06))


def test_drag_is_made_up_for_along_the_reference():
    law = FlatnessPositionCtrl(gains=PositionGains((0.4,) * 3, (0.0,) * 3, drag=(0.01, 0.02, 0.03)))
    force = law.force(LEVEL, Reference(velocity=np.ones(3)))
    assert force - [0.0, 0.0, MASS * GRAVITY] == pytest.approx([0.01, 0.02, 0.03])


def test_what_the_reference_lacks_asks_for_nothing():
    law = FlatnessPositionCtrl()
    moving = Pose(POSE.position, POSE.orientation, np.array([0.5, 0.0, 0.0]))
    assert law.force(moving, Reference()) == pytest.approx([-0.1, 0.0, MASS * GRAVITY])


# ---------------------------------------------------------------- any drone, and many

numbers = st.floats(-20.0, 20.0)
vectors = arrays(float, (6, 3), elements=numbers)
quaternions = arrays(float, (6, 4), elements=st.floats(-1.0, 1.0)).filter(lambda q: (q**2).sum(1).min() > 1e-3)


@pytest.mark.parametrize("gains", ["webots", "mujoco"])
@settings(max_examples=25)
@given(p=vectors, v=vectors, q=quaternions, a=vectors, j=vectors, yaw=arrays(float, 6, elements=numbers))
def test_a_batch_is_as_one_by_one_and_always_a_rotation(gains, p, v, q, a, j, yaw):
    law = FlatnessPositionCtrl(gains=gains, mass=np.linspace(0.02, 0.05, 6))
    reference = Reference(np.zeros(3), a / 10.0, a, j, yaw, yaw / 5.0)
    thrust, attitude = law.control(Pose(p, q, v), reference)
    rates = law.desired_rates
    assert thrust.shape == (6,) and attitude.shape == (6, 3, 3) and rates.shape == (6, 3)
    assert np.all(thrust >= 0.0) and np.all(np.isfinite(rates))
    assert np.swapaxes(attitude, -1, -2) @ attitude == pytest.approx(np.tile(np.eye(3), (6, 1, 1)), abs=1e-9)
    assert np.linalg.det(attitude) == pytest.approx(np.ones(6))
    for i in range(6):
        alone = FlatnessPositionCtrl(gains=gains, mass=law.mass[i])
        its = Reference(np.zeros(3), a[i] / 10.0, a[i], j[i], yaw[i], yaw[i] / 5.0)
        its_thrust, its_attitude = alone.control(Pose(p[i], q[i], v[i]), its)
        assert thrust[i] == pytest.approx(its_thrust, rel=1e-12, abs=1e-12)
        assert attitude[i] == pytest.approx(its_attitude, abs=1e-12)
        assert rates[i] == pytest.approx(alone.desired_rates, rel=1e-10, abs=1e-10)


def test_one_reference_serves_a_group_and_one_pose_many_references():
    law = FlatnessPositionCtrl()
    group = Pose(*(np.tile(part, (4, 1)) for part in (POSE.position, POSE.orientation, POSE.velocity)))
    one = law.control(POSE, REFERENCE)
    for thrust, attitude in (
        law.control(group, REFERENCE),
        law.control(POSE, replace(REFERENCE, position=np.tile(REFERENCE.position, (4, 1)))),
    ):
        assert thrust == pytest.approx(np.full(4, one[0]))
        assert attitude == pytest.approx(np.tile(one[1], (4, 1, 1)))
    thrust, attitude = FlatnessAccelerationCtrl().control(group, Reference())
    assert thrust.shape == (4,) and attitude.shape == (4, 3, 3)


def test_a_grid_of_drones_is_flown_as_a_row():
    law = FlatnessPositionCtrl(gains="mujoco")
    rng = np.random.default_rng(1)
    p, v, q = rng.normal(size=(6, 3)), rng.normal(size=(6, 3)), rng.normal(size=(6, 4))
    row = law.control(Pose(p, q, v), Reference(np.zeros(3)))
    law.reset()
    grid = law.control(Pose(p.reshape(2, 3, 3), q.reshape(2, 3, 4), v.reshape(2, 3, 3)), Reference(np.zeros(3)))
    assert grid[0].ravel() == pytest.approx(row[0])
    assert grid[1].reshape(6, 3, 3) == pytest.approx(row[1])


# ---------------------------------------------------------------- mistakes


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"update_frequency": 0.0}, "update_frequency is 0.0, allowed: above 0 Hz"),
        ({"mass": -1.0}, "mass is -1.0, allowed: above 0 kg"),
        ({"gravity": 0.0}, "gravity is 0.0, allowed: above 0"),
    ],
)
def test_impossible_vehicles_are_refused(arguments, message):
    with pytest.raises(RangeError, match=f"FlatnessPositionCtrl: {message}"):
        FlatnessPositionCtrl(**arguments)


def test_unknown_gain_sets_are_refused():
    with pytest.raises(UnknownNameError, match="gains is 'bitcraze', allowed: webots, vicon, mujoco"):
        FlatnessPositionCtrl(gains="bitcraze")
