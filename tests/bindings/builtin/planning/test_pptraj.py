"""Polynomials, pieces and trajectories (docs/reference/planner-commander.md#4 and #17), with numpy and scipy."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from numpy.typing import NDArray
from scipy.interpolate import BPoly
from scipy.spatial.transform import Rotation

from crazychoir_fw._core import ffi, lib

DATA = Path(__file__).parent / "data"
FIGURE8 = np.loadtxt(DATA / "figure8.csv", delimiter=",")
FIGURE8_GOALS = np.loadtxt(DATA / "figure8_goals.csv", delimiter=",")
FIGURE8_DURATION = 7.27999973

coefficients = st.lists(st.floats(-4.0, 4.0, width=32), min_size=8, max_size=8)
instants = st.floats(0.0, 2.0, width=32)


def xyz(v) -> list[float]:
    return [v.x, v.y, v.z]


def as_row(ev) -> NDArray[np.float64]:
    """Return position, velocity, acceleration, jerk, yaw and body rates in the order of the data files."""
    return np.array([*xyz(ev.pos), *xyz(ev.vel), *xyz(ev.acc), *xyz(ev.jerk), ev.yaw, *xyz(ev.omega)])


def make_pieces(table: NDArray[np.float64]):
    """Return C pieces from rows of duration, x0..x7, y0..y7."""
    pieces = ffi.new("struct poly4d[]", len(table))
    for piece, row in zip(pieces, table, strict=True):
        piece.duration = row[0]
        piece.p[0] = list(row[1:9])
        piece.p[1] = list(row[9:17])
    return pieces


def make_trajectory(pieces, t_begin=0.0, timescale=1.0, shift=(0.0, 0.0, 0.0), shift_yaw=0.0):
    """Return a view of pieces; the caller keeps the pieces alive."""
    return ffi.new("struct piecewise_traj *", [t_begin, timescale, list(shift), shift_yaw, len(pieces), pieces])


@pytest.fixture
def figure8():
    return make_pieces(FIGURE8)


# --- goals on the figure-8


@pytest.mark.parametrize("row", FIGURE8_GOALS, ids=lambda row: f"t={row[0]}")
def test_figure8_goal_has_the_expected_numbers(figure8, row: NDArray[np.float64]) -> None:
    goal = lib.piecewise_eval(make_trajectory(figure8), row[0])
    np.testing.assert_allclose(as_row(goal), row[1:], rtol=1e-6, atol=1e-6)


def test_slowed_figure8_goal_has_the_expected_numbers(figure8) -> None:
    expected = [0.038679995, -0.056635857, 0, 0.13831407, -0.19438635, 0, 0.32936639, -0.41944349, 0]
    expected += [0.30361277, -0.1818701, 0, 0, 0.018495021, 0.030859796, 0]
    goal = lib.piecewise_eval(make_trajectory(figure8, timescale=2.0), 1.0)
    np.testing.assert_allclose(as_row(goal), expected, rtol=1e-6, atol=1e-7)


def test_figure8_duration_is_the_sum_of_its_pieces(figure8) -> None:
    assert lib.piecewise_duration(make_trajectory(figure8)) == np.float32(FIGURE8_DURATION)
    assert lib.piecewise_duration(make_trajectory(figure8, timescale=0.5)) == np.float32(FIGURE8_DURATION / 2)


@pytest.mark.parametrize("tenth", range(-5, 78))
def test_figure8_stays_slow_and_ends_in_time(figure8, tenth: int) -> None:
    t = 2.0 + 0.1 * tenth
    trajectory = make_trajectory(figure8, t_begin=2.0, shift=(-1.0, 2.0, 3.0))
    goal = lib.piecewise_eval(trajectory, t)
    assert lib.is_traj_eval_valid(ffi.new("struct traj_eval *", goal))
    assert np.abs(xyz(goal.vel)).max() <= 2.5
    assert lib.piecewise_is_finished(trajectory, t) == (np.float32(t) >= 2.0 + np.float32(FIGURE8_DURATION))


def test_goal_behind_the_end_stands_still(figure8) -> None:
    end = FIGURE8[-1]
    expected = [Polynomial(end[1:9])(end[0]) + 1.0, Polynomial(end[9:17])(end[0]) + 2.0, 3.0]
    goal = lib.piecewise_eval(make_trajectory(figure8, shift=(1.0, 2.0, 3.0)), 100.0)
    np.testing.assert_allclose(as_row(goal), [*expected, *[0.0] * 13], atol=1e-6)


@given(st.floats(0.0, 7.25, width=32), st.sampled_from([0.5, 1.0, 2.0]))
def test_reversed_trajectory_runs_back_through_the_same_points(t: float, timescale: float) -> None:
    pieces = make_pieces(FIGURE8)
    trajectory = make_trajectory(pieces, timescale=timescale, shift=(1.0, -2.0, 0.5))
    duration = lib.piecewise_duration(trajectory)
    backward = lib.piecewise_eval_reversed(trajectory, t * timescale)
    forward = lib.piecewise_eval(trajectory, duration - t * timescale)
    np.testing.assert_allclose(xyz(backward.pos), xyz(forward.pos), atol=2e-4)
    if t > 0.0:
        np.testing.assert_allclose(xyz(backward.vel), np.negative(xyz(forward.vel)), atol=5e-3)


def test_reversed_trajectory_rests_at_its_first_point_and_ignores_yaw_shift(figure8) -> None:
    trajectory = make_trajectory(figure8, shift=(1.0, -2.0, 0.5), shift_yaw=1.0)
    goal = lib.piecewise_eval_reversed(trajectory, 50.0)
    assert as_row(goal).tolist() == [1.0, -2.0, 0.5, *[0.0] * 13]


def test_trajectory_without_pieces_has_no_goal(figure8) -> None:
    trajectory = make_trajectory(figure8)
    trajectory.n_pieces = 0
    for evaluate in (lib.piecewise_eval, lib.piecewise_eval_reversed):
        assert not lib.is_traj_eval_valid(ffi.new("struct traj_eval *", evaluate(trajectory, 0.0)))
    assert lib.piecewise_is_finished(trajectory, 0.0)


@given(st.floats(-7.0, 7.0, width=32))
def test_transform_turns_position_velocity_and_acceleration_only(rotation: float) -> None:
    ev = ffi.new("struct traj_eval *", [[1, 2, 3], [4, 5, 6], [7, 8, 9], [1, 1, 1], [2, 2, 2], 0.5])
    lib.traj_eval_transform(ev, [10, 20, 30], rotation)
    turn = Rotation.from_euler("z", rotation)
    np.testing.assert_allclose(xyz(ev.pos), np.add(turn.apply([1, 2, 3]), [10, 20, 30]), rtol=1e-5)
    np.testing.assert_allclose(xyz(ev.vel), turn.apply([4, 5, 6]), atol=1e-5)
    np.testing.assert_allclose(xyz(ev.acc), turn.apply([7, 8, 9]), atol=1e-5)
    assert [xyz(ev.jerk), xyz(ev.omega)] == [[1, 1, 1], [2, 2, 2]]
    assert math.remainder(ev.yaw - 0.5 - rotation, 2 * math.pi) == pytest.approx(0.0, abs=1e-5)


# --- one piece


def test_zero_evaluation_is_valid_and_zero() -> None:
    zero = ffi.new("struct traj_eval *", lib.traj_eval_zero())
    assert lib.is_traj_eval_valid(zero)
    assert not as_row(zero).any()


def test_invalid_evaluation_is_not_valid() -> None:
    assert not lib.is_traj_eval_valid(ffi.new("struct traj_eval *", lib.traj_eval_invalid()))


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_evaluation_with_one_nan_is_not_valid(axis: str) -> None:
    ev = ffi.new("struct traj_eval *", lib.traj_eval_zero())
    setattr(ev.pos, axis, math.nan)
    assert not lib.is_traj_eval_valid(ev)


@given(coefficients, coefficients, coefficients, coefficients, st.floats(0.0, 1.0, width=32))
def test_piece_has_the_derivatives_of_its_polynomials(x, y, z, yaw, t: float) -> None:
    piece = ffi.new("struct poly4d *", [[x, y, z, yaw], 1.0])
    ev = lib.poly4d_eval(piece, t)
    axes = [Polynomial(c) for c in (x, y, z)]
    for order, value in enumerate([ev.pos, ev.vel, ev.acc, ev.jerk]):
        expected = [axis.deriv(order)(t) if order else axis(t) for axis in axes]
        np.testing.assert_allclose(xyz(value), expected, rtol=1e-4, atol=2e-3)
    assert ev.yaw == pytest.approx(Polynomial(yaw)(t), rel=1e-5, abs=1e-5)


def test_body_rates_are_those_of_the_turning_thrust_vector() -> None:
    """Compare with the rotation between two instants, from attitudes built out of thrust and yaw."""
    rng = np.random.default_rng(7)
    piece = ffi.new("struct poly4d *", [rng.uniform(-1, 1, (4, 8)).tolist(), 1.0])
    polynomials = [Polynomial(list(axis)) for axis in piece.p]

    def attitude(t: float) -> Rotation:
        z = np.add([p.deriv(2)(t) for p in polynomials[:3]], [0.0, 0.0, 9.81])
        z /= np.linalg.norm(z)
        yaw = polynomials[3](t)
        y = np.cross(z, [math.cos(yaw), math.sin(yaw), 0.0])
        y /= np.linalg.norm(y)
        return Rotation.from_matrix(np.column_stack([np.cross(y, z), y, z]))

    dt = 1e-5
    rates = (attitude(0.4 - dt).inv() * attitude(0.4 + dt)).as_rotvec() / (2 * dt)
    omega = xyz(lib.poly4d_eval(piece, 0.4).omega)
    np.testing.assert_allclose(omega[:2], rates[:2], rtol=1e-4)
    # the yaw rate is only the part that comes from the yaw polynomial
    assert omega[2] == pytest.approx(attitude(0.4).as_matrix()[2, 2] * polynomials[3].deriv()(0.4), rel=1e-5)


def test_free_fall_spoils_the_body_rates_only() -> None:
    piece = ffi.new("struct poly4d *", lib.poly4d_zero(1.0))
    piece.p[2][2] = np.float32(-9.81) / 2
    row = as_row(lib.poly4d_eval(piece, 0.5))
    assert np.isfinite(row[:13]).all()
    assert np.isnan(row[13:]).all()


def test_linear_piece_joins_its_ends() -> None:
    piece = ffi.new("struct poly4d *", lib.poly4d_linear(2.0, [0, 1, 2], [2, 1, 0], 0.0, 1.0))
    middle = lib.poly4d_eval(piece, 1.0)
    assert [xyz(middle.pos), xyz(middle.vel), middle.yaw] == [[1, 1, 1], [1, 0, -1], 0.5]


def test_piece_can_be_scaled_shifted_and_stretched() -> None:
    piece = ffi.new("struct poly4d *", lib.poly4d_linear(2.0, [1, 1, 1], [3, 3, 3], 1.0, 3.0))
    lib.poly4d_scale(piece, 1.0, 2.0, 3.0, 4.0)
    lib.poly4d_shift_vec(piece, [10, 20, 30], 40.0)
    lib.poly4d_stretchtime(piece, 2.0)
    end = lib.poly4d_eval(piece, piece.duration)
    assert [piece.duration, xyz(end.pos), end.yaw] == [4.0, [13, 26, 39], 52.0]


@pytest.mark.parametrize(("duration", "expected"), [(1.0, 14.0), (0.05, 0.0), (0.15, 2.0), (math.nan, 0.0)])
def test_largest_acceleration_is_sampled(duration: float, expected: float) -> None:
    # acc = (6 t, -6 t, 2); ten samples a second: only the one at t = 0 for 0.15 s, none for 0.05 s
    piece = ffi.new("struct poly4d *", lib.poly4d_zero(duration))
    piece.p[0] = [0, 0, 0, 1, 0, 0, 0, 0]
    piece.p[1] = [0, 0, 0, -1, 0, 0, 0, 0]
    piece.p[2] = [0, 0, 1, 0, 0, 0, 0, 0]
    piece.p[3] = [9, 9, 9, 9, 9, 9, 9, 9]
    assert lib.poly4d_max_accel_approx(piece) == pytest.approx(expected, rel=1e-5)


# --- polynomials in one variable


@given(coefficients, instants)
def test_value_of_a_polynomial(p: list[float], t: float) -> None:
    assert lib.polyval(p, t) == pytest.approx(Polynomial(p)(t), rel=1e-4, abs=1e-3)


@given(coefficients)
def test_derivative_of_a_polynomial(p: list[float]) -> None:
    c = ffi.new("float[8]", p)
    lib.polyder(c)
    np.testing.assert_allclose(list(c), [*Polynomial(p).deriv().coef, 0.0], rtol=1e-6)


@given(coefficients, instants)
def test_reflected_polynomial_runs_backwards(p: list[float], t: float) -> None:
    c = ffi.new("float[8]", p)
    lib.polyreflect(c)
    assert lib.polyval(c, -t) == lib.polyval(p, t)


@given(coefficients, st.floats(0.5, 4.0, width=32), st.floats(0.0, 1.0, width=32))
def test_stretched_polynomial_takes_its_time(p: list[float], s: float, t: float) -> None:
    c = ffi.new("float[8]", p)
    lib.polystretchtime(c, s)
    assert lib.polyval(c, t * s) == pytest.approx(lib.polyval(p, t), rel=1e-4, abs=1e-3)


def test_scaled_polynomial() -> None:
    c = ffi.new("float[8]", list(range(8)))
    lib.polyscale(c, -2.0)
    assert list(c) == [-2.0 * k for k in range(8)]


# docs/reference/planner-commander.md#17.2
@pytest.mark.parametrize(
    ("points", "expected"),
    [
        ([0, 0, 1, 1], [0, 0, 0.75, -0.249999985]),
        ([0, 0, 0, 0, 1, 1, 1, 1], [0, 0, 0, 0, 2.1875, -2.62500024, 1.09375, -0.156249985]),
        ([0, 1, 2, 3], [0, 1.5, 0, 0]),
    ],
)
def test_bezier_conversion_has_the_expected_numbers(points: list[float], expected: list[float]) -> None:
    c = ffi.new("float[8]")
    lib.polybezier(c, 2.0, [float(x) for x in points], len(points))
    np.testing.assert_allclose(list(c), [*expected, *[0.0] * (8 - len(expected))], rtol=1e-7, atol=0)


@given(st.lists(st.floats(-2.0, 2.0, width=32), min_size=1, max_size=8), st.floats(0.0, 1.0, width=32))
def test_bezier_conversion_keeps_the_curve(points: list[float], t: float) -> None:
    c = ffi.new("float[8]")
    lib.polybezier(c, 3.0, points, len(points))
    bernstein = BPoly(np.array(points)[:, None], [0.0, 3.0])
    assert lib.polyval(c, 3.0 * t) == pytest.approx(float(bernstein(3.0 * t)), abs=2e-3)


@pytest.mark.parametrize("dim", [-1, 0])
def test_bezier_without_points_writes_nothing(dim: int) -> None:
    c = ffi.new("float[8]", [5.0] * 8)
    lib.polybezier(c, 1.0, [1.0], dim)
    assert list(c) == [5.0] * 8


def test_bezier_reads_at_most_eight_points() -> None:
    c, d = ffi.new("float[8]"), ffi.new("float[8]")
    points = [0.0, 1.0, 0.0, 2.0, 0.0, 3.0, 0.0, 4.0]
    lib.polybezier(c, 1.0, points, 8)
    lib.polybezier(d, 1.0, [*points, 9.0], 9)
    assert list(c) == list(d)


boundary_values = st.tuples(*[st.floats(-2.0, 2.0, width=32)] * 6)


@given(st.floats(0.5, 4.0, width=32), boundary_values)
def test_quintic_meets_its_boundary_values(T: float, values: tuple[float, ...]) -> None:
    c = ffi.new("float[8]")
    lib.poly5(c, T, *values)
    p = Polynomial(list(c))
    reached = [p(0.0), p.deriv()(0.0), p.deriv(2)(0.0), p(T), p.deriv()(T), p.deriv(2)(T)]
    np.testing.assert_allclose(reached, values, atol=2e-3)


@given(st.floats(0.5, 4.0, width=32), boundary_values, boundary_values, st.tuples(*[st.floats(-2.0, 2.0)] * 4))
def test_planned_pieces_meet_their_boundary_values(T: float, xy, zz, yaw) -> None:
    start = [[xy[i], xy[i + 3], zz[i]] for i in range(3)]
    end = [[zz[i + 3], xy[i], xy[i + 3]] for i in range(3)]
    for plan, jerk_free in [(lib.piecewise_plan_5th_order, False), (lib.piecewise_plan_7th_order_no_jerk, True)]:
        piece = ffi.new("struct poly4d *")
        plan(piece, T, start[0], yaw[0], start[1], yaw[1], start[2], end[0], yaw[2], end[1], yaw[3], end[2])
        assert piece.duration == T
        for t, (pos, vel, acc), (psi, dpsi) in [(0.0, start, yaw[:2]), (T, end, yaw[2:])]:
            ev = lib.poly4d_eval(piece, t)
            np.testing.assert_allclose([*xyz(ev.pos), *xyz(ev.vel), *xyz(ev.acc)], [*pos, *vel, *acc], atol=1e-2)
            heading = Polynomial(list(piece.p[3]))
            np.testing.assert_allclose([heading(t), heading.deriv()(t), heading.deriv(2)(t)], [psi, dpsi, 0], atol=1e-2)
            if jerk_free:
                np.testing.assert_allclose(xyz(ev.jerk), [0, 0, 0], atol=5e-2)


@pytest.mark.parametrize("duration", [0.0, -1.0])
def test_piece_without_duration_is_its_end(duration: float) -> None:
    piece = ffi.new("struct poly4d *")
    zero, goal = [0, 0, 0], [1, 2, 3]
    lib.piecewise_plan_7th_order_no_jerk(piece, duration, zero, 0, zero, 0, zero, goal, 4, [5, 6, 7], 8, [2, 4, 6])
    assert [list(axis) for axis in piece.p] == [
        [1, 5, 1, 0, 0, 0, 0, 0],
        [2, 6, 2, 0, 0, 0, 0, 0],
        [3, 7, 3, 0, 0, 0, 0, 0],
        [4, 8, 0, 0, 0, 0, 0, 0],
    ]
