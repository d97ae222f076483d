"""Robust models of distance and TDoA (docs/reference/estimators.md#5.10 and #17.H)."""

from collections.abc import Callable

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib

A, B = [2.0, 1.0, 0.2], [-2.0, 1.5, 2.2]


def point(anchor: list[float]) -> dict[str, float]:
    return dict(zip("xyz", anchor, strict=True))


class Distance:
    """One drone's robust model of the distance to A."""

    sigmas = (1.5, 2.0)

    def __init__(self) -> None:
        self.x_err = ffi.new("float[9]")

    def measured(self, distance: float) -> ffi.CData:
        return ffi.new("distanceMeasurement_t *", {"pos": A, "distance": distance, "stdDev": 0.2})

    def predict(self, X: np.ndarray) -> float:
        return float(np.linalg.norm(X[:3] - A))

    def update(self, core: ffi.CData, distance: float) -> None:
        lib.kalmanCoreRobustUpdateWithDistance(core, self.measured(distance), self.x_err)

    def update_plainly(self, core: ffi.CData, distance: float) -> None:
        lib.kalmanCoreUpdateWithDistance(core, self.measured(distance))


class Tdoa:
    """One drone's robust model of the difference of the distances to A and B."""

    sigmas = (2.0, 1.5)

    def __init__(self, a: list[float] = A, b: list[float] = B) -> None:
        self.x_err = ffi.new("float[9]")
        self.filter = ffi.new("OutlierFilterTdoaState_t *")
        self.a, self.b = a, b
        lib.outlierFilterTdoaReset(self.filter)

    def measured(self, difference: float) -> ffi.CData:
        anchors = [point(self.a), point(self.b)]
        return ffi.new("tdoaMeasurement_t *", {"anchorPositions": anchors, "distanceDiff": difference, "stdDev": 0.15})

    def predict(self, X: np.ndarray) -> float:
        return float(np.linalg.norm(X[:3] - self.b) - np.linalg.norm(X[:3] - self.a))

    def update(self, core: ffi.CData, difference: float) -> None:
        lib.kalmanCoreRobustUpdateWithTdoa(core, self.measured(difference), self.filter, self.x_err)

    def update_plainly(self, core: ffi.CData, difference: float) -> None:
        lib.kalmanCoreUpdateWithTdoa(core, self.measured(difference), 1000, self.filter)


MODELS = pytest.mark.parametrize("model", [Distance, Tdoa])


def test_check_vector_h_distance(helpers):
    core, model = helpers.single_update_core(), Distance()
    model.update(core, 2.1)
    helpers.SingleUpdate(
        (0.532418, -0.279079, 1.189318, 0.001621),
        (0.033898, 0.027464, 0.019340, 9.84746e-4),
        (-0.004726, 0.001695),
        tolerance=1e-5,
    ).assert_same_as(core)

    # an outlier after it, which finds what the first one corrected
    model.update(core, 3.1)
    helpers.SingleUpdate(
        (0.530658, -0.280204, 1.189882, 0.001533),
        (0.034924, 0.028123, 0.019565, 9.8731e-4),
        (-0.004898, 0.001746),
        tolerance=1e-5,
    ).assert_same_as(core)


def test_check_vector_h_tdoa(helpers):
    core = helpers.single_update_core()
    Tdoa().update(core, 0.6)
    helpers.SingleUpdate(
        (0.466667, -0.300255, 1.208339, -0.001667),
        (0.037129, 0.030000, 0.019831, 9.92823e-4),
        (-3.7299e-5, 0.001856),
        tolerance=1e-5,
    ).assert_same_as(core)


@MODELS
def test_what_was_corrected_before_weights_the_states(helpers, model):
    fresh, experienced = helpers.single_update_core(), helpers.single_update_core()
    model().update(fresh, 2.0)
    other = model()
    other.x_err[0] = 0.3
    other.update(experienced, 2.0)
    assert fresh.S[0] != experienced.S[0]


@MODELS
def test_a_perfect_measurement_counts_as_much_as_in_the_plain_model(helpers, model):
    robust, plain = helpers.single_update_core(), helpers.single_update_core()
    exact = model().predict(helpers.array(robust.S).astype(float))
    model().update(robust, exact)
    model().update_plainly(plain, exact)
    np.testing.assert_allclose(helpers.array(robust.S), helpers.array(plain.S), atol=1e-6)
    np.testing.assert_allclose(helpers.array(robust.P), helpers.array(plain.P), rtol=1e-5, atol=1e-8)


