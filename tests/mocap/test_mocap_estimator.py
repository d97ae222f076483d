"""Velocities from the poses of motion capture: numbers of docs/reference/crazychoir.md#10 and #23."""

import cmath
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.attitude import quaternion_xyzw
from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.mocap import Estimator

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
NOWHERE = np.full(3, np.nan)


def sample(time, position=(0.0, 0.0, 0.0), orientation=LEVEL):
    return Pose(np.array(position, float), np.array(orientation, float), time=time)


def yawed(angle):
    return quaternion_xyzw(np.array([0.0, 0.0, angle]))


@pytest.mark.parametrize("legacy", [False, True])
def test_a_ramp_gives_the_numbers_of_the_original(legacy):
    estimator = Estimator(legacy=legacy)
    speeds = [estimator.update(sample(0.01 * k, (0.01 * k, 0.0, 0.0))).velocity[0] for k in range(60)]
    np.testing.assert_allclose(speeds[:6], [0.0, 0.4, 0.64, 0.784, 0.8704, 0.92224], atol=1e-12)
    assert speeds[-1] == pytest.approx(1.0, abs=1e-9)


def test_the_history_of_the_original_begins_with_zeros():
    estimator = Estimator(legacy=True)
    speeds = [estimator.update(sample(0.01 * k, (1.0, 0.0, 0.0))).velocity[0] for k in range(4)]
    np.testing.assert_allclose(speeds, [40.0, 24.0, 14.4, 8.64], rtol=1e-12)


def test_ours_begins_where_the_drone_is():
    estimator = Estimator()
    for k in range(4):
        np.testing.assert_array_equal(estimator.update(sample(0.01 * k, (1.0, 2.0, 3.0))).velocity, 0.0)


@pytest.mark.parametrize("legacy", [False, True])
@pytest.mark.parametrize(
    ("frequency", "gain", "phase"),
    [
        (0.5, 0.998, -3.6),
        (1, 0.993, -7.2),
        (2, 0.971, -14.1),
        (5, 0.852, -32.4),
        (10, 0.631, -52.4),
        (20, 0.376, -71.0),
    ],
)
def test_frequency_response_against_an_ideal_derivative(legacy, frequency, gain, phase):
    estimator, omega, amplitude = Estimator(legacy=legacy), 2.0 * math.pi * frequency, 0.01
    times = 0.01 * np.arange(400)
    positions = amplitude * np.sin(omega * times)
    speeds = [estimator.update(sample(t, (x, 0.0, 0.0))).velocity[0] for t, x in zip(times, positions, strict=True)]
    # over whole periods, behind the transient: the ideal derivative is amplitude omega cos(omega t)
    late = slice(200, 400)
    response = 2.0 / 200 * np.sum(np.array(speeds)[late] * np.exp(-1j * omega * times[late])) / (amplitude * omega)
    assert abs(response) == pytest.approx(gain, abs=6e-4)
    assert math.degrees(cmath.phase(response)) == pytest.approx(phase, abs=0.06)


@settings(max_examples=30)
@given(st.lists(st.floats(0.001, 0.06), min_size=40, max_size=40), st.floats(-3.0, 3.0))
def test_whatever_the_steps_are_a_ramp_is_found(steps, speed):
    estimator, time = Estimator(), 0.0
    for step in steps:
        time += step
        estimate = estimator.update(sample(time, (speed * time, 0.0, 0.0)))
    # the rest of a first-order step response over the time that passed
    rest = math.exp(-(time - steps[0]) / 0.019576)
    assert estimate.velocity[0] == pytest.approx(speed * (1.0 - rest), abs=1e-4 + 1e-3 * abs(speed) * rest)


def test_a_missing_sample_changes_nothing_for_a_ramp():
    def fly(missing):
        estimator = Estimator()
        for k in range(30):
            if k not in missing:
                estimate = estimator.update(sample(0.01 * k, (0.02 * k, 0.0, 0.0)))
        return estimate.velocity

    np.testing.assert_allclose(fly({7, 8, 15}), fly(set()), atol=1e-12)


