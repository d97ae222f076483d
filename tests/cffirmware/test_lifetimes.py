"""Memory of C lives as long as Python can reach it (docs/reference/cffirmware-api.md#14, points 5 and 6)."""

import copy
import gc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw import cffirmware


def clutter(firm):
    """Collect garbage, and use memory that was freed."""
    gc.collect(1)
    return [firm.poly4d_malloc(4) for _ in range(50)]


def trajectory_at(firm, *heights):
    """Return a trajectory of pieces that stay at these heights, a second each."""
    trajectory = firm.piecewise_traj()
    trajectory.timescale = 1
    trajectory.n_pieces = len(heights)
    trajectory.pieces = firm.poly4d_malloc(len(heights))
    for i, height in enumerate(heights):
        piece = firm.piecewise_get(trajectory, i)
        piece.duration = 1
        firm.poly4d_set(piece, 2, 0, height)
    return trajectory


def height(firm, trajectory, t):
    return firm.piecewise_eval(trajectory, t).pos.z


def test_view_keeps_the_whole_alive(firm):
    position = firm.setpoint_t().position
    position.x = 1.0
    kept = clutter(firm)
    assert (position.x, position.y) == (1.0, 0.0)
    assert kept


def test_view_of_a_view_keeps_the_whole_alive(firm):
    shift = firm.planner().planned_trajectory.shift
    shift.x = 1.0
    clutter(firm)
    assert list(shift) == [1, 0, 0]


def test_array_keeps_the_struct_alive(firm):
    covariance = firm.kalmanCoreData_t().P
    covariance[...] = 7
    clutter(firm)
    assert np.all(covariance == 7)


def test_trajectory_keeps_its_pieces_alive(firm):
    trajectory = trajectory_at(firm, 1.0, 2.0)
    clutter(firm)
    assert (height(firm, trajectory, 0.5), height(firm, trajectory, 1.5)) == (1.0, 2.0)


def test_piece_outlives_the_trajectory(firm):
    piece = firm.piecewise_get(trajectory_at(firm, 1.0, 2.0), 1)
    clutter(firm)
    assert firm.poly4d_get(piece, 2, 0) == 2.0


def test_planner_keeps_the_trajectory_and_its_pieces_alive(firm):
    planner = firm.planner()
    firm.plan_init(planner)
    firm.plan_start_trajectory(planner, trajectory_at(firm, 1.0, 2.0), False, False, firm.vzero())
    clutter(firm)
    assert firm.plan_current_goal(planner, 0.5).pos.z == 1.0
    assert firm.plan_current_goal(planner, 1.5).pos.z == 2.0
    assert height(firm, planner.trajectory, 1.5) == 2.0


def test_copy_keeps_what_the_original_points_at(firm):
    for duplicate in (copy.copy, copy.deepcopy):
        trajectory = duplicate(trajectory_at(firm, 3.0))
        clutter(firm)
        assert height(firm, trajectory, 0.5) == 3.0


def test_copy_into_a_member_keeps_what_the_original_points_at(firm):
    planner = firm.planner()
    planner.planned_trajectory = trajectory_at(firm, 4.0)
    clutter(firm)
    assert height(firm, planner.planned_trajectory, 0.5) == 4.0


def test_copy_of_a_planner_may_outlive_the_original(firm):
    planner = firm.planner()
    firm.plan_init(planner)
    firm.plan_takeoff(planner, firm.vzero(), 0, 1.0, 0, 2, 0)
    # as in C, the copy's pointer leads into the original
    copied = copy.copy(planner)
    del planner
    clutter(firm)
    assert firm.plan_current_goal(copied, 2).pos.z == 1.0


def test_pieces_may_be_freed_in_any_order(firm):
    trajectory = trajectory_at(firm, 1.0)
    firm.poly4d_free(trajectory.pieces)
    clutter(firm)
    assert height(firm, trajectory, 0.5) == 1.0


