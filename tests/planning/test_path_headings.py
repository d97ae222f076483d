"""Noses along paths."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.planning import PathHeading, minimum_snap


@settings(max_examples=30)
@given(st.integers(0, 200), st.floats(-3.0, 3.0), st.floats(0.5, 4.0))
def test_yaw_is_continuous_and_turns_no_faster_than_allowed(seed, yaw, max_rate):
    points = np.random.default_rng(seed).uniform(-1, 1, (5, 3))
    curve = minimum_snap([0, 1, 2, 3, 5], points)
    heading = PathHeading(curve, yaw, max_rate)
    assert heading.at(0.0)[0] == pytest.approx(yaw)
    times = np.linspace(0.0, 5.0, 1237)
    yaws = np.array([heading.at(time)[0] for time in times])
    rates = np.array([heading.at(time)[1] for time in times])
    assert np.abs(np.diff(yaws)).max() <= max_rate * np.diff(times).max() * (1 + 1e-6)
    assert np.abs(rates).max() <= max_rate * (1 + 1e-6)


def test_full_turns_add_up():
    angles = np.linspace(0, 4 * np.pi, 17)
    circles = np.stack([np.cos(angles), np.sin(angles), 1 + 0 * angles], axis=1)
    heading = PathHeading(minimum_snap(3 * angles, circles), np.pi / 2)
    assert heading.at(3 * 4 * np.pi)[0] == pytest.approx(np.pi / 2 + 4 * np.pi, abs=0.5)


def test_straight_up_keeps_the_nose():
    heading = PathHeading(minimum_snap([0, 2], [[0, 0, 0], [0, 0, 1]]), 0.4)
    for time in (-1.0, 0.0, 1.0, 2.0, 3.0):
        assert heading.at(time) == pytest.approx((0.4, 0.0))


def test_the_nose_takes_the_short_way():
    heading = PathHeading(minimum_snap([0, 10], [[0, 0, 0], [-3, -0.01, 0]]), 3.1)
    assert heading.at(5.0)[0] == pytest.approx(2 * np.pi - np.pi + 0.01 / 3, abs=0.01)
