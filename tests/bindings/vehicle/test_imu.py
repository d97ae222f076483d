"""The raw inertial samples: steps, saturation, noise and turn-on errors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from sensor_parts import changed, dice

from crazychoir_fw._core import ffi, lib

Make = Callable[..., Any]
DEG = np.pi / 180
GYRO_LSB = 0.06103515625  # deg/s
ACC_LSB = 0.000732421875  # g


def make_imu(make_config: Make, seed: int = 1, **changes: float) -> Any:
    config = changed(make_config("cf2").airframe.imu, changes)
    imu = ffi.new("cf_imu_t *")
    assert lib.cf_imu_init(imu, config, dice(seed)[0]) == lib.CF_OK
    return imu


def sample(
    imu: Any, rates: Any = (0.0, 0.0, 0.0), force: Any = (0.0, 0.0, 9.81), vibration: float = 0.0, count: int = 1
) -> np.ndarray:
    """Return raw samples, shape (count, 6)."""
    rates, force = ffi.new("float[3]", list(rates)), ffi.new("float[3]", list(force))
    gyro, acc = ffi.new("Axis3i16 *"), ffi.new("Axis3i16 *")
    rows = []
    for _ in range(count):
        lib.cf_imu_sample(imu, rates, force, vibration, gyro, acc)
        rows.append((gyro.x, gyro.y, gyro.z, acc.x, acc.y, acc.z))
    return np.array(rows)


@pytest.fixture
def ideal(make_config: Make) -> Any:
    return make_imu(make_config, noise_scale=0.0, bias_scale=0.0)


def test_steps_are_those_of_the_front_end(ideal: Any) -> None:
    raw = sample(ideal, rates=(100 * DEG, -250 * DEG, 1000 * DEG), force=(9.81, -2 * 9.81, 10 * 9.81))[0]
    expected = [100 / GYRO_LSB, -250 / GYRO_LSB, 1000 / GYRO_LSB, 1 / ACC_LSB, -2 / ACC_LSB, 10 / ACC_LSB]
    assert np.abs(raw - expected).max() <= 0.51


def test_one_g_at_rest(ideal: Any) -> None:
    assert sample(ideal)[0].tolist() == [0, 0, 0, 0, 0, 1365]


@pytest.mark.parametrize(("steps", "raw"), [(10.4, 10), (10.6, 11), (-10.4, -10), (-10.6, -11), (0.4, 0), (-0.4, 0)])
def test_samples_are_rounded_to_the_nearest(ideal: Any, steps: float, raw: int) -> None:
    assert sample(ideal, rates=(steps * GYRO_LSB * DEG, 0, 0))[0][0] == raw


@pytest.mark.parametrize(
    ("rate", "raw"),
    [(1999.9, 32766), (2000.0, 32767), (1e6, 32767), (np.inf, 32767), (-2000.0, -32768), (-1e6, -32768)],
)
def test_gyroscope_saturates_at_2000_deg_per_s(ideal: Any, rate: float, raw: int) -> None:
    assert sample(ideal, rates=(rate * DEG, 0, 0))[0][0] == pytest.approx(raw, abs=1)


@pytest.mark.parametrize(("g", "raw"), [(24.0, 32767), (-24.1, -32768), (-np.inf, -32768), (np.nan, -32768)])
def test_accelerometer_saturates_at_24_g(ideal: Any, g: float, raw: int) -> None:
    assert sample(ideal, force=(0, g * 9.81, 0))[0][4] == raw


@pytest.mark.parametrize(
    ("vibration", "gyro_deg", "acc"),
    [
        (0.0, 0.16, 0.0022 * 9.81),
        (1.0, np.hypot(0.16, 1.0), np.hypot(0.0022 * 9.81, 0.2)),
        (2.0, np.hypot(0.16, 2.0), np.hypot(0.0022 * 9.81, 0.4)),
    ],
)
def test_noise_grows_with_the_rotors(make_config: Make, vibration: float, gyro_deg: float, acc: float) -> None:
    raw = sample(make_imu(make_config), vibration=vibration, count=20_000)
    rounding = 1 / 12**0.5
    assert raw[:, :3].std(axis=0) == pytest.approx(np.hypot(gyro_deg / GYRO_LSB, rounding), rel=0.03)
    assert raw[:, 3:].std(axis=0) == pytest.approx(np.hypot(acc / 9.81 / ACC_LSB, rounding), rel=0.03)


def test_rest_noise_passes_the_still_calibration(make_config: Make) -> None:
    """docs/reference/estimators.md#12.3: the variance of 512 samples must stay below 100 steps^2."""
    assert sample(make_imu(make_config), count=512)[:, :3].var(axis=0).max() < 100 / 5


