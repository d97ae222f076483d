"""Tables of parameters and log variables, and factory values."""

from dataclasses import replace

import numpy as np

from crazychoir_fw.parity.deviation import Verdict
from crazychoir_fw.parity.side import Side
from crazychoir_fw.parity.tables import compare_tables


def differences(reference, candidate):
    return {(row.kind, row.name, row.what): row for row in compare_tables(reference, candidate).differences}


def test_tables_of_one_provider_are_identical():
    tables = compare_tables(Side(), Side())
    assert tables.verdict is Verdict.IDENTICAL
    assert tables.differences == []
    assert tables.parameters > 150
    assert tables.logs > 200


def test_a_variable_on_one_side_is_missing_and_has_no_say():
    poor = Side()
    del poor.parameter_table["colAv.enable"]
    del poor.log_table["kalman.varX"]
    found = differences(Side(), poor)
    assert set(found) == {
        ("parameter", "colAv.enable", "missing"),
        ("log variable", "kalman.varX", "missing"),
    }
    assert found["parameter", "colAv.enable", "missing"].candidate is None
    assert compare_tables(Side(), poor).verdict is Verdict.IDENTICAL
    assert differences(poor, Side())["log variable", "kalman.varX", "missing"].reference is None


def test_another_type_is_different_and_another_flag_is_told():
    other = Side()
    variable = other.log_table["kalman.varX"]
    other.log_table["kalman.varX"] = replace(variable, dtype=np.dtype(np.uint32))
    other.log_table["kalman.varY"] = replace(other.log_table["kalman.varY"], is_core=True)
    found = differences(Side(), other)
    row = found["log variable", "kalman.varX", "type"]
    assert (row.reference, row.candidate, row.verdict) == ("float32", "uint32", Verdict.DIFFERENT)
    assert found["log variable", "kalman.varY", "flags"].verdict is Verdict.NOT_JUDGED


def test_factory_values_of_another_platform_are_told_with_their_distance():
    found = differences(Side(), Side(platform="cf21bl"))
    assert {what for _, _, what in found} == {"factory value"}
    row = found["parameter", "pid_rate.roll_kp", "factory value"]
    assert (row.reference, row.candidate) == (250.0, 200.0)
    assert row.ulps > 1_000_000
    assert row.verdict is Verdict.DIFFERENT
