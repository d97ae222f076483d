"""Intervals, tests and indices against closed forms and against what they promise."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom

from crazychoir_fw.campaign.compare import mcnemar
from crazychoir_fw.campaign.design import shares
from crazychoir_fw.campaign.verdict import SequentialTest, clopper_pearson, least_flights


@pytest.mark.parametrize(  # Clopper and Pearson, closed forms at the ends and published values between
    ("passed", "flown", "low", "high"),
    [
        (0, 10, 0.0, 1.0 - 0.025 ** (1 / 10)),
        (10, 10, 0.025 ** (1 / 10), 1.0),
        (5, 10, 0.1871, 0.8129),
        (81, 263, 0.2527, 0.3676),
    ],
)
def test_interval(passed, flown, low, high):
    assert clopper_pearson(passed, flown, 0.95) == pytest.approx((low, high), abs=1e-4)


@pytest.mark.parametrize("p", [0.01, 0.3, 0.5, 0.9, 0.99])
@pytest.mark.parametrize("flown", [5, 20, 100])
def test_the_interval_covers_at_least_as_often_as_it_says(p, flown):
    ends = np.array([clopper_pearson(k, flown, 0.9) for k in range(flown + 1)])
    covers = (ends[:, 0] <= p) & (p <= ends[:, 1])
    assert binom.pmf(np.flatnonzero(covers), flown, p).sum() >= 0.9 - 1e-12


@given(st.floats(0.5, 0.999), st.floats(0.5, 0.999))
def test_so_many_flights_without_failure_prove_it_and_one_less_does_not(success, confidence):
    needed = least_flights(success, confidence)
    assert clopper_pearson(needed, needed, confidence, sides=1)[0] >= success - 1e-9
    if needed > 1:
        assert clopper_pearson(needed - 1, needed - 1, confidence, sides=1)[0] < success + 1e-9


@pytest.mark.parametrize(("p", "wrong"), [(0.97, False), (0.93, True)])
def test_errors_of_the_sequential_test_in_ten_thousand_campaigns(p, wrong):
    test = SequentialTest(good=0.97, bad=0.93, error=0.05)
    outcomes = np.random.default_rng(7).random((10_000, 2_000)) < p
    steps = np.where(outcomes, np.log(test.good / test.bad), np.log((1 - test.good) / (1 - test.bad)))
    ratio, bound = np.cumsum(steps, axis=1), np.log(0.95 / 0.05)
    first = (np.abs(ratio) >= bound).argmax(axis=1)
    answers = ratio[np.arange(10_000), first] > 0  # GO
    assert (answers == wrong).mean() <= 0.05
    chosen = np.flatnonzero(np.abs(ratio).max(axis=1) >= bound)[:50]
    for k in chosen:  # the same answers as ours
        assert (test.answer(outcomes[k]) == "GO") == answers[k]
        assert test.first(outcomes[k]) == first[k]


@pytest.mark.parametrize(("broken", "mended", "p"), [(0, 0, 1.0), (5, 0, 2 / 32), (0, 6, 2 / 64), (3, 3, 1.0)])
def test_changes_of_verdicts(broken, mended, p):
    assert mcnemar(broken, mended) == pytest.approx(p)


@pytest.mark.parametrize("design", ["latin_hypercube", "sobol"])
def test_designs_fill_every_slice(design):
    found = shares(design, 64, 3, 5)
    for column in found.T:
        assert sorted(np.floor(column * 64).astype(int)) == list(range(64))


def test_a_longer_monte_carlo_campaign_begins_with_the_same_flights():
    np.testing.assert_array_equal(shares("monte_carlo", 5, 4, 1), shares("monte_carlo", 9, 4, 1)[:5])


def test_sobol_indices_of_a_known_function():
    """Ishigami's function with a = 7, b = 0.1: S1 = 0.3139, 0.4424, 0; ST = 0.5576, 0.4424, 0.2437."""
    from SALib.analyze import sobol

    from crazychoir_fw.campaign.design import share_problem

    x = (2.0 * shares("saltelli", 8 * 2048, 3, 1) - 1.0) * np.pi
    y = np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])
    found = sobol.analyze(share_problem(3), y, seed=0)
    np.testing.assert_allclose(found["S1"], [0.3139, 0.4424, 0.0], atol=0.02)
    np.testing.assert_allclose(found["ST"], [0.5576, 0.4424, 0.2437], atol=0.02)
