"""Noise of the inertial sensors against the data sheet: density, Allan deviation, drift, lines.

docs/reference/vehicle.md#10.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.signal import welch
from sensor_parts import changed, dice

from crazychoir_fw._core import ffi, lib

Make = Callable[..., Any]
DEG = np.pi / 180
RATE = 1000.0  # Hz
GYRO_LSB = 0.06103515625  # deg/s
ACC_LSB = 0.732421875  # mg
G = 9.81

# per axis: what a step is in data-sheet units, density (unit/sqrt(Hz)), rms (unit), random walk (unit/sqrt(s))
GYRO = (GYRO_LSB, 0.014, 0.16, 0.003)
ACC = (ACC_LSB, 0.175, 2.2, 0.05)


def record(make_config: Make, seconds: float, vibration: float = 0.0, seed: int = 1, **changes: float) -> np.ndarray:
    """Return the samples of a drone at rest in steps of the converter, shape (T, 6)."""
    imu = ffi.new("cf_imu_t *")
    assert lib.cf_imu_init(imu, changed(make_config("cf2").airframe.imu, changes), dice(seed)[0]) == lib.CF_OK
    rates, force = ffi.new("float[3]"), ffi.new("float[3]", [0.0, 0.0, G])
    samples = np.empty((round(seconds * RATE), 6), np.int16)
    place = ffi.cast("Axis3i16 *", samples.ctypes.data)
    for _ in range(len(samples)):
        lib.cf_imu_sample(imu, rates, force, vibration, place, place + 1)
        place += 2
    return samples


def allan_deviation(samples: np.ndarray, seconds: float) -> float:
    """Return the overlapping Allan deviation of columns at one averaging time, as one figure over all columns."""
    n = round(seconds * RATE)
    sums = np.cumsum(np.vstack([np.zeros(samples.shape[1]), samples]), axis=0)
    difference = (sums[2 * n :] - 2 * sums[n:-n] + sums[: -2 * n]) / n
    return float(np.sqrt(np.mean(difference**2) / 2))


@pytest.fixture(scope="module")
def at_rest() -> np.ndarray:
    """Ten minutes on the floor, motors off, shape (T, 6)."""
    config = ffi.new("cf_vehicle_config_t *")
    assert lib.cf_vehicle_default_config(config, lib.CF_PLATFORM_CF2) == lib.CF_OK
    return record(lambda platform: config, 600.0)


@pytest.mark.parametrize(("axes", "sheet"), [(slice(0, 3), GYRO), (slice(3, 6), ACC)], ids=["gyro", "acc"])
@pytest.mark.parametrize("seconds", [0.1, 0.3, 1.0])
def test_allan_deviation_is_that_of_the_data_sheet(at_rest, axes, sheet, seconds):
    """White noise of one-sided density N has N / sqrt(2 tau); the walk of the bias K sqrt(tau / 3)."""
    step, density, _, walk = sheet
    expected = np.hypot(density / np.sqrt(2 * seconds), walk * np.sqrt(seconds / 3))
    assert step * allan_deviation(at_rest[:, axes], seconds) == pytest.approx(expected, rel=0.07)
    # the walk is not seen yet: the data sheet's figure alone
    assert step * allan_deviation(at_rest[:, axes], seconds) == pytest.approx(density / np.sqrt(2 * seconds), rel=0.1)


@pytest.mark.parametrize(("axes", "sheet"), [(slice(0, 3), GYRO), (slice(3, 6), ACC)], ids=["gyro", "acc"])
def test_density_and_deviation_hold_together(at_rest, axes, sheet):
    step, density, deviation, _ = sheet
    samples = step * at_rest[:100_000, axes].astype(float)
    frequency, power = welch(samples, RATE, nperseg=2000, axis=0)
    slow = (frequency > 2) & (frequency < 30)
    assert np.sqrt(power[slow].mean()) == pytest.approx(density, rel=0.05)
    assert samples.std(axis=0) == pytest.approx(np.hypot(deviation, step / 12**0.5), rel=0.03)
    # one pole leaves less and less towards half the rate
    assert power[frequency > 450].mean() < 0.2 * density**2


def test_noise_of_flight_is_white(make_config):
    samples = record(make_config, 60.0, vibration=1.0, gyro_noise_rest=0.0, acc_noise_rest=0.0).astype(float)
    frequency, power = welch(samples, RATE, nperseg=1000, axis=0)
    for axis, level in enumerate([1.0 / GYRO_LSB] * 3 + [0.2 / G * 1000 / ACC_LSB] * 3):
        white = level**2 / 500
        for low, high in ((2, 50), (50, 250), (250, 498)):
            band = (frequency > low) & (frequency < high)
            assert power[band, axis].mean() == pytest.approx(white, rel=0.1)


@pytest.mark.parametrize("density", ["gyro_noise_density", "acc_noise_density"])
def test_without_density_the_noise_is_white_and_no_smaller(make_config, density):
    samples = record(make_config, 30.0, **{density: 0.0}).astype(float)
    axes, sheet = (slice(0, 3), GYRO) if density.startswith("gyro") else (slice(3, 6), ACC)
    found = samples[:, axes]
    assert sheet[0] * found.std(axis=0) == pytest.approx(np.hypot(sheet[2], sheet[0] / 12**0.5), rel=0.03)
    assert abs(np.corrcoef(found[1:, 0], found[:-1, 0])[0, 1]) < 0.03


def test_bias_walks_as_the_reference_says_and_stays_within_its_leash(make_config):
    """0.003 deg/s and 0.05 mg after a second; forgotten after `drift_time`."""
    quiet = {"noise_scale": 0.0, "gyro_bias": 0.0, "acc_bias": 0.0, "gyro_scale_error": 0.0, "acc_scale_error": 0.0}
    # a hundred times as strong, so that the steps of the converter do not matter
    strong = {"gyro_drift": 0.3 * DEG, "acc_drift": 5e-3 * G}
    ends = np.array(
        [record(make_config, 4.0, seed=seed, **quiet, **strong)[-1] - [0, 0, 0, 0, 0, 1365] for seed in range(60)]
    )
    for axes, (step, _, _, walk) in ((slice(0, 3), GYRO), (slice(3, 6), ACC)):
        assert step * ends[:, axes].std() == pytest.approx(100 * walk * 2.0, rel=0.15)

    leashed = record(make_config, 200.0, **quiet, **strong, drift_time=1.0).astype(float)
    # steps of 0.1 s, each of which loses a tenth
    spread = 0.3 * np.sqrt(0.1 / (1 - 0.9**2))
    assert GYRO_LSB * leashed[:, :3].std() == pytest.approx(spread, rel=0.15)


def test_everything_can_be_switched_off(make_config):
    samples = record(make_config, 3.0, vibration=1.0, noise_scale=0.0, bias_scale=0.0)
    assert (samples == [0, 0, 0, 0, 0, 1365]).all()


# ---------------------------------------------------------------- lines of the rotors


def shaken(make_vehicle: Make, run: Make, acc: float, gyro: float) -> tuple[np.ndarray, float]:
    """Return a second of samples in hover without noise, shape (1000, 6), and the speed of the rotors (Hz)."""

    def change(config: Any) -> None:
        config.airframe.battery.constant_voltage = 3.7
        config.airframe.imu.noise_scale = 0.0
        config.airframe.imu.bias_scale = 0.0
        config.airframe.imu.lines.acc = acc
        config.airframe.imu.lines.gyro = gyro

    vehicle = make_vehicle("cf2", change)
    run(vehicle, [42500] * 4, 3000)
    rates, force = ffi.new("float[3]"), ffi.new("float[3]")
    samples = np.empty((1000, 6), np.int16)
    place = ffi.cast("Axis3i16 *", samples.ctypes.data)
    for i in range(len(samples)):
        lib.cf_vehicle_imu(vehicle, rates, force, place + 2 * i, place + 2 * i + 1)
    return samples, vehicle.rotors.rpm[0] / 60


def line_at(signal: np.ndarray, hertz: float) -> float:
    """Return the amplitude of a line, which may have been folded by the sampling."""
    folded = abs((hertz + 500) % 1000 - 500)
    spectrum = 2 * np.abs(np.fft.rfft(signal * np.hanning(len(signal)))) / (len(signal) / 2)
    return spectrum[round(folded) - 2 : round(folded) + 3].max()


def test_lines_stand_at_the_speed_of_the_rotors_and_at_its_double(make_vehicle, run):
    samples, hertz = shaken(make_vehicle, run, acc=0.25, gyro=0.02)
    assert hertz == pytest.approx(370, abs=15)  # docs/reference/vehicle.md#14.1: rotor frequency in hover
    growth = (60 * hertz / 22200) ** 2
    for axis, line in ((3, hertz), (4, hertz), (5, 2 * hertz)):
        # four rotors, all at one speed and in phase here
        assert line_at(samples[:, axis] * ACC_LSB / 1000 * G, line) == pytest.approx(4 * 0.25 * growth, rel=0.2)
        assert line_at(samples[:, axis - 3] * GYRO_LSB * DEG, line) == pytest.approx(4 * 0.02 * growth, rel=0.2)
    assert line_at(samples[:, 5] * ACC_LSB / 1000 * G, hertz) < 0.05


def test_there_are_no_lines_unless_asked_for(make_vehicle, run):
    samples, _ = shaken(make_vehicle, run, acc=0.0, gyro=0.0)
    assert (samples == samples[0]).all()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("gyro_noise_density", -1.0),
        ("acc_noise_density", float("nan")),
        ("gyro_drift", -0.1),
        ("acc_drift", float("inf")),
        ("drift_time", 0.5),
        ("lines.acc", -0.1),
        ("lines.gyro", float("nan")),
    ],
)
def test_impossible_noise_is_refused(make_config, name, value):
    config = make_config("cf2").airframe.imu
    *path, last = name.split(".")
    setattr(getattr(config, path[0]) if path else config, last, value)
    imu, random = ffi.new("cf_imu_t *"), ffi.new("cf_random_t *")
    assert lib.cf_imu_init(imu, ffi.addressof(config), random[0]) == lib.CF_ERR_VALUE


@pytest.mark.parametrize("vibration", [0.1, 0.3, 1.0, 2.0])
def test_noise_in_flight_is_the_sum_of_both(make_config, vibration):
    """One pole and one zero in place of two noises: the same spectrum, also where both are alike."""
    samples = GYRO_LSB * record(make_config, 60.0, vibration=vibration)[:, :3].astype(float)
    assert samples.var(axis=0).mean() == pytest.approx(0.16**2 + vibration**2 + GYRO_LSB**2 / 12, rel=0.03)
    frequency, power = welch(samples, RATE, nperseg=1000, axis=0)
    white = (vibration**2 + GYRO_LSB**2 / 12) / 500
    pole = 0.5858  # of 0.014 (deg/s)/sqrt(Hz) and 0.16 deg/s
    turn = np.exp(-2j * np.pi * frequency / RATE)
    shaped = 0.014**2 * (1 - pole) ** 2 / np.abs(1 - pole * turn) ** 2
    for low, high in ((2, 20), (20, 80), (80, 200), (200, 498)):
        band = (frequency > low) & (frequency < high)
        assert power[band].mean() == pytest.approx((shaped[band] + white).mean(), rel=0.06)