def test_axes_and_samples_are_independent(make_config: Make) -> None:
    raw = sample(make_imu(make_config), vibration=1.0, count=20_000).astype(float)
    correlation = np.corrcoef(raw.T) - np.eye(6)
    assert np.abs(correlation).max() < 0.03
    for axis in raw.T:
        assert abs(np.corrcoef(axis[:-1], axis[1:])[0, 1]) < 0.03


def test_noise_scale_doubles_the_noise(make_config: Make) -> None:
    raw = sample(make_imu(make_config, noise_scale=2.0), vibration=1.0, count=20_000)
    assert raw[:, 0].std() == pytest.approx(2 * np.hypot(0.16, 1.0) / GYRO_LSB, rel=0.03)


def test_turn_on_errors_fill_their_range(make_config: Make) -> None:
    imus = [make_imu(make_config, seed=seed) for seed in range(500)]
    bias = np.array([list(imu.bias) for imu in imus])
    gain = np.array([list(imu.gain) for imu in imus])
    limits = np.array([1 / GYRO_LSB] * 3 + [0.020 / ACC_LSB] * 3)
    assert (np.abs(bias) <= limits * 1.0001).all()
    assert np.abs(bias).max(axis=0) == pytest.approx(limits, rel=0.05)
    assert np.abs(bias.mean(axis=0) / limits).max() < 0.1
    nominal = np.array([1 / DEG / GYRO_LSB] * 3 + [1 / 9.81 / ACC_LSB] * 3)
    assert np.abs(gain / nominal - 1).max(axis=0) == pytest.approx([0.01] * 3 + [0.005] * 3, rel=0.05)


def test_bias_scale_does_not_change_the_noise(make_config: Make) -> None:
    with_bias, without = make_imu(make_config), make_imu(make_config, bias_scale=0.0)
    a = sample(with_bias, force=(0, 0, 0), vibration=1.0, count=100)
    b = sample(without, force=(0, 0, 0), vibration=1.0, count=100)
    shift = np.array(list(with_bias.bias))
    assert np.abs(a - b - shift).max() <= 1.0


def test_noise_is_the_same_on_every_run(make_config: Make) -> None:
    a, b = (sample(make_imu(make_config, seed=5), vibration=1.0, count=50) for _ in range(2))
    assert (a == b).all()
    assert (a != sample(make_imu(make_config, seed=6), vibration=1.0, count=50)).any()


def test_vehicle_samples_with_the_vibration_of_its_rotors(make_vehicle: Make, run: Make) -> None:
    def change(config: Any) -> None:
        config.airframe.battery.constant_voltage = 3.7

    vehicle = make_vehicle("cf2", change)
    zeros, force = ffi.new("float[3]"), ffi.new("float[3]", [0, 0, 9.81])
    gyro, acc = ffi.new("Axis3i16 *"), ffi.new("Axis3i16 *")

    def spread() -> float:
        rows = []
        for _ in range(4000):
            lib.cf_vehicle_imu(vehicle, zeros, force, gyro, acc)
            rows.append(gyro.y)
        return float(np.std(rows))

    still = spread()
    run(vehicle, [42500] * 4, 1500)
    assert still == pytest.approx(0.16 / GYRO_LSB, rel=0.1)
    assert spread() == pytest.approx(np.hypot(0.16, 1.0) / GYRO_LSB, rel=0.1)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("gyro_noise_rest", -1.0),
        ("gyro_noise_flight", float("nan")),
        ("acc_noise_rest", float("inf")),
        ("acc_noise_flight", -0.1),
        ("gyro_bias", -0.1),
        ("acc_bias", float("nan")),
        ("gyro_scale_error", 0.6),
        ("acc_scale_error", -0.1),
        ("noise_scale", -1.0),
        ("noise_scale", 101.0),
        ("bias_scale", float("nan")),
    ],
)
def test_impossible_config_is_refused(make_config: Make, name: str, value: float) -> None:
    config = make_config("cf2").airframe.imu
    setattr(config, name, value)
    imu = ffi.new("cf_imu_t *")
    assert lib.cf_imu_init(imu, ffi.addressof(config), ffi.new("cf_random_t *")[0]) == lib.CF_ERR_VALUE
