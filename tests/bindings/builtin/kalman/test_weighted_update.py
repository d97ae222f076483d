"""The end of a robust update (docs/reference/estimators.md#4.7)."""

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib

F = np.float32


@pytest.mark.parametrize("seed", range(10))
def test_weighted_update_equals_dense_products(helpers, seed):
    rng = np.random.default_rng(seed)
    core = helpers.random_core(seed)
    core.isUpdated = False
    S, error = helpers.array(core.S), F(rng.normal())
    H, K = rng.normal(size=(2, 9)).astype(F)
    weighted = rng.normal(size=(9, 9)).astype(F)
    lib.kalmanCoreUpdateWithPKE(core, H.tolist(), K.tolist(), ffi.new("float[9][9]", weighted.tolist()), error)

    N = F(-1.0) * np.outer(K, H)
    N[np.diag_indices(9)] = F(1.0) + np.diagonal(N)
    np.testing.assert_array_equal(helpers.array(core.S), S + K * error)
    np.testing.assert_array_equal(helpers.array(core.P), helpers.bounded(helpers.product(N, weighted)))
    assert core.isUpdated
    assert core.settled == 1
