"""The scalar update against dense products (docs/reference/estimators.md#4.6)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

F = np.float32
moderate = st.floats(-10.0, 10.0, width=32)


@pytest.mark.parametrize("entries", range(10))
@pytest.mark.parametrize("seed", range(20))
def test_update_equals_dense_products(helpers, seed, entries):
    rng = np.random.default_rng(100 * entries + seed)
    core = helpers.random_core(seed)
    twin = helpers.DenseFilter.of(core)
    H = np.zeros(9, np.float32)
    H[rng.choice(9, size=entries, replace=False)] = rng.normal(size=entries)
    error, std_dev = F(rng.normal()), F(10.0 ** rng.uniform(-3, 1))

    lib.kalmanCoreScalarUpdate(core, H.tolist(), error, std_dev)
    twin.scalar_update(H, error, std_dev)
    twin.assert_same_as(core)


@pytest.mark.parametrize("seed", range(20))
def test_update_equals_dense_products_when_the_covariance_is_not_symmetric(helpers, seed):
    rng = np.random.default_rng(seed)
    core = helpers.random_core(seed)
    helpers.assign(core.P, helpers.array(core.P) * (1.0 + 0.1 * rng.normal(size=(9, 9))))
    twin = helpers.DenseFilter.of(core)
    H = np.zeros(9, np.float32)
    H[rng.choice(9, size=1 + seed % 3, replace=False)] = 0.7

    lib.kalmanCoreScalarUpdate(core, H.tolist(), 0.1, 0.2)
    twin.scalar_update(H, F(0.1), F(0.2))
    twin.assert_same_as(core)


@pytest.mark.parametrize("h", range(9))
@pytest.mark.parametrize("scale", [1e-20, 1e-4, 1.0, 1e4, 1e10])
def test_update_equals_dense_products_at_extreme_scales(helpers, h, scale):
    core = helpers.random_core(h)
    twin = helpers.DenseFilter.of(core)
    H = np.zeros(9, np.float32)
    H[h] = scale
    lib.kalmanCoreScalarUpdate(core, H.tolist(), 0.1, 0.01)
    twin.scalar_update(H, F(0.1), F(0.01))
    twin.assert_same_as(core)


@given(st.integers(0, 8), moderate, st.floats(0.015625, 10.0, width=32), st.integers(0, 50))
def test_covariance_stays_symmetric_and_the_measured_variance_does_not_grow(helpers, h, error, std_dev, seed):
    core = helpers.random_core(seed)
    before = core.P[h][h]
    H = [0.0] * 9
    H[h] = 1.0
    lib.kalmanCoreScalarUpdate(core, H, error, std_dev)
    P = helpers.array(core.P)
    np.testing.assert_array_equal(P, P.T)
    assert P[h, h] <= before * (1.0 + 1e-5)
    assert core.isUpdated


@pytest.mark.parametrize("std_dev", [math.nan, math.inf, 1e30])
def test_a_lost_variance_becomes_the_largest_one(helpers, std_dev):
    core = helpers.random_core(0)
    H = [1.0] + [0.0] * 8
    lib.kalmanCoreScalarUpdate(core, H, 0.1, std_dev)
    np.testing.assert_array_equal(helpers.array(core.P), np.full((9, 9), 100.0, np.float32))


def test_a_lost_innovation_shows_in_the_state_and_spares_the_covariance(helpers):
    core = helpers.random_core(0)
    sane = ffi.new("kalmanCoreData_t *", core[0])
    H = [1.0] + [0.0] * 8
    lib.kalmanCoreScalarUpdate(core, H, math.nan, 0.1)
    lib.kalmanCoreScalarUpdate(sane, H, 0.1, 0.1)
    assert all(math.isnan(x) for x in core.S)
    np.testing.assert_array_equal(helpers.array(core.P), helpers.array(sane.P))