def test_body_rates_are_those_of_a_tilted_spinning_drone():
    """A drone that is tilted and turns about its own z axis: Euler rates would say something else."""
    tilt, rate = quaternion_xyzw(np.array([0.6, 0.0, 0.0])), 2.0
    body, euler = Estimator(), Estimator(rates="euler")
    for k in range(100):
        half = 0.5 * rate * 0.01 * k
        spin = np.array([0.0, 0.0, math.sin(half), math.cos(half)])
        # tilt * spin
        v = tilt[3] * spin[:3] + spin[3] * tilt[:3] + np.cross(tilt[:3], spin[:3])
        attitude = np.array([*v, tilt[3] * spin[3] - tilt[:3] @ spin[:3]])
        turned = body.update(sample(0.01 * k, orientation=attitude)).angular
        angles = euler.update(sample(0.01 * k, orientation=attitude)).angular
    np.testing.assert_allclose(turned, [0.0, 0.0, rate], atol=1e-6)
    assert np.linalg.norm(angles - turned) > 0.2


@pytest.mark.parametrize("rates", ["body", "euler"])
def test_turning_past_half_a_turn_makes_no_spike(rates):
    estimator = Estimator(rates=rates)
    seen = [estimator.update(sample(0.01 * k, orientation=yawed(3.0 + 0.01 * k))).angular[2] for k in range(60)]
    np.testing.assert_allclose(seen[40:], 1.0, atol=1e-6)
    assert max(seen) < 1.0 + 1e-9


def test_the_original_has_a_spike_there():
    estimator = Estimator(legacy=True)
    for k in range(60):
        angle = 3.0 + 0.01 * k
        estimate = estimator.update(sample(0.01 * k, orientation=yawed(angle)))
        if angle > math.pi:
            break
    assert estimate.angular[2] < -200.0


def test_the_other_sign_of_a_quaternion_is_the_same_attitude():
    estimator = Estimator()
    for k in range(20):
        q = yawed(0.02 * k)
        estimate = estimator.update(sample(0.01 * k, orientation=-q if k % 2 else q))
    assert estimate.angular[2] == pytest.approx(2.0, rel=1e-3)


@pytest.mark.parametrize(
    "lost",
    [
        {"position": np.zeros(3), "orientation": np.zeros(4)},
        {"position": NOWHERE, "orientation": LEVEL},
        {"position": np.zeros(3), "orientation": np.full(4, np.nan)},
        {"position": np.zeros(3), "orientation": np.array([0.0, 0.0, 0.0, 0.79])},
        {"position": np.zeros(3), "orientation": np.array([0.0, 0.0, 0.0, 1.3])},
        {"position": np.array([0.6, 0.0, 0.0]), "orientation": LEVEL},  # a jump of 0.4 m in 10 ms
        {"position": np.array([0.2, 0.0, 0.0]), "orientation": yawed(math.pi / 2)},
    ],
)
def test_a_lost_sample_leaves_the_last_estimate(lost):
    estimator = Estimator()
    for k in range(20):
        before = estimator.update(sample(0.01 * k, (0.01 * k, 0.0, 0.0)))
    after = estimator.update(Pose(**lost, time=0.2))
    assert after.time == before.time == pytest.approx(0.19)
    np.testing.assert_array_equal(after.position, before.position)
    np.testing.assert_array_equal(after.velocity, before.velocity)
    # the next good one goes on as if nothing had been
    assert estimator.update(sample(0.21, (0.21, 0.0, 0.0))).velocity[0] == pytest.approx(1.0, abs=1e-3)
    assert not estimator.is_lost


@pytest.mark.parametrize("time", [0.19, 0.18])
def test_a_stamp_that_is_not_newer_is_stale(time):
    estimator = Estimator()
    for k in range(20):
        before = estimator.update(sample(0.01 * k, (0.01 * k, 0.0, 0.0)))
    after = estimator.update(sample(time, (5.0, 0.0, 0.0)))
    np.testing.assert_array_equal(after.position, before.position)
    assert after.time == before.time


