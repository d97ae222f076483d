"""Half-spaces and polytopes of math3d.

docs/reference/control-geometric.md#4.7, docs/reference/planner-commander.md#12.3.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from crazychoir_fw._core import ffi, lib

# the cube |x|, |y|, |z| <= 1
CUBE = np.vstack([np.eye(3), -np.eye(3)])
ONES = [1.0] * 6

numbers = st.floats(-5, 5, width=32)
vectors = st.tuples(numbers, numbers, numbers)
# walls at 0.25 m to 3 m from the origin, facing anywhere
walls = st.lists(
    st.tuples(vectors.filter(lambda v: np.linalg.norm(v) > 0.1), st.floats(0.25, 3, width=32)), min_size=1, max_size=6
)


def vec(values):
    return ffi.new("struct vec *", dict(zip("xyz", values, strict=True)))[0]


def xyz(v):
    return (v.x, v.y, v.z)


def flat(rows):
    return [float(value) for value in np.ravel(rows)]


def project(v, rows, b, tolerance=1e-4, sweeps=1000):
    work = ffi.new("float[]", 3 * len(b))
    return xyz(lib.vprojectpolytope(vec(v), flat(rows), b, work, len(b), tolerance, sweeps))


@pytest.mark.parametrize(
    ("x", "expected"), [((0, 0, 0.5), (0, 0, 0.5)), ((1, 2, 1), (1, 2, 1)), ((1, 2, 7), (1, 2, 1))]
)
def test_a_half_space_takes_what_is_outside_to_its_wall(x, expected):
    assert xyz(lib.vprojecthalfspace(vec(x), vec((0, 0, 1)), 1.0)) == expected


@pytest.mark.parametrize(
    ("point", "tolerance", "inside"),
    [
        ((0, 0, 0), 0.0, True),
        ((1, 1, 1), 0.0, True),
        ((1.5, 0, 0), 0.25, False),
        ((1.5, 0, 0), 0.5, True),
        ((0, 0, -1.5), 0.25, False),
    ],
)
def test_inside_means_inside_all_walls(point, tolerance, inside):
    assert lib.vinpolytope(vec(point), flat(CUBE), ONES, 6, tolerance) == inside


@pytest.mark.parametrize(
    ("direction", "times", "row"),
    [
        ((2, 0, 0), 0.25, 0),
        ((0, 0.5, 0), 2.0, 1),
        ((0, 0, -4), 0.25, 5),
        ((1, 1, 0), 0.5, 0),  # x is at 0.5: the nearer wall
        ((0, 1, 1), 1.0, 1),  # a tie: the first
        ((0, 0, 0), math.inf, -1),
    ],
)
def test_a_ray_finds_the_first_wall(direction, times, row):
    active = ffi.new("int *")
    assert lib.rayintersectpolytope(vec((0.5, 0, 0)), vec(direction), flat(CUBE), ONES, 6, active) == times
    assert active[0] == row


def test_the_row_of_a_ray_need_not_be_asked_for():
    assert lib.rayintersectpolytope(vec((0, 0, 0)), vec((1, 0, 0)), flat(CUBE), ONES, 6, ffi.NULL) == 1.0


def test_no_wall_is_met_without_walls():
    active = ffi.new("int *")
    assert lib.rayintersectpolytope(vec((0, 0, 0)), vec((1, 0, 0)), [], [], 0, active) == math.inf
    assert active[0] == -1


def test_a_point_inside_stays_where_it_is():
    assert project((0.5, -0.25, 1.0), CUBE, ONES) == (0.5, -0.25, 1.0)


@given(vectors)
def test_projection_on_a_cube_clips(v):
    assert project(v, CUBE, ONES) == pytest.approx(tuple(np.clip(v, -1, 1)), abs=1e-3)


def test_projection_stops_after_the_given_sweeps():
    assert project((5, 5, 5), CUBE, ONES, sweeps=0) == (5, 5, 5)


@given(vectors, walls)
def test_projection_is_the_closest_point(v, walls):
    rows = np.array([normal for normal, _ in walls], dtype=float)
    rows /= np.linalg.norm(rows, axis=1, keepdims=True)
    b = [float(distance) for _, distance in walls]
    found = np.array(project(v, rows, b, tolerance=1e-3, sweeps=20000))
    exact = minimize(
        lambda x: np.sum((x - v) ** 2),
        np.zeros(3),
        jac=lambda x: 2 * (x - v),
        constraints={"type": "ineq", "fun": lambda x: b - rows @ x, "jac": lambda x: -rows},
        method="SLSQP",
        options={"ftol": 1e-12, "maxiter": 500},
    ).x
    # narrow wedges converge slowly: what is found is never nearer than possible, and never far from the best
    assert np.all(rows @ found - b < 0.05)
    assert np.linalg.norm(found - v) <= np.linalg.norm(exact - v) + 0.05