@MODELS
def test_an_outlier_of_3_m_moves_the_estimate_by_millimeters(helpers, model):
    robust, plain = helpers.single_update_core(), helpers.single_update_core()
    before = helpers.array(robust.S)
    wrong = model().predict(before.astype(float)) + 3.0
    model().update(robust, wrong)
    model().update_plainly(plain, wrong)
    assert 0.0 < np.abs(helpers.array(robust.S) - before).max() < 0.01
    assert np.abs(helpers.array(plain.S) - before).max() > 0.5


def weight(sigma: float, e: np.ndarray) -> np.ndarray:
    return sigma**2 / (sigma + e**2) ** 2


def robust_in_double(
    S: np.ndarray, P: np.ndarray, x_err: np.ndarray, predict: Callable, measured: float, std_dev: float, sigmas: tuple
) -> tuple:
    """Return S, P and x_err after a robust update in float64, with the library's Cholesky factor and inverse."""
    prior, X, R = measured - predict(S), S, std_dev**2
    for _ in range(2):
        L = np.linalg.cholesky(P)
        H = np.array([(predict(X + step) - predict(X - step)) / 2e-6 for step in 1e-6 * np.eye(9)])
        P = L @ np.diag(1.0 / weight(sigmas[1], np.linalg.solve(L, x_err))) @ L.T
        R = R / weight(sigmas[0], (measured - predict(X)) / np.sqrt(R))
        K = P @ H / (H @ P @ H + R)
        x_err = K * prior
        X = S + x_err
    P = (np.eye(9) - np.outer(K, H)) @ P
    return X, (P + P.T) / 2, x_err


@MODELS
@pytest.mark.parametrize("seed", range(20))
def test_robust_update_equals_one_in_double_precision(helpers, model, seed):
    rng = np.random.default_rng(seed)
    core, one = helpers.random_core(seed), model()
    deviation = rng.uniform(0.05, 0.3, size=9)
    mixed = rng.normal(size=(9, 9)) * 0.3
    helpers.assign(core.P, (np.eye(9) + mixed @ mixed.T) * np.outer(deviation, deviation))
    helpers.assign(one.x_err, rng.normal(size=9) * 0.02)
    P, x_err = helpers.array(core.P).astype(float), np.array(list(one.x_err))
    S = helpers.array(core.S).astype(float)
    measured = one.predict(S) + rng.normal() * 0.3
    std_dev = one.measured(measured).stdDev

    expected = robust_in_double(S, P, x_err, one.predict, measured, std_dev, one.sigmas)
    one.update(core, measured)
    np.testing.assert_allclose(helpers.array(core.S), expected[0], atol=2e-5)
    np.testing.assert_allclose(helpers.array(core.P), expected[1], rtol=2e-3, atol=2e-5)
    np.testing.assert_allclose(list(one.x_err), expected[2], atol=2e-5)


def test_at_the_anchor_the_distance_counts_along_x(helpers):
    core, model = helpers.single_update_core(), Distance()
    helpers.assign(core.S, np.array([*A, 0, 0, 0, 0, 0, 0]))
    model.update(core, 0.1)
    assert core.S[0] > A[0]
    assert [core.S[1], core.S[2]] == [np.float32(A[1]), np.float32(A[2])]


def test_at_an_anchor_there_is_no_difference_to_fuse(helpers):
    core, model = helpers.single_update_core(), Tdoa()
    helpers.assign(core.S, np.array([*A, 0, 0, 0, 0, 0, 0]))
    before = ffi.buffer(core)[:]
    model.update(core, 0.1)
    assert ffi.buffer(core)[:] == before
    assert list(model.x_err) == [0.0] * 9


def correction_of_one_meter(std_dev: float) -> float:
    """Return the prior innovation e of a TDoA with H = -2 and P = 100 for which K e = 1."""
    e = -2.0
    for _ in range(50):
        e = -(400.0 + std_dev**2 / weight(2.0, np.array(e / std_dev))) / 200.0
    return float(e)


def test_when_the_first_round_ends_at_an_anchor_it_is_the_last(helpers):
    """Of measurements that correct from the origin to B, 1 m away, some do so to the bit."""
    model = Tdoa(a=[-4.0, 0.0, 0.0], b=[1.0, 0.0, 0.0])
    hits = 0
    for std_dev in np.linspace(1.0, 1.1, 101):
        e = correction_of_one_meter(std_dev)
        core = ffi.new("kalmanCoreData_t *")
        helpers.assign(core.P, np.diag([100.0] + [1e-6] * 8))
        item = model.measured(e - 3.0)
        item.stdDev = std_dev
        model.x_err = ffi.new("float[9]")
        lib.kalmanCoreRobustUpdateWithTdoa(core, item, model.filter, model.x_err)
        if core.S[0] == 1.0:
            # (1 - K H) P of the first round
            assert core.P[0][0] == pytest.approx(100.0 * (1.0 + 2.0 / e), rel=1e-4)
            hits += 1
    assert hits > 0
