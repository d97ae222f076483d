"""Thrust to duty (docs/reference/control-pid.md#14)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

CURVES = {
    "cf2": lib.cf_platform_facts(lib.CF_PLATFORM_CF2).thrust,
    "cf21bl": lib.cf_platform_facts(lib.CF_PLATFORM_CF21BL).thrust,
    # the other propellers of the table in docs/reference/control-pid.md#12
    "kit": ffi.new(
        "cf_thrust_curve_t *",
        {
            "c0": 0.006728127583707208,
            "c1": 0.01011557616217668,
            "c2": 0.010263198062061085,
            "c3": 0.0028358638322392503,
            "thrust_min": 0.01922636758983749,
            "thrust_max": 0.18,
        },
    )[0],
    "legacy": ffi.new(
        "cf_thrust_curve_t *",
        {
            "c0": -0.014830744918356092,
            "c1": 0.04724465241828281,
            "c2": -0.01847364358025878,
            "c3": 0.005960923942142,
            "thrust_min": 0.012817578393224994,
            "thrust_max": 0.12,
        },
    )[0],
}
COMMANDS = (0, 7000, 10000, 20000, 30000, 36000, 50000, 65535)
DUTIES = {
    ("cf2", 4.2): (0, 12075, 14571, 23883, 32053, 35861, 42601, 48057),
    ("cf2", 3.7): (0, 13707, 16540, 27111, 36384, 40708, 48358, 54551),
    ("kit", 4.2): (0, 10600, 14585, 23500, 29637, 32660, 38577, 43948),
    ("legacy", 4.2): (0, 11750, 14724, 24378, 31715, 35128, 41346, 46555),
    ("cf21bl", 4.2): (0, 12190, 15015, 23417, 30472, 34193, 41747, 48771),
    ("cf21bl", 3.7): (0, 13837, 17044, 26581, 34590, 38814, 47389, 55362),
}
TABLE = [
    (name, supply, command, duty)
    for (name, supply), duties in DUTIES.items()
    for command, duty in zip(COMMANDS, duties, strict=True)
]
curves = st.sampled_from([CURVES["cf2"], CURVES["cf21bl"]])


def address(curve):
    return ffi.addressof(curve)


@pytest.mark.parametrize(("name", "supply", "command", "duty"), TABLE)
def test_duty_matches_the_table(name, supply, command, duty):
    assert lib.cf_battery_compensate(address(CURVES[name]), command, supply) == pytest.approx(duty, abs=2, rel=0)


@pytest.mark.parametrize(
    ("name", "voltage"), [("cf2", 3.0799), ("kit", 2.8166), ("legacy", 2.9836), ("cf21bl", 3.1257)]
)
def test_full_thrust_needs_the_voltage_of_the_table(name, voltage):
    assert lib.cf_battery_motor_voltage(address(CURVES[name]), 65535) == pytest.approx(voltage, abs=1e-4)


@given(curve=curves, command=st.floats(13000, 65535, width=32))
def test_the_motor_voltage_solves_the_cubic(curve, command):
    voltage = lib.cf_battery_motor_voltage(address(curve), command)
    force = np.polyval([curve.c3, curve.c2, curve.c1, curve.c0], voltage)
    assert force == pytest.approx(command / 65535 * curve.thrust_max, rel=1e-4)


@given(curve=curves, lower=st.integers(0, 65535), higher=st.integers(0, 65535))
def test_more_thrust_never_needs_less_duty(curve, lower, higher):
    lower, higher = sorted((lower, higher))
    duties = [lib.cf_battery_compensate(address(curve), command, 3.9) for command in (lower, higher)]
    assert duties[0] <= duties[1] * (1 + 1e-6)


@given(curve=curves, command=st.floats(-1e6, 1e6, width=32), supply=st.floats(2, 5, width=32))
def test_the_two_halves_make_the_whole(curve, command, supply):
    voltage = lib.cf_battery_motor_voltage(address(curve), command)
    assert lib.cf_battery_duty(voltage, supply) == lib.cf_battery_compensate(address(curve), command, supply)


@pytest.mark.parametrize("command", [-65535.0, -1.0, 0.0, 6990.0])
def test_less_than_the_least_thrust_is_off(command):
    assert lib.cf_battery_compensate(address(CURVES["cf2"]), command, 4.0) == 0.0


@pytest.mark.parametrize("supply", [1.999, 0.0, -4.0, math.nan])
def test_a_dead_supply_is_off(supply):
    assert lib.cf_battery_compensate(address(CURVES["cf2"]), 30000.0, supply) == 0.0
    assert lib.cf_battery_duty(3.0, supply) == 0.0


def test_a_weak_supply_asks_for_more_than_there_is():
    assert lib.cf_battery_compensate(address(CURVES["cf2"]), 65535.0, 3.0) > 65535.0
