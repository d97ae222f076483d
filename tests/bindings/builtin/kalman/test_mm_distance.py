"""Distance to an anchor (docs/reference/estimators.md#5.4 and #17.H)."""

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib


def measured(anchor: list[float], distance: float, std_dev: float) -> ffi.CData:
    return ffi.new("distanceMeasurement_t *", {"pos": anchor, "distance": distance, "stdDev": std_dev})


def test_check_vector_h(helpers):
    core = helpers.single_update_core()
    lib.kalmanCoreUpdateWithDistance(core, measured([2, 1, 0.2], 2.1, 0.2))
    helpers.SingleUpdate(
        (0.545634925, -0.270337313, 1.18478835, 0.00228174706),
        (0.029952554, 0.0257549528, 0.0188836157, 9.74881405e-4),
        (-0.00653083902, 0.00149762782),
    ).assert_same_as(core)


def test_check_vector_h_has_this_derivative_and_innovation(helpers):
    core, twin = helpers.single_update_core(), helpers.single_update_core()
    lib.kalmanCoreUpdateWithDistance(core, measured([2, 1, 0.2], 2.1, 0.2))
    H = [-0.674881935, -0.584897637, 0.44992131, 0, 0, 0, 0, 0, 0]
    lib.kalmanCoreScalarUpdate(twin, H, -0.122611046, 0.2)
    np.testing.assert_allclose(helpers.array(core.S), helpers.array(twin.S), rtol=1e-6)
    np.testing.assert_allclose(helpers.array(core.P), helpers.array(twin.P), rtol=1e-5, atol=1e-10)


@pytest.mark.parametrize("seed", range(20))
def test_distance_is_an_update_with_the_derivative_of_the_distance(helpers, seed):
    rng = np.random.default_rng(seed)
    core = helpers.random_core(seed)
    anchor = rng.normal(size=3) * 3.0
    distance = np.linalg.norm(helpers.array(core.S)[:3] - anchor) + rng.normal() * 0.2
    S, P = helpers.updated_in_double(core, lambda X: np.linalg.norm(X[:3] - anchor), distance, 0.25)
    lib.kalmanCoreUpdateWithDistance(core, measured(anchor.tolist(), distance, 0.25))
    np.testing.assert_allclose(helpers.array(core.S), S, rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(helpers.array(core.P), P, rtol=1e-3, atol=1e-5)


def test_at_the_anchor_the_distance_counts_along_x(helpers):
    core, twin = helpers.single_update_core(), helpers.single_update_core()
    lib.kalmanCoreUpdateWithDistance(core, measured(list(core.S)[:3], 0.25, 0.5))
    lib.kalmanCoreScalarUpdate(twin, [1, 0, 0, 0, 0, 0, 0, 0, 0], 0.25, 0.5)
    assert ffi.buffer(core)[:] == ffi.buffer(twin)[:]
