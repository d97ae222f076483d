"""The barometer against docs/reference/estimators.md#12.1 and #12.8 and docs/reference/vehicle.md#10."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from sensor_parts import changed, dice

from crazychoir_fw._core import ffi, lib

Make = Callable[..., Any]

STEP = 0.0055  # m, what the last bit of 1 + h / 45869 m stands for in float32

# pressure (mbar), height above sea level (m): docs/reference/estimators.md#12.8
HEIGHTS = [(1015.7, 0.0), (1013.25, 21.0815), (1000.0, 136.154)]


def make_barometer(make_config: Make, seed: int = 1, **changes: float) -> Any:
    config = changed(make_config("cf2").barometer, changes)
    barometer = ffi.new("cf_barometer_t *")
    assert lib.cf_barometer_init(barometer, config, dice(seed)[0]) == lib.CF_OK
    return barometer


def watch(
    barometer: Any, ticks: int, height: float = 0.0, vibration: float = 0.0, surface: float = 0.0
) -> tuple[list[int], np.ndarray]:
    """Return the ticks of the samples and their pressures (Pa)."""
    pressure, temperature = ffi.new("float *"), ffi.new("float *")
    when, samples = [], []
    for tick in range(1, ticks + 1):
        if lib.cf_barometer_step(barometer, height, surface, vibration, pressure, temperature):
            assert temperature[0] == 25.0
            when.append(tick)
            samples.append(pressure[0])
    return when, np.array(samples)


def height_of(pressure: np.ndarray) -> np.ndarray:
    """Height above sea level (m) of pressures (Pa), as the onboard software counts."""
    return ((101570.0 / pressure) ** 0.1902630958 - 1) * 298.15 / 0.0065


@pytest.mark.parametrize(("mbar", "asl"), HEIGHTS)
def test_pressure_is_that_of_the_onboard_atmosphere(mbar, asl):
    assert lib.cf_pressure_at(asl) == pytest.approx(100 * mbar, rel=1e-6)


def test_samples_come_at_50_hz(make_config):
    when, _ = watch(make_barometer(make_config), 1000)
    assert when == list(range(20, 1001, 20))


@pytest.mark.parametrize(("altitude", "height"), [(0.0, 0.0), (0.0, 1.5), (430.0, -2.0), (-400.0, 10.0)])
def test_ideal_sensor_gives_the_height(make_config, altitude, height):
    _, pressures = watch(make_barometer(make_config, altitude=altitude, noise_scale=0.0), 100, height)
    np.testing.assert_allclose(height_of(pressures), altitude + height, atol=STEP)


def test_noise_is_white(make_config):
    _, pressures = watch(make_barometer(make_config, drift=0.0), 100_000)
    heights = height_of(pressures)
    assert np.std(heights) == pytest.approx(0.15, rel=0.05)
    assert abs(np.mean(heights)) < 0.01
    assert abs(np.corrcoef(heights[1:], heights[:-1])[0, 1]) < 0.05


def test_drift_wanders_within_minutes(make_config):
    """A first-order process: 0.3 m over 120 s, hardly anything within a second."""
    ends, steps = [], []
    for seed in range(60):
        _, pressures = watch(make_barometer(make_config, seed=seed, noise=0.0), 120_000)
        heights = height_of(pressures)
        ends.append(heights[-1])
        steps.append(heights[1000] - heights[950])
    # what has grown after one time constant: 0.3 sqrt(1 - exp(-2))
    assert np.std(ends) == pytest.approx(0.279, rel=0.3)
    assert np.std(steps) == pytest.approx(0.3 * np.sqrt(2 * (1 - np.exp(-1 / 120))), rel=0.35)


def test_scale_multiplies_noise_and_drift(make_config):
    _, once = watch(make_barometer(make_config, noise_scale=1.0), 2000)
    _, twice = watch(make_barometer(make_config, noise_scale=2.0), 2000)
    np.testing.assert_allclose(height_of(twice), 2 * height_of(once), atol=2 * STEP)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("altitude", value) for value in (-501.0, 9001.0, np.nan)),
        *(("noise", value) for value in (-0.1, np.nan, np.inf)),
        *(("drift", value) for value in (-0.1, np.nan, np.inf)),
        *(("noise_scale", value) for value in (-0.1, 101.0, np.nan)),
    ],
)
def test_numbers_outside_their_range_are_refused(make_config, name, value):
    config = ffi.new("cf_vehicle_config_t *", make_config("cf2")[0])
    setattr(config.barometer, name, value)
    vehicle = ffi.new("cf_vehicle_t *")
    assert lib.cf_vehicle_init(vehicle, config, 1, 0) == lib.CF_ERR_VALUE


def test_the_vehicle_carries_one(make_vehicle):
    vehicle = make_vehicle()
    pressure, temperature = ffi.new("float *"), ffi.new("float *")
    samples = [lib.cf_vehicle_barometer(vehicle, 0.0, pressure, temperature) for _ in range(40)]
    assert samples.count(True) == 2


# ---------------------------------------------------------------- wash of the propellers


def shifts(make_config: Make, vibration: float, height: float, count: int = 40) -> np.ndarray:
    """Return what turning rotors add to the height (m) that `count` drones read, otherwise ideal."""
    quiet = {"noise": 0.0, "drift": 0.0}
    found = []
    for seed in range(count):
        _, pressures = watch(make_barometer(make_config, seed=seed, **quiet), 20, height, vibration)
        found.append(height_of(pressures)[0] - height)
    return np.array(found)


def test_wash_on_the_floor_is_within_the_published_range(make_config):
    on_floor = shifts(make_config, 1.0, 0.0, count=200)
    assert on_floor.min() == pytest.approx(-0.3, abs=0.03)
    assert on_floor.max() == pytest.approx(0.5, abs=0.03)
    assert on_floor.mean() == pytest.approx(0.1, abs=0.04)


def test_wash_falls_off_with_height_and_needs_turning_rotors(make_config):
    on_floor = shifts(make_config, 1.0, 0.0)
    np.testing.assert_allclose(shifts(make_config, 1.0, 0.1), on_floor / np.e, atol=STEP)
    np.testing.assert_allclose(shifts(make_config, 1.0, 1.0), 0.0, atol=STEP)
    np.testing.assert_allclose(shifts(make_config, 0.0, 0.0), 0.0, atol=STEP)
    np.testing.assert_allclose(shifts(make_config, 0.5, 0.0), on_floor / 2, atol=STEP)


def test_wash_is_that_of_the_surface_below(make_config):
    shifts = []
    for table in (0.0, 2.0):
        barometer = make_barometer(make_config, noise=0.0, drift=0.0)
        shifts.append(height_of(watch(barometer, 20, table, 1.0, surface=table)[1])[0] - table)
    assert abs(shifts[0]) > 0.05
    assert shifts[1] == pytest.approx(shifts[0], abs=2 * STEP)


@pytest.mark.parametrize("wrong", [{"wash_low": 0.6}, {"wash_high": -0.4}, {"wash_low": -11.0}, {"wash_height": 0.0}])
def test_impossible_wash_is_refused(make_config, wrong):
    config = make_config("cf2").barometer
    for name, value in wrong.items():
        setattr(config, name, value)
    barometer, random = ffi.new("cf_barometer_t *"), ffi.new("cf_random_t *")
    assert lib.cf_barometer_init(barometer, ffi.addressof(config), random[0]) == lib.CF_ERR_VALUE