def test_who_is_lost_for_long_is_said_and_then_begins_anew():
    estimator = Estimator(lost_after=0.1)
    assert estimator.is_lost
    estimator.update(sample(0.0))
    estimator.update(sample(0.01, (0.01, 0.0, 0.0)))
    for k in range(2, 30):
        estimator.update(sample(0.01 * k, NOWHERE, np.zeros(4)))
        assert estimator.is_lost == (k > 11)
    estimate = estimator.update(sample(0.3, (4.0, 1.0, 0.0), yawed(2.0)))
    assert not estimator.is_lost
    np.testing.assert_array_equal(estimate.position, [4.0, 1.0, 0.0])
    np.testing.assert_array_equal([estimate.velocity, estimate.angular], 0.0)
    assert estimator.is_lost_at(0.5), "also when nothing comes any more"


def test_simulated_time_may_begin_anew():
    estimator = Estimator()
    for k in range(5):
        estimator.update(sample(100.0 + 0.01 * k, (3.0, 0.0, 0.0)))
    estimate = estimator.update(sample(0.0, (1.0, 0.0, 0.0)))
    assert estimate.time == 0.0
    np.testing.assert_array_equal(estimate.position, [1.0, 0.0, 0.0])


def test_several_drones_are_as_each_alone():
    dice = np.random.default_rng(3)
    together, alone = Estimator(), [Estimator() for _ in range(3)]
    for k in range(50):
        positions = 0.02 * k * np.eye(3) + 0.001 * dice.standard_normal((3, 3))
        attitudes = np.array([yawed(0.02 * k), yawed(-0.05 * k), LEVEL])
        if k in (10, 11, 30):
            positions[1], attitudes[1] = np.nan, np.nan
        swarm = together.update(Pose(positions, attitudes, time=0.01 * k))
        for i, estimator in enumerate(alone):
            estimate = estimator.update(Pose(positions[i], attitudes[i], time=0.01 * k))
            np.testing.assert_array_equal(swarm.position[i], estimate.position)
            np.testing.assert_allclose(swarm.velocity[i], estimate.velocity, atol=1e-14)
            np.testing.assert_allclose(swarm.angular[i], estimate.angular, atol=1e-14)


def test_a_drone_that_was_never_seen_is_not_known():
    estimator = Estimator()
    assert estimator.update(sample(0.0, NOWHERE, np.zeros(4))).position is None
    both = Estimator()
    estimate = both.update(Pose(np.array([[1.0, 0, 0], [np.nan] * 3]), np.array([LEVEL, LEVEL]), time=0.0))
    assert np.isnan(estimate.position[1]).all() and np.isnan(estimate.velocity[1]).all()
    assert list(both.is_lost) == [False, True]


def test_as_the_callback_of_a_node_it_fills_the_pose_in_place():
    estimator, pose = Estimator(), Pose()
    estimator.set_pose(pose)
    for k in range(6):
        pose.position, pose.orientation, pose.time = np.array([0.01 * k, 0.0, 0.0]), LEVEL, 0.01 * k
        estimator()
    assert pose.velocity[0] == pytest.approx(0.92224)
    pose.position, pose.orientation, pose.time = np.zeros(3), np.zeros(4), 0.06
    estimator()
    assert pose.position[0] == pytest.approx(0.05) and pose.time == pytest.approx(0.05)


def test_what_cannot_be_filtered_is_refused():
    with pytest.raises(RangeError, match="no pose"):
        Estimator()()
    with pytest.raises(RangeError, match="time of the sample is None"):
        Estimator().update(sample(None))
    with pytest.raises(RangeError, match=r"\(4,\) and \(4,\)"):
        Estimator().update(sample(0.0, (1, 2, 3, 4)))
    estimator = Estimator()
    estimator.update(sample(0.0))
    with pytest.raises(RangeError, match="that of the first sample"):
        estimator.update(Pose(np.zeros((2, 3)), np.zeros((2, 4)), time=0.1))
    with pytest.raises(RangeError, match="max_speed is nan"):
        Estimator(max_speed=math.nan)
    with pytest.raises(UnknownNameError, match="body, euler"):
        Estimator(rates="quaternion")
