"""Every parameter and log variable has a description and, if it is a quantity, a unit."""

import pytest

from crazychoir_fw.onboard.descriptions import describe_variable
from crazychoir_fw.onboard.variables import log_table, parameter_table

TABLES = {"parameters": parameter_table, "logs": log_table}


@pytest.mark.parametrize("kind", TABLES)
def test_all_variables_are_described(kind):
    assert [name for name in TABLES[kind]() if not describe_variable(name, kind).text] == []


@pytest.mark.parametrize(
    ("name", "kind", "unit"),
    [
        ("stateEstimate.z", "logs", "m"),
        ("stateEstimate.vx", "logs", "m/s"),
        ("stateEstimate.az", "logs", "g"),
        ("gyro.x", "logs", "deg/s"),
        ("pm.vbat", "logs", "V"),
        ("pid_rate.roll_kp", "parameters", "1/(deg/s)"),
        ("velCtlPid.vxKp", "parameters", "deg/(m/s)"),
        ("posCtlPid.xVelMax", "parameters", "m/s"),
        ("myApp.gain", "parameters", ""),
    ],
)
def test_units(name, kind, unit):
    assert describe_variable(name, kind).unit == unit
