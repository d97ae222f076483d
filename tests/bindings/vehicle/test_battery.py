"""The cell against docs/reference/vehicle.md#6."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.optimize import brentq

from crazychoir_fw._core import ffi, lib

Make = Callable[..., Any]
NEWTON_PER_GRAM = 9.80665e-3

# charge, open-circuit voltage
OPEN_CIRCUIT = [
    (1.00, 4.20),
    (0.9, 4.08),
    (0.8, 3.98),
    (0.7, 3.90),
    (0.6, 3.84),
    (0.5, 3.80),
    (0.4, 3.77),
    (0.3, 3.74),
    (0.2, 3.70),
    (0.1, 3.62),
    (0.05, 3.45),
    (0.0, 3.20),
]


def make_battery(make_config: Make, platform: str = "cf2", **changes: float) -> Any:
    config = make_config(platform).airframe.battery
    for name, value in changes.items():
        setattr(config, name, value)
    battery = ffi.new("cf_battery_t *")
    assert lib.cf_battery_init(battery, ffi.addressof(config)) == lib.CF_OK
    return battery


def feed(battery: Any, thrust: float, ticks: int) -> None:
    for _ in range(ticks):
        lib.cf_battery_step(battery, thrust)


def minutes_to_empty(battery: Any, grams: float) -> float:
    ticks = 0
    while battery.charge > 0.0:
        feed(battery, grams * NEWTON_PER_GRAM, 100)
        ticks += 100
    return ticks / 60_000


@pytest.mark.parametrize(("charge", "voltage"), OPEN_CIRCUIT)
def test_open_circuit_voltage_follows_the_table(charge: float, voltage: float) -> None:
    assert lib.cf_open_circuit_voltage(charge) == pytest.approx(voltage, abs=2e-6)


def test_open_circuit_voltage_is_a_line_between_the_rows() -> None:
    charges, voltages = zip(*reversed(OPEN_CIRCUIT), strict=True)
    for charge in np.linspace(0, 1, 333):
        assert lib.cf_open_circuit_voltage(charge) == pytest.approx(np.interp(charge, charges, voltages), abs=2e-6)


@pytest.mark.parametrize(
    ("charge", "voltage"), [(1.5, 4.2), (-0.02, 2.8), (-0.05, 2.2), (-0.1, 2.2), (-5.0, 2.2), (np.nan, 2.2)]
)
def test_open_circuit_voltage_beyond_the_table(charge: float, voltage: float) -> None:
    assert lib.cf_open_circuit_voltage(charge) == pytest.approx(voltage, abs=1e-5)


@pytest.mark.parametrize(
    ("platform", "grams", "power"), [("cf2", 29.0, 7.88), ("cf2", 0.0, 1.10), ("cf21bl", 34.5, 1.1 + 0.193 * 34.5)]
)
def test_power_is_linear_in_thrust(make_config: Make, platform: str, grams: float, power: float) -> None:
    battery = make_battery(make_config, platform, constant_voltage=4.0)
    feed(battery, grams * NEWTON_PER_GRAM, 1)
    assert battery.current * 4.0 == pytest.approx(power, rel=1e-3)


def test_current_at_29_grams_is_that_of_the_bench(make_config: Make) -> None:
    """docs/reference/vehicle.md#3: 2.14 A at 3.67 V."""
    battery = make_battery(make_config, constant_voltage=3.67)
    feed(battery, 29.0 * NEWTON_PER_GRAM, 1)
    assert battery.current == pytest.approx(2.14, rel=0.01)


def settled_voltage(power: float, open_circuit: float, resistance: float) -> float:
    """Return the terminal voltage that solves V = OCV - R P / V."""
    return brentq(lambda v: open_circuit - resistance * power / v - v, open_circuit / 2, open_circuit)


def test_voltage_sags_at_once_under_load(make_config: Make) -> None:
    battery = make_battery(make_config)
    feed(battery, 29.0 * NEWTON_PER_GRAM, 20)
    assert battery.voltage == pytest.approx(settled_voltage(7.88, 4.2, 0.20), abs=0.002)


@pytest.mark.parametrize(("resistance", "sag"), [(0.16, 0.34)])
def test_hover_sag_over_the_path_of_the_bench(make_config: Make, resistance: float, sag: float) -> None:
    battery = make_battery(make_config, resistance=resistance, slow_resistance=0.0)
    feed(battery, 29.0 * NEWTON_PER_GRAM, 50)
    assert 4.2 - battery.voltage == pytest.approx(sag, rel=0.05)


def test_take_off_sag_of_a_heavy_vehicle(make_config: Make) -> None:
    """NANO: 0.41 to 0.67 V at 40.85 g, about 11.5 W."""
    battery = make_battery(make_config)
    feed(battery, (11.5 - 1.10) / 0.2337 * NEWTON_PER_GRAM, 50)
    assert 0.41 < 4.2 - battery.voltage < 0.67


