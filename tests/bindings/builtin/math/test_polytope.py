"""Half-spaces: inside, rays and projections (docs/reference/planner-commander.md#12.3)."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import minimize

from crazychoir_fw._core import ffi, lib

CUBE = [((1, 0, 0), 1.0), ((0, 1, 0), 1.0), ((0, 0, 1), 1.0), ((-1, 0, 0), 1.0), ((0, -1, 0), 1.0), ((0, 0, -1), 1.0)]

coordinates = st.floats(-3, 3, width=32)
points = st.tuples(coordinates, coordinates, coordinates)
directions = points.filter(lambda p: math.hypot(*p) > 0.1).map(lambda p: tuple(np.array(p) / np.linalg.norm(p)))
half_spaces = st.tuples(directions, st.floats(0.0625, 2.0, width=32))


def arrays(rows):
    normals = ffi.new("float[]", [float(x) for normal, _ in rows for x in normal])
    distances = ffi.new("float[]", [float(distance) for _, distance in rows])
    return normals, distances, len(rows)


def is_inside(point, rows, tolerance=0.0):
    return lib.vinpolytope(point, *arrays(rows), tolerance)


def ray(origin, direction, rows):
    active = ffi.new("int *")
    return lib.rayintersectpolytope(origin, direction, *arrays(rows), active), active[0]


def project(point, rows, tolerance=1e-5, sweeps=100):
    scratch = ffi.new("float[]", 3 * len(rows))
    normals, distances, count = arrays(rows)
    result = lib.vprojectpolytope(point, normals, distances, scratch, count, tolerance, sweeps)
    return np.array([result.x, result.y, result.z])


@pytest.mark.parametrize(
    ("point", "tolerance", "inside"),
    [
        ((0, 0, 0), 0.0, True),
        ((1, 1, 1), 0.0, True),
        ((1.01, 0, 0), 0.0, False),
        ((1.01, 0, 0), 0.02, True),
        ((0, 0, -1.01), 0.0, False),
        ((0, 0, 0), -1.5, False),
        ((math.nan, 0, 0), 1.0, False),
    ],
)
def test_inside_of_a_cube(point, tolerance, inside):
    assert is_inside(point, CUBE, tolerance) is inside


def test_everything_is_inside_of_no_rows():
    assert is_inside((1e9, 0, 0), [])


def test_row_of_nan_has_nothing_inside():
    assert not is_inside((0, 0, 0), [*CUBE, ((math.nan,) * 3, math.nan)], 1.0)


@pytest.mark.parametrize(
    ("origin", "direction", "steps", "row"),
    [
        ((0, 0, 0), (0.5, 0, 0), 2.0, 0),
        ((0, 0, 0), (0, -4, 0), 0.25, 4),
        ((0.5, 0, 0), (1, 0, 0), 0.5, 0),
        ((0, 0, 0), (1, 1, 0), 1.0, 0),  # the first of two walls at the same distance
        ((0, 0, 0), (0, 0, 0), math.inf, -1),
        ((2, 0, 0), (1, 0, 0), -1.0, 0),  # behind a wall the way back counts negative
    ],
)
def test_ray_meets_the_first_wall(origin, direction, steps, row):
    assert ray(origin, direction, CUBE) == (steps, row)


def test_ray_needs_no_row():
    assert lib.rayintersectpolytope((0, 0, 0), (2, 0, 0), *arrays(CUBE), ffi.NULL) == 0.5


def test_ray_to_an_open_side_never_ends():
    assert ray((0, 0, 0), (-1, 0, 0), CUBE[:3]) == (math.inf, -1)


def test_point_inside_is_its_own_projection():
    assert tuple(project((0.25, -0.5, 0.125), CUBE)) == (0.25, -0.5, 0.125)


def test_point_within_the_tolerance_stays():
    assert tuple(project((1.5, 0, 0), CUBE, tolerance=1.0)) == (1.5, 0, 0)


@pytest.mark.parametrize("sweeps", [0, -1])
def test_without_a_sweep_nothing_moves(sweeps):
    assert tuple(project((5, 5, 5), CUBE, sweeps=sweeps)) == (5, 5, 5)


@given(point=points)
def test_projection_on_a_cube_clips_each_axis(point):
    np.testing.assert_allclose(project(point, CUBE), np.clip(point, -1, 1), atol=1e-4)


@given(point=points, half_space=half_spaces)
def test_projection_on_one_half_space_is_orthogonal(point, half_space):
    normal, distance = np.array(half_space[0]), half_space[1]
    expected = np.array(point) - max(0.0, normal @ point - distance) * normal
    np.testing.assert_allclose(project(point, [half_space]), expected, atol=2e-5)


@given(point=points, rows=st.lists(half_spaces, min_size=1, max_size=6))
def test_projection_is_the_nearest_point_inside(point, rows):
    """Against an exact solver; only where Dykstra's method has arrived, which more sweeps would show."""
    rows = [*CUBE, *rows]  # all contain the origin, so that the set is not empty
    found = project(point, rows, sweeps=20000)
    normals = np.array([normal for normal, _ in rows], float)
    distances = np.array([distance for _, distance in rows])
    exact = minimize(
        lambda x: ((x - point) ** 2).sum(),
        np.zeros(3),
        jac=lambda x: 2 * (x - point),
        constraints={"type": "ineq", "fun": lambda x: distances - normals @ x, "jac": lambda x: -normals},
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 300},
    )
    assume(exact.success)
    assert is_inside(tuple(found), rows, 1e-3)
    assert np.linalg.norm(found - point) == pytest.approx(np.linalg.norm(exact.x - point), abs=2e-3)
