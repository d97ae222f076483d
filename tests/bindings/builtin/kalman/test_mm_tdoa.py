"""Difference of the distances to two anchors.

docs/reference/estimators.md#5.9, #16.2 and #17.H, docs/reference/cffirmware-api.md#10.12.
"""

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib


def measured(a: list[float], b: list[float], difference: float, std_dev: float) -> ffi.CData:
    anchors = [dict(zip("xyz", map(float, anchor), strict=True)) for anchor in (a, b)]
    return ffi.new("tdoaMeasurement_t *", {"anchorPositions": anchors, "distanceDiff": difference, "stdDev": std_dev})


@pytest.fixture
def outlier_filter():
    state = ffi.new("OutlierFilterTdoaState_t *")
    lib.outlierFilterTdoaReset(state)
    return state


def core_at(helpers, x: float, y: float, z: float) -> ffi.CData:
    core = ffi.new("kalmanCoreData_t *", {"S": [x, y, z]})
    helpers.assign(core.P, np.eye(9))
    return core


def test_check_vector_h(helpers, outlier_filter):
    core = helpers.single_update_core()
    item = measured([2, 1, 0.2], [-2, 1.5, 2.2], 0.6, 0.15)
    assert lib.cf_mm_tdoa_update(core, item, 1000, outlier_filter) == pytest.approx(-0.416216016, rel=1e-6)
    helpers.SingleUpdate(
        (0.29546389, -0.303089857, 1.25362873, -0.0102268066),
        (0.0115613109, 0.0299935117, 0.0180449188, 9.2890329e-4),
        (-4.29610838e-4, 5.78065519e-4),
    ).assert_same_as(core)


def test_check_vector_h_has_this_derivative(helpers, outlier_filter):
    core, twin = helpers.single_update_core(), helpers.single_update_core()
    item = measured([2, 1, 0.2], [-2, 1.5, 2.2], 0.6, 0.15)
    lib.kalmanCoreUpdateWithTdoa(core, item, 1000, outlier_filter)
    H = [1.44676638, 0.0291408896, -0.758675098, 0, 0, 0, 0, 0, 0]
    lib.kalmanCoreScalarUpdate(twin, H, -0.416216016, 0.15)
    np.testing.assert_allclose(helpers.array(core.S), helpers.array(twin.S), rtol=1e-6)
    np.testing.assert_allclose(helpers.array(core.P), helpers.array(twin.P), rtol=1e-5, atol=1e-10)


def test_between_two_anchors_only_the_way_along_them_counts(helpers, outlier_filter):
    """One scalar update with H = (-2, 0, 0), no innovation and the deviation of the measurement.

    docs/reference/estimators.md#16.2.
    """
    core, twin = core_at(helpers, 0, 0, 0), core_at(helpers, 0, 0, 0)
    lib.kalmanCoreUpdateWithTdoa(core, measured([-1, 0, 0], [1, 0, 0], 0.0, 0.123), 1000, outlier_filter)
    lib.kalmanCoreScalarUpdate(twin, [-2, 0, 0, 0, 0, 0, 0, 0, 0], 0.0, 0.123)
    assert ffi.buffer(core)[:] == ffi.buffer(twin)[:]


@pytest.mark.parametrize("x", [-1.0, 1.0])
def test_at_an_anchor_there_is_no_update(helpers, outlier_filter, x):
    """docs/reference/estimators.md#16.2; the outlier filter is not even asked."""
    core = core_at(helpers, x, 0, 0)
    before = ffi.buffer(core)[:], ffi.buffer(outlier_filter)[:]
    lib.kalmanCoreUpdateWithTdoa(core, measured([-1, 0, 0], [1, 0, 0], 2.0, 0.123), 1000, outlier_filter)
    assert (ffi.buffer(core)[:], ffi.buffer(outlier_filter)[:]) == before


def test_what_the_filter_refuses_is_not_fused_but_told(helpers, outlier_filter):
    core = core_at(helpers, 0, 0, 0)
    outlier_filter.isFilterOpen, outlier_filter.integrator, outlier_filter.latestUpdateMs = False, 300.0, 999
    before = ffi.buffer(core)[:]
    item = measured([-1, 0, 0], [1, 0, 0], 1.5, 0.123)
    assert lib.cf_mm_tdoa_update(core, item, 1000, outlier_filter) == 1.5
    assert ffi.buffer(core)[:] == before
    assert outlier_filter.integrator == 299.0


def test_innovation_is_measured_minus_predicted(helpers, params, outlier_filter):
    """docs/reference/cffirmware-api.md#10.12."""
    core = ffi.new("kalmanCoreData_t *")
    lib.kalmanCoreInit(core, params, 0)
    item = measured([1, 0, 0], [-1, 0, 0], 0.25, 0.15)
    assert lib.cf_mm_tdoa_update(core, item, 0, outlier_filter) == pytest.approx(0.25, abs=1e-6)
    assert list(core.S)[:3] != [0.0, 0.0, 0.0]


@pytest.mark.parametrize("seed", range(20))
def test_tdoa_is_an_update_with_the_derivative_of_the_difference(helpers, outlier_filter, seed):
    rng = np.random.default_rng(seed)
    core = helpers.random_core(seed)
    a, b = rng.normal(size=(2, 3)) * 3.0

    def predict(X: np.ndarray) -> float:
        return float(np.linalg.norm(X[:3] - b) - np.linalg.norm(X[:3] - a))

    difference = 0.9 * predict(helpers.array(core.S).astype(float))
    S, P = helpers.updated_in_double(core, predict, difference, 0.15)
    lib.kalmanCoreUpdateWithTdoa(core, measured(a.tolist(), b.tolist(), difference, 0.15), 1000, outlier_filter)
    np.testing.assert_allclose(helpers.array(core.S), S, rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(helpers.array(core.P), P, rtol=1e-3, atol=1e-5)
