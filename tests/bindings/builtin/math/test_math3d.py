import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import lib

angles = st.floats(-1000.0, 1000.0, width=32)


# docs/reference/planner-commander.md#17.1
@pytest.mark.parametrize(
    ("angle", "expected"),
    [
        (-100.0, 0.530965),
        (-5.0, 1.283185),
        (0.0, 0.0),
        (math.pi + 0.1, -3.041593),
        (-math.pi - 0.1, 3.041593),
        (100.0, -0.530965),
    ],
)
def test_normalized_angle_matches_upstream_test(angle: float, expected: float) -> None:
    assert lib.normalize_radians(angle) == pytest.approx(expected, rel=1e-5)


# docs/reference/planner-commander.md#3: pi is added and taken away again in float32, and plans start there
@pytest.mark.parametrize(("angle", "expected"), [(0.2, 0.200000048), (0.3, 0.299999952), (1.0, 1.00000024)])
def test_normalized_small_angle_is_rounded_like_the_firmware(angle: float, expected: float) -> None:
    assert lib.normalize_radians(angle) == np.float32(expected)


@pytest.mark.parametrize(
    ("start", "goal", "expected"),
    [
        (-math.pi / 2, math.pi, -1.570796),
        (math.pi / 2, math.pi, 1.570796),
        (math.pi, -math.pi / 3, 2.094395),
    ],
)
def test_shortest_turn_matches_upstream_test(start: float, goal: float, expected: float) -> None:
    assert lib.shortest_signed_angle_radians(start, goal) == pytest.approx(expected, rel=1e-5)


@given(angles)
def test_normalized_angle_points_the_same_way(angle: float) -> None:
    normalized = lib.normalize_radians(angle)
    assert abs(normalized) <= np.float32(np.pi)
    # the wrap itself is exact, but each turn subtracts a 2 pi that is 1.7e-7 too large
    assert math.remainder(normalized - angle, 2 * math.pi) == pytest.approx(0.0, abs=1e-4)


@given(angles, angles)
def test_shortest_turn_leads_from_start_to_goal(start: float, goal: float) -> None:
    turn = lib.shortest_signed_angle_radians(start, goal)
    assert abs(turn) <= math.pi + 3e-4
    assert math.remainder(start + turn - goal, 2 * math.pi) == pytest.approx(0.0, abs=5e-4)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_angle_that_is_no_number_stays_none(value: float) -> None:
    assert math.isnan(lib.normalize_radians(value))
    assert math.isnan(lib.shortest_signed_angle_radians(0.0, value))
