"""The grid of neighbors gives what a look at all pairs would give."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

REACH = lib.CF_PEER_GRID_REACH
MOST = 10


class Grid:
    """A grid filled with positions, shape (N, 3)."""

    def __init__(self, positions, capacity=None):
        self.positions = np.asarray(positions, dtype=np.float32).reshape(-1, 3)
        self._grid = ffi.new("cf_peer_grid_t *")
        assert lib.cf_peer_grid_new(self._grid, capacity or max(1, len(self.positions)))
        self.fill(self.positions)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        lib.cf_peer_grid_free(self._grid)

    def fill(self, positions):
        lib.cf_peer_grid_clear(self._grid)
        for i, position in enumerate(positions):
            lib.cf_peer_grid_add(self._grid, i, position.tolist())
        lib.cf_peer_grid_sort(self._grid)

    def nearest(self, i, most=MOST):
        return self.near(self.positions[i].tolist(), i, most)

    def near(self, position, who=-1, most=MOST):
        found = ffi.new("cf_seen_drone_t[]", MOST + 10)
        count = lib.cf_peer_grid_nearest(self._grid, position, who, found, most)
        return [found[k].index for k in range(count)]


def neighbors(positions, i, most=MOST):
    """Return the same from all pairs, with float32 distances and ties by index."""
    positions = np.asarray(positions, dtype=np.float32).reshape(-1, 3)
    d = positions[i] - positions
    squares = (d[:, 0] * d[:, 0] + d[:, 1] * d[:, 1]) + d[:, 2] * d[:, 2]
    order = sorted((float(s), k) for k, s in enumerate(squares) if k != i and s < REACH * REACH)
    return [k for _, k in order[:most]]


def scattered(count, size, seed=0):
    return np.random.default_rng(seed).uniform(-0.5, 0.5, (count, 3)).astype(np.float32) * size


@pytest.mark.parametrize("size", [(0.5, 0.5, 0.5), (5, 5, 2), (60, 60, 3), (300, 300, 30), (40, 0, 0), (1, 1, 40)])
@pytest.mark.parametrize("count", [1, 2, 11, 40, 300])
def test_same_neighbors_as_by_all_pairs(count, size):
    positions = scattered(count, np.array(size))
    with Grid(positions) as grid:
        assert [grid.nearest(i) for i in range(count)] == [neighbors(positions, i) for i in range(count)]


quarters = st.integers(-44, 44).map(lambda k: k / 4)
near_edges = st.sampled_from([-1e-7, 0.0, 1e-7, 0.99999994, 1.0, -1.0, 9.999999, 10.0, 10.000001])
places = st.tuples(*[quarters | near_edges | st.floats(-12, 12, width=32)] * 3)


@given(positions=st.lists(places, min_size=1, max_size=40), most=st.integers(1, MOST))
def test_same_neighbors_on_the_edges_of_columns(positions, most):
    with Grid(positions) as grid:
        for i in range(len(positions)):
            assert grid.nearest(i, most) == neighbors(positions, i, most)


def test_equally_near_ones_come_by_index():
    ring = [(0, 0, 0)] + [(math.copysign(1, s), 0, 0) for s in (1, -1)] + [(0, 1, 0), (0, -1, 0), (0, 0, 1)]
    with Grid(ring) as grid:
        assert grid.nearest(0) == [1, 2, 3, 4, 5]
        assert grid.nearest(0, 2) == [1, 2]


def test_order_of_the_drones_does_not_matter():
    positions = scattered(200, 8.0)
    shuffle = np.random.default_rng(1).permutation(200)
    with Grid(positions) as grid, Grid(positions[shuffle]) as shuffled:
        for k, i in enumerate(shuffle):
            assert [shuffle[j] for j in shuffled.nearest(k)] == grid.nearest(i)


def test_whoever_is_out_of_reach_is_no_neighbor():
    with Grid([(0, 0, 0), (REACH, 0, 0), (0, REACH - 0.001, 0), (0, 0, -REACH)]) as grid:
        assert grid.nearest(0) == [2]


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e4, -3e38])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_wild_positions_are_seen_by_nobody(bad, axis):
    positions = np.zeros((3, 3), np.float32)
    positions[1, axis] = bad
    with Grid(positions) as grid:
        assert grid.nearest(0) == [2]
        assert grid.nearest(1) == []
        assert grid.nearest(2) == [0]


def test_distant_drone_has_no_neighbors():
    with Grid([(0, 0, 0), (1, 0, 0), (9999, -9999, 50)]) as grid:
        assert grid.nearest(2) == []
        assert grid.nearest(0) == [1]


def test_anybody_may_ask_who_is_near():
    """Also a place outside of what the grid holds."""
    with Grid([(0, 0, 0), (1, 0, 0)]) as grid:
        assert grid.near([-3.0, 5.0, 1.0]) == [0, 1]
        assert grid.near([6.0, 0.0, 0.0]) == [1, 0]
        assert grid.near([0.0, -30.0, 0.0]) == []


def test_empty_grid_has_nobody():
    with Grid(np.zeros((0, 3)), capacity=5) as grid:
        assert grid.near([0.0, 0.0, 0.0]) == []


def test_more_than_the_capacity_is_left_out():
    with Grid([(0, 0, 0), (1, 0, 0), (2, 0, 0)], capacity=2) as grid:
        assert grid.near([0.0, 0.0, 0.0]) == [0, 1]


def test_nobody_is_asked_for():
    with Grid([(0, 0, 0), (1, 0, 0)]) as grid:
        assert grid.nearest(0, 0) == []
        assert grid.nearest(0, -1) == []


def test_most_is_limited():
    positions = scattered(30, 1.0)
    with Grid(positions) as grid:
        assert grid.nearest(0, 20) == neighbors(positions, 0, lib.CF_PEER_GRID_MAX)


def test_grid_may_be_filled_again():
    first, second = scattered(50, 6.0, seed=1), scattered(50, 6.0, seed=2)
    with Grid(first) as grid, Grid(second) as fresh:
        grid.fill(second)
        grid.positions = second
        assert [grid.nearest(i) for i in range(50)] == [fresh.nearest(i) for i in range(50)]
