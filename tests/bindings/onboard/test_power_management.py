"""State and level of the battery, as clients see them (docs/reference/control-pid.md#12)."""

import pytest

from crazychoir_fw._core import ffi, lib

CF2, CF21BL = lib.CF_PLATFORM_CF2, lib.CF_PLATFORM_CF21BL


def new_power(platform=CF2):
    power = ffi.new("cf_power_management_t *")
    lib.cf_power_management_init(power, platform)
    return power


@pytest.mark.parametrize(("platform", "limit"), [(CF2, 3.2), (CF21BL, 3.35)])
def test_battery_is_low_after_five_seconds_below_the_limit(platform, limit):
    power = new_power(platform)
    assert power.low_voltage == pytest.approx(limit)
    states = {}
    for tick in range(40, 12000, 40):
        lib.cf_power_management_measure(power, limit + 0.1 if tick <= 4000 else limit - 0.01)
        lib.cf_power_management_update(power, tick)
        states[tick] = power.state
    assert states[9000] == lib.CF_POWER_BATTERY
    assert states[9040] == lib.CF_POWER_LOW


def test_a_short_dip_is_not_low():
    power = new_power()
    for tick in range(40, 20000, 40):
        lib.cf_power_management_measure(power, 2.9 if tick % 4000 else 3.9)
        lib.cf_power_management_update(power, tick)
        assert power.state == lib.CF_POWER_BATTERY


@pytest.mark.parametrize(
    ("voltage", "level"),
    [(4.2, 100), (4.19, 90), (3.98, 80), (3.8, 50), (3.79, 40), (3.62, 10), (3.61, 0), (0.0, 0), (9.0, 100)],
)
def test_level_follows_the_curve_of_a_cell(voltage, level):
    power = new_power()
    lib.cf_power_management_measure(power, voltage)
    lib.cf_power_management_update(power, 40)
    assert power.level == level
    assert power.millivolt == pytest.approx(1000 * voltage, abs=1)
