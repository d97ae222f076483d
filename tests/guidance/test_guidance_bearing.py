"""Geometry of bearings: eigenvalues (docs/reference/crazychoir.md#23), rigidity, errors."""

import numpy as np
import pytest
from guidance_swarm import GRID, LETTER_S, LETTER_S_GRAPH, SQUARE, SQUARE_GRAPH, grid_graph
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance import Graph
from crazychoir_fw.guidance.bearing import (
    bearing,
    bearing_error_deg,
    bearing_errors_deg,
    bearing_laplacian,
    check_formation,
    follower_eigenvalues,
    free_followers,
    is_rigid,
    modes,
    ort_proj,
    projection,
    projections,
    projections_of_ort_proj,
)

POINTS = st.tuples(st.integers(3, 6), st.integers(0, 10_000)).map(
    lambda drawn: np.random.default_rng(drawn[1]).uniform(-3.0, 3.0, (drawn[0], 3))
)


def apart(points):
    return min(np.linalg.norm(points[i] - points[j]) for i in range(len(points)) for j in range(i)) > 0.1


def test_eigenvalues_of_four_drones():
    values = follower_eigenvalues(SQUARE, SQUARE_GRAPH, [0, 1])
    np.testing.assert_allclose(values, [0.1454, 1.0, 1.382, 1.403, 2.452, 3.618], atol=5e-4)


@pytest.mark.parametrize(("k_p", "k_v", "slowest"), [(0.2, 1.0, -0.0727 + 0.154j), (1.0, 5.0, -0.202)])
def test_slowest_modes_of_four_drones(k_p, k_v, slowest):
    first = modes(follower_eigenvalues(SQUARE, SQUARE_GRAPH, [0, 1]), k_p, k_v)[0]
    assert first.real == pytest.approx(slowest.real, abs=5e-4)
    assert abs(first.imag) == pytest.approx(abs(complex(slowest).imag), abs=5e-4)


def test_eigenvalue_and_mode_of_the_letter():
    values = follower_eigenvalues(LETTER_S, LETTER_S_GRAPH, [0, 1])
    assert values[0] == pytest.approx(0.118, abs=5e-4)
    assert modes(values, 0.2, 1.0)[0].real == pytest.approx(-0.059, abs=5e-4)


def test_eigenvalue_and_modes_of_the_grid():
    # the reference does not give the graph: this one has the same number of edges
    values = follower_eigenvalues(GRID, grid_graph(), [0, 1])
    assert values[0] == pytest.approx(0.00348, abs=1e-4)
    assert modes(values, 0.2, 1.0)[0].real == pytest.approx(-0.0017, abs=1e-4)
    assert modes(values, 0.07, 0.35)[0].real == pytest.approx(-0.0006, abs=1e-4)


def test_an_integral_that_is_too_strong_shows_in_the_modes():
    values = follower_eigenvalues(SQUARE, SQUARE_GRAPH, [0, 1])
    assert modes(values, 0.2, 1.0, 0.01)[0].real < 0.0 < modes(values, 0.2, 1.0, 0.1)[0].real


@settings(max_examples=30)
@given(POINTS)
def test_projections_project(points):
    assume(apart(points))
    for block in projections(points, 0, range(1, len(points))).values():
        np.testing.assert_allclose(block @ block, block, atol=1e-12)
        np.testing.assert_allclose(block, block.T, atol=1e-15)
        assert np.trace(block) == pytest.approx(2.0)
    g = bearing(points[0], points[1])
    np.testing.assert_allclose(projection(g) @ g, 0.0, atol=1e-12)


@settings(max_examples=30)
@given(POINTS, st.floats(0.2, 5.0))
def test_moving_and_growing_change_no_bearing(points, scale):
    assume(apart(points))
    graph = Graph.complete(len(points))
    moved = scale * points + np.array([1.0, -2.0, 0.5])
    assert bearing_error_deg(moved, points, graph.pairs) < 1e-4
    laplacian = bearing_laplacian(points, graph)
    for still in (np.tile(np.eye(3), (len(points), 1)), points.reshape(-1, 1)):
        np.testing.assert_allclose(laplacian @ still, 0.0, atol=1e-9)


def test_errors_are_angles():
    pairs, line = [(0, 1)], np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
    for angle in (0.0, 1e-4, 30.0, 90.0, 180.0):
        turned = line.copy()
        turned[1, :2] = 2.0 * np.cos(np.radians(angle)), 2.0 * np.sin(np.radians(angle))
        assert bearing_error_deg(turned, line, pairs) == pytest.approx(angle, abs=1e-9)
    many = np.stack([line, line])
    assert bearing_errors_deg(many, line, pairs).shape == (2, 1)
    assert bearing_error_deg(many, line, []).shape == (2,)


def test_ort_proj_holds_the_projections_of_neighbors():
    flat = ort_proj(SQUARE, 2, SQUARE_GRAPH.in_neighbors(2))
    assert len(flat) == 36 and np.asarray(flat).reshape(3, 12)[:, :3].any() == np.False_
    read = projections_of_ort_proj(flat, 4, [1, 3])
    for neighbor, block in projections(SQUARE, 2, [1, 3]).items():
        np.testing.assert_array_equal(read[neighbor], block)
    with pytest.raises(RangeError, match="neighbor 0 is no orthogonal projection"):
        projections_of_ort_proj(flat, 4, [0])
    with pytest.raises(RangeError, match="36"):
        projections_of_ort_proj(flat[:-1], 4, [1])


@pytest.mark.parametrize(
    ("formation", "graph"), [(SQUARE, SQUARE_GRAPH), (LETTER_S, LETTER_S_GRAPH), (GRID, grid_graph())]
)
def test_formations_of_the_examples_are_determined(formation, graph):
    check_formation(formation, graph, [0, 1])
    assert is_rigid(formation, graph)


def test_rigidity():
    assert not is_rigid(SQUARE, Graph.ring(4))  # sides may grow apart
    assert is_rigid(SQUARE, Graph.complete(4))
    corner = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
    assert is_rigid(corner, Graph.complete(3)) and not is_rigid(corner, Graph.path(3))


def test_ambiguous_formations_name_who_is_free():
    graph = Graph.undirected(4, [(0, 1), (0, 3), (1, 3), (2, 3)], ["red", "green", "blue", "gray"])
    assert free_followers(SQUARE, graph, [0, 1]) == [2]
    with pytest.raises(RangeError, match=r"determine where blue shall be"):
        check_formation(SQUARE, graph, [0, 1])


@pytest.mark.parametrize(
    ("formation", "leaders", "words"),
    [
        (SQUARE, [0], "1 leaders, allowed: 2 or more"),
        (SQUARE[:3], [0, 1], "3 places"),
        (SQUARE, [0, 7], "leaders hold 7"),
        (SQUARE[:, :2], [0, 1], "shape"),
        (np.full((4, 3), np.nan), [0, 1], "not finite"),
        (SQUARE[[0, 1, 1, 3]], [0, 1], "agents 1 and 2"),
    ],
)
def test_bad_formations_are_named(formation, leaders, words):
    with pytest.raises(RangeError, match=words):
        check_formation(formation, SQUARE_GRAPH, leaders)


def test_who_hears_no_leader_is_named():
    with pytest.raises(RangeError, match="to agent_3,"):
        check_formation(SQUARE, SQUARE_GRAPH.without([3]), [0, 1])
