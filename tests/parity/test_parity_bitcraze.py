"""The comparison in earnest: a library of the miniature checkout, which follows the firmware's arithmetic."""

import pytest

from crazychoir_fw.onboard.core import load_library
from crazychoir_fw.parity.deviation import Verdict
from crazychoir_fw.parity.run import run_parity
from crazychoir_fw.parity.side import Side


@pytest.fixture(scope="module")
def parity(bitcraze_library, short_inputs, members):
    candidate = Side(load_library(bitcraze_library))
    fleet = members("pid", "mellinger", "brescianini", "lee", "flow", "sweeps", "complementary")
    return run_parity(Side(), candidate, 0.8, inputs=short_inputs, fleet=fleet)


def test_the_miniature_flies_like_builtin(parity):
    assert {flight.verdict for flight in parity.flights} <= {Verdict.IDENTICAL, Verdict.EQUAL}
    assert parity.tables.verdict is Verdict.IDENTICAL


def test_functions_differ_where_it_is_known(parity):
    """The robust model of the firmware has no guard where the root of a clipped covariance does not exist."""
    different = {(item.group, item.name) for item in parity.functions if item.verdict is Verdict.DIFFERENT}
    assert different <= {("kalman", "flight tdoa3_robust")}
    assert not any(item.failures or item.missing_in for item in parity.functions)


def test_the_report_names_the_checkout(parity):
    assert parity.candidate["provider"] == "bitcraze"
    assert parity.candidate["version"] == "2026.08"
    assert "-ffp-contract=off" in parity.candidate["flags"]