def test_sample_of_the_averager_is_part_of_it(firm):
    averager = firm.Axis3fSubSampler_t()
    firm.axis3fSubSamplerInit(averager, 2.0)
    sample = firm.Axis3f()
    sample.z = 3.0
    firm.axis3fSubSamplerAccumulate(averager, sample)
    mean = firm.axis3fSubSamplerFinalize(averager)
    del averager
    clutter(firm)
    assert mean.z == 6.0


def test_trajectory_without_pieces_is_refused(firm):
    trajectory = firm.piecewise_traj()
    for call in (firm.piecewise_eval, firm.piecewise_eval_reversed):
        with pytest.raises(ValueError, match="has no pieces"):
            call(trajectory, 0)
    assert firm.piecewise_duration(trajectory) == 0
    trajectory.n_pieces = 3
    with pytest.raises(ValueError, match="has no pieces"):
        firm.piecewise_duration(trajectory)
    with pytest.raises(ValueError, match="set pieces"):
        firm.piecewise_get(trajectory, 0)
    trajectory.pieces = firm.poly4d_malloc(2)
    with pytest.raises(ValueError, match="n_pieces 3, but memory for 2"):
        firm.piecewise_eval(trajectory, 0)
    trajectory.pieces = None
    assert trajectory.pieces is None


def test_places_outside_of_a_piece_are_refused(firm):
    trajectory = trajectory_at(firm, 1.0)
    piece = firm.piecewise_get(trajectory, 0)
    for dim, coef in ((4, 0), (-1, 0), (0, 8), (0, -1)):
        with pytest.raises(IndexError, match="allowed: 0 to 3"):
            firm.poly4d_get(piece, dim, coef)
        with pytest.raises(IndexError):
            firm.poly4d_set(piece, dim, coef, 1.0)
    for i in (1, -1):
        with pytest.raises(IndexError, match="allowed: 0 to 0"):
            firm.piecewise_get(trajectory, i)
    with pytest.raises(ValueError, match="at least 1"):
        firm.poly4d_malloc(0)


def test_planned_piece_needs_memory(firm):
    trajectory = firm.piecewise_traj()
    zero = firm.vzero()
    states = (zero, 0, zero, 0, zero, firm.mkvec(1, 0, 0), 0, zero, 0, zero)
    for plan in (firm.piecewise_plan_5th_order, firm.piecewise_plan_7th_order_no_jerk):
        trajectory.pieces = None
        with pytest.raises(ValueError, match="has no pieces"):
            plan(trajectory, 2.0, *states)
        trajectory.pieces = firm.poly4d_malloc(1)
        plan(trajectory, 2.0, *states)
        assert (trajectory.n_pieces, trajectory.timescale) == (1, 1)
        assert firm.piecewise_eval(trajectory, 2.0).pos.x == pytest.approx(1, abs=1e-6)
        assert firm.piecewise_is_finished(trajectory, 2.5)


@given(st.lists(st.sampled_from(["new", "pieces", "start", "copy", "drop", "collect", "fly"]), max_size=25))
def test_any_order_of_making_and_dropping_is_safe(actions):
    firm = cffirmware
    planner, trajectory, kept = firm.planner(), trajectory_at(firm, 1.0, 2.0), []
    firm.plan_init(planner)
    for action in actions:
        match action:
            case "new":
                trajectory = trajectory_at(firm, 1.0, 2.0)
            case "pieces":
                trajectory.pieces = trajectory_at(firm, 1.0, 2.0).pieces
            case "start":
                firm.plan_start_trajectory(planner, trajectory, False, False, firm.vzero())
            case "copy":
                trajectory = copy.copy(trajectory)
            case "drop":
                kept = [firm.piecewise_get(trajectory, 1)]
                trajectory = trajectory_at(firm, 1.0, 2.0)
            case "collect":
                gc.collect(0)
            case "fly":
                goal = firm.plan_current_goal(planner, 1.5)
                assert not firm.is_traj_eval_valid(goal) or goal.pos.z == 2.0
    assert all(firm.poly4d_get(piece, 2, 0) == 2.0 for piece in kept)
