"""Poses that come now and then become a motion without jumps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.flight.smooth_path import SmoothPath


def pose(x, vx=0.0):
    return Pose(np.array([x, 0.0, 1.0]), np.array([0.0, 0.0, 0.0, 1.0]), np.array([vx, 0.0, 0.0]), np.zeros(3))


def test_it_goes_on_with_the_last_velocity_and_comes_to_rest():
    path = SmoothPath(longest=0.2)
    path.see(pose(0.0, 2.0), 10.0)
    assert path.at(10.1).position[0] == pytest.approx(0.2)
    assert path.at(10.1).velocity[0] == pytest.approx(2.0)
    assert path.at(11.0).position[0] == pytest.approx(0.4)
    assert not path.at(11.0).velocity.any()


@given(times=st.lists(st.floats(0.005, 0.15), min_size=3, max_size=20), seed=st.integers(0, 1000))
def test_the_motion_never_jumps(times, seed):
    dice, path, now = np.random.default_rng(seed), SmoothPath(), 0.0
    path.see(pose(0.0, 1.0), now)
    for gap in times:
        now += gap
        before = path.at(now)
        path.see(pose(now + dice.uniform(-0.05, 0.05), 1.0), now)
        after = path.at(now)
        assert after.position == pytest.approx(before.position, abs=1e-12)
        # its slope is the velocity that it tells
        later = path.at(now + 1e-6)
        assert (later.position - after.position) / 1e-6 == pytest.approx(after.velocity, abs=1e-3)
    # and what a pose said otherwise is made up for
    assert path.at(now + 0.19).position[0] == pytest.approx(now + 0.19, abs=0.06)


def test_what_is_far_away_is_gone_to_at_once():
    path = SmoothPath(largest_jump=0.5)
    path.see(pose(0.0), 0.0)
    path.see(pose(3.0), 1.0)
    assert path.at(1.0).position[0] == 3.0


def test_attitude_turns_the_short_way():
    path, half = SmoothPath(time_constant=0.05), np.sqrt(0.5)
    path.see(pose(0.0), 0.0)
    turned = pose(0.0)
    turned.orientation = -np.array([0.0, 0.0, half, half])  # a quarter, by the other quaternion of the same attitude
    path.see(turned, 1.0)
    assert abs(path.at(1.0).orientation @ [0.0, 0.0, 0.0, 1.0]) == pytest.approx(1.0)
    assert abs(path.at(1.05).orientation @ [0.0, 0.0, 0.0, 1.0]) > half
    assert abs(path.at(2.0).orientation @ [0.0, 0.0, half, half]) == pytest.approx(1.0)