def test_slow_sag_builds_up_with_its_time_constant(make_config: Make) -> None:
    battery = make_battery(make_config, resistance=0.0, slow_resistance=0.06, capacity=1e6)
    feed(battery, 29.0 * NEWTON_PER_GRAM, 10_000)
    expected = battery.current * 0.06 * (1 - np.exp(-1))
    assert battery.slow_sag == pytest.approx(expected, rel=0.02)
    assert battery.voltage == pytest.approx(4.2 - battery.slow_sag, abs=1e-3)


def test_voltage_recovers_after_landing(make_config: Make) -> None:
    battery = make_battery(make_config)
    feed(battery, 29.0 * NEWTON_PER_GRAM, 2000)
    sagged = battery.voltage
    feed(battery, 0.0, 20)
    assert battery.voltage > sagged + 0.3


def test_charge_is_the_integral_of_the_current(make_config: Make) -> None:
    battery = make_battery(make_config)
    coulombs = 0.0
    for _ in range(60_000):
        lib.cf_battery_step(battery, 0.2845)
        coulombs += battery.current * 0.001
    assert battery.charge == pytest.approx(1 - coulombs / 900.0, abs=2e-5)


def test_hover_lasts_ten_minutes_on_the_brushless(make_config: Make) -> None:
    """docs/reference/vehicle.md#14.4: 10 +- 1 min; the power law was fitted at 34.5 g."""
    assert minutes_to_empty(make_battery(make_config, "cf21bl"), 34.5) == pytest.approx(10.0, abs=1.0)


def test_hover_lasts_seven_minutes_on_a_cell_without_resistance(make_config: Make) -> None:
    """docs/reference/vehicle.md#14.4: 7 +- 0.5 min, computed there from nominal energy over power."""
    battery = make_battery(make_config, resistance=0.0, slow_resistance=0.0)
    assert minutes_to_empty(battery, 29.0) == pytest.approx(7.0, abs=0.5)


def test_hover_time_with_sag_is_what_the_equations_say(make_config: Make) -> None:
    """The recommended 0.22 Ohm turns 1.2 W into heat: 6.3 min instead of 7."""
    charges, voltages = (np.array(x) for x in zip(*reversed(OPEN_CIRCUIT), strict=True))
    grid = np.linspace(0, 1, 2001)
    current = [7.877 / settled_voltage(7.877, u, 0.22) for u in np.interp(grid, charges, voltages)]
    expected = trapezoid(1 / np.array(current), grid) * 900 / 60
    assert minutes_to_empty(make_battery(make_config), 29.0) == pytest.approx(expected, rel=0.01)


def test_exhausted_cell_collapses_but_stays_finite(make_config: Make) -> None:
    battery = make_battery(make_config, initial_charge=0.0)
    feed(battery, 0.28, 400_000)
    assert battery.charge == pytest.approx(-0.05)
    assert 0.5 <= battery.voltage < 2.2
    assert np.isfinite(battery.current)


def test_a_drone_is_down_before_its_pack_gives_more_than_its_capacity(make_config: Make) -> None:
    """At 3.0 V, where a flight ends, there is charge left; 2.4 V, with which full duty just hovers, come soon after."""
    battery = make_battery(make_config)
    left = {}
    for volts in (3.0, 2.4):
        while battery.voltage > volts:
            feed(battery, 29.0 * NEWTON_PER_GRAM, 10)
        left[volts] = battery.charge
    assert 0.05 < left[3.0] < 0.12
    assert -0.05 < left[2.4] < 0.05


def test_overload_keeps_voltage_and_current_finite(make_config: Make) -> None:
    battery = make_battery(make_config)
    feed(battery, 1e6, 1000)
    assert battery.voltage == 0.5
    assert np.isfinite(battery.current)


def test_initial_charge_sets_the_voltage(make_config: Make) -> None:
    battery = make_battery(make_config, initial_charge=0.5)
    assert battery.charge == pytest.approx(0.5)
    assert battery.voltage == pytest.approx(3.80 - 1.1 / 3.80 * 0.20, abs=1e-4)


def test_bench_supply_neither_sags_nor_empties(make_config: Make) -> None:
    battery = make_battery(make_config, constant_voltage=4.0)
    feed(battery, 0.4, 5000)
    assert battery.voltage == 4.0
    assert battery.charge == 1.0


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("capacity", 0.0),
        ("capacity", float("nan")),
        ("resistance", -0.1),
        ("slow_resistance", float("inf")),
        ("slow_time", 0.0),
        ("base_power", -1.0),
        ("power_per_thrust", float("nan")),
        ("initial_charge", 1.1),
        ("initial_charge", -0.1),
        ("constant_voltage", -1.0),
        ("constant_voltage", 21.0),
    ],
)
def test_impossible_config_is_refused(make_config: Make, name: str, value: float) -> None:
    config = make_config("cf2").airframe.battery
    setattr(config, name, value)
    battery = ffi.new("cf_battery_t *")
    assert lib.cf_battery_init(battery, ffi.addressof(config)) == lib.CF_ERR_VALUE
    assert bytes(ffi.buffer(battery)) == bytes(ffi.sizeof("cf_battery_t"))
