"""Spirals against derived numbers and against circles (docs/reference/planner-commander.md#6.5 and #17.2)."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib

SPIRALS = np.loadtxt(Path(__file__).parent / "data" / "spirals.csv", delimiter=",")


class Spiral:
    """A planner that flies one spiral from t = 0."""

    def __init__(self, angle, r0, rF, ascent, duration, sideways=False, clockwise=False, pos=(0, 0, 0), yaw=0.0):
        self.planner = ffi.new("cf_planner_t *")
        lib.cf_planner_init(self.planner)
        begin = ffi.new("cf_plan_start_t *", [list(pos), [9, 9, 9], yaw])
        wanted = ffi.new("cf_spiral_t *", [sideways, clockwise, angle, r0, rF, ascent, duration])
        assert lib.cf_planner_spiral(self.planner, begin, wanted, 0.0) == 0

    def at(self, t: float):
        return lib.cf_planner_current_goal(self.planner, ffi.NULL, t)


def xyz(v) -> list[float]:
    return [v.x, v.y, v.z]


def as_row(ev) -> list[float]:
    return [*xyz(ev.pos), *xyz(ev.vel), *xyz(ev.acc), *xyz(ev.jerk), ev.yaw, *xyz(ev.omega)]


@pytest.mark.parametrize(
    "row", SPIRALS, ids=lambda r: f"{['forward', 'sideways'][int(r[0])]}-{['ccw', 'cw'][int(r[1])]}-t={r[2]}"
)
def test_spiral_has_the_expected_numbers(row: NDArray[np.float64]) -> None:
    # the order of products in the firmware is not known, and the fit amplifies an ulp
    # (docs/reference/planner-commander.md#17.2)
    spiral = Spiral(1.5707963, 1.0, 0.5, 0.5, 4.0, bool(row[0]), bool(row[1]), pos=(0.1, 0.2, 1.0), yaw=0.3)
    expected = row[3:]
    goal = as_row(spiral.at(row[2]))
    np.testing.assert_allclose(goal[:9] + goal[12:], [*expected[:9], *expected[12:]], rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(goal[9:12], expected[9:12], atol=3e-5)


# docs/reference/planner-commander.md#17.2
@pytest.mark.parametrize(
    ("sideways", "clockwise", "center"),
    [
        (False, False, (-0.19552016, 1.1553365)),
        (True, False, (-0.85533649, -0.095520154)),
        (False, True, (0.39552015, -0.75533652)),
        (True, True, (1.0553365, 0.49552017)),
    ],
)
def test_spiral_begins_and_ends_at_its_radii_about_its_center(sideways: bool, clockwise: bool, center) -> None:
    spiral = Spiral(1.5707963, 1.0, 0.5, 0.5, 4.0, sideways, clockwise, pos=(0.1, 0.2, 1.0), yaw=0.3)
    for t, radius in [(0.0, 1.0), (4.0, 0.5)]:
        goal = spiral.at(t)
        assert math.hypot(goal.pos.x - center[0], goal.pos.y - center[1]) == pytest.approx(radius, abs=1e-5)


@given(
    st.booleans(),
    st.booleans(),
    st.floats(-math.pi / 2, math.pi / 2),
    st.floats(0.3, 1.5),
    st.floats(-3.0, 3.0),
    st.floats(0.0, 1.0),
)
def test_spiral_of_one_radius_is_nearly_a_circle(
    sideways: bool, clockwise: bool, angle: float, radius: float, yaw: float, place: float
) -> None:
    """The vehicle faces along the path, or strafes to its left, turning in the sense it is asked for."""
    goal = Spiral(angle, radius, radius, 0.4, 2.0, sideways, clockwise, (1.0, 2.0, 3.0), yaw).at(2.0 * place)
    sense = -1.0 if clockwise else 1.0
    assert math.remainder(goal.yaw - yaw - sense * angle * place, 2 * math.pi) == pytest.approx(0.0, abs=1e-4)
    forward = np.array([math.cos(goal.yaw), math.sin(goal.yaw)])
    left = np.array([-forward[1], forward[0]])
    first = np.array([math.cos(yaw), math.sin(yaw)])
    first_left = np.array([-first[1], first[0]])
    along, outward_now, outward_first = (
        (left, sense * forward, sense * first) if sideways else (forward, -sense * left, -sense * first_left)
    )
    center = np.array([1.0, 2.0]) - radius * outward_first
    np.testing.assert_allclose([goal.pos.x, goal.pos.y], center + radius * outward_now, atol=0.01 * radius)
    speed = radius * angle / 2.0
    np.testing.assert_allclose([goal.vel.x, goal.vel.y], speed * along, atol=0.02 * radius)
    assert goal.pos.z == pytest.approx(3.0 + 0.4 * place, abs=1e-4)


@pytest.mark.parametrize(
    ("asked", "flown"),
    [
        ((10.0, 1.0, 0.5), (2 * math.pi, 1.0, 0.5)),
        ((-10.0, 1.0, 0.5), (-2 * math.pi, 1.0, 0.5)),
        ((1.0, -1.0, 0.5), (1.0, 0.0, 0.5)),
        ((1.0, 1.0, -0.5), (1.0, 1.0, 0.0)),
    ],
)
def test_spiral_is_limited_to_a_full_turn_and_positive_radii(asked, flown) -> None:
    for t in (0.0, 1.0, 3.0, 4.0):
        assert as_row(Spiral(*asked, 0.5, 4.0).at(t)) == as_row(Spiral(*flown, 0.5, 4.0).at(t))


def test_spiral_holds_its_end_point_at_rest() -> None:
    spiral = Spiral(1.0, 1.0, 0.5, 0.5, 2.0)
    end = as_row(spiral.at(2.0))
    held = as_row(spiral.at(50.0))
    assert held[:3] == pytest.approx(end[:3], abs=1e-6)
    assert not any(held[3:12])
    assert lib.cf_planner_state(spiral.planner) == lib.TRAJECTORY_STATE_FLYING
    assert lib.cf_planner_is_finished(spiral.planner, ffi.NULL, 2.0)


@pytest.mark.parametrize("state", [0, 1, 3, 4])
def test_spiral_starts_from_every_state(state: int) -> None:
    spiral = Spiral(1.0, 1.0, 1.0, 0.0, 1.0)
    spiral.planner.state = state
    begin = ffi.new("cf_plan_start_t *", [[1, 2, 3], [0, 0, 0], 0.5])
    wanted = ffi.new("cf_spiral_t *", [False, False, 1.0, 1.0, 1.0, 0.0, 2.0])
    assert lib.cf_planner_spiral(spiral.planner, begin, wanted, 7.0) == 0
    assert lib.cf_planner_state(spiral.planner) == lib.TRAJECTORY_STATE_FLYING
    assert xyz(spiral.at(7.0).pos) == [1.0, 2.0, 3.0]
