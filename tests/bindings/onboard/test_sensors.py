"""The sensor front end: calibration, alignment, trim, filters, barometer, variables.

docs/reference/estimators.md#12.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from crazychoir_fw._core import ffi, lib

G = 65536 / 48  # accelerometer steps per g


class Sensors:
    """A front end, fresh from boot."""

    def __init__(self) -> None:
        self.struct = ffi.new("cf_sensors_t *")
        ffi.buffer(self.struct)[:] = b"\xaa" * ffi.sizeof("cf_sensors_t")
        lib.cf_sensors_init(self.struct)

    def sample(self, gyro: Any = (0, 0, 0), acc: Any = (0, 0, 1365), tick: int = 2000, times: int = 1) -> None:
        """Take the same raw samples (steps) a number of times, one per tick from `tick` on."""
        raw = [ffi.new("Axis3i16 *", dict(zip("xyz", (int(v) for v in axes), strict=True))) for axes in (gyro, acc)]
        for i in range(times):
            lib.cf_sensors_update(self.struct, *raw, tick + i)

    @property
    def is_calibrated(self) -> bool:
        return lib.cf_sensors_are_calibrated(self.struct)

    def settled_acc(self, force: Any) -> list[float]:
        """Return the accelerations (g) when the filters have settled on a specific force (g)."""
        raw = ffi.new("Axis3i16 *", dict(zip("xyz", (round(G * f) for f in force), strict=True)))
        still = ffi.new("Axis3i16 *")
        for tick in range(1, 400):
            lib.cf_sensors_update(self.struct, still, raw, tick)
        return list(self.struct.data.acc.axis)


# ---- the bias of the gyroscope, docs/reference/estimators.md#12.3


def test_bias_is_the_mean_of_512_still_samples():
    sensors = Sensors()
    sensors.sample((7, -3, 0), times=256)
    sensors.sample((8, -4, 1), times=255)
    assert not sensors.is_calibrated
    sensors.sample((8, -4, 1))
    assert sensors.is_calibrated
    assert list(sensors.struct.gyro_bias.bias.axis) == [7.5, -3.5, 0.5]
    assert list(sensors.struct.gyro_bias.variance) == pytest.approx([0.0, 0.0, 0.0], abs=0.5)


@pytest.mark.parametrize(("tick", "is_accepted"), [(1000, False), (1001, True)])
def test_bias_is_not_accepted_in_the_first_second(tick, is_accepted):
    sensors = Sensors()
    sensors.sample(times=511, tick=1)
    sensors.sample(tick=tick)
    assert sensors.is_calibrated == is_accepted


@pytest.mark.parametrize(("swing", "is_still"), [(9, True), (10, False)])
def test_bias_needs_a_standard_deviation_below_ten_steps(swing, is_still):
    sensors = Sensors()
    for i in range(512):
        sensors.sample((0, swing if i % 2 else -swing, 0), tick=2000 + i)
    assert sensors.struct.gyro_bias.variance[1] == swing**2
    assert sensors.is_calibrated == is_still


def test_mean_of_squares_is_cut_to_a_whole_number():
    """Integer division of the sum of squares, float of the mean: one sample of 1 in 512 has a variance below zero."""
    sensors = Sensors()
    sensors.sample((1, 0, 0))
    sensors.sample(times=511, tick=2001)
    assert sensors.struct.gyro_bias.variance[0] == np.float32(0.0) - np.float32(1 / 512) ** 2


def test_check_is_repeated_with_every_sample_until_it_succeeds_and_never_after():
    sensors = Sensors()
    sensors.sample((500, 0, 0), times=100)
    sensors.sample((20, 0, 0), times=511)
    assert not sensors.is_calibrated
    sensors.sample((20, 0, 0))
    assert sensors.is_calibrated
    sensors.sample((40, 0, 0), times=2000, tick=9000)
    assert sensors.struct.gyro_bias.bias.x == 20.0


def test_rates_are_published_before_the_bias_is_known():
    sensors = Sensors()
    sensors.sample((1000, 0, 0), times=300)
    assert not sensors.is_calibrated
    assert sensors.struct.data.gyro.x == pytest.approx(1000 * 4000 / 65536, rel=1e-5)


# ---- the scale of the accelerometer, docs/reference/estimators.md#12.4


def test_scale_is_the_mean_length_of_200_samples_after_the_bias():
    sensors = Sensors()
    sensors.sample(acc=(0, 0, 2000), times=511)
    assert sensors.struct.acc_scale.scale == 1.0
    sensors.sample(acc=(300, 0, 1300), times=199)
    assert sensors.struct.acc_scale.scale == 1.0
    sensors.sample(acc=(0, -1400, 0))
    lengths = [np.hypot(300, 1300)] * 199 + [1400]
    assert sensors.struct.acc_scale.scale == pytest.approx(np.mean(lengths) / G, rel=1e-6)
    sensors.sample(acc=(0, 0, 2000), times=300, tick=9000)
    assert sensors.struct.acc_scale.scale == pytest.approx(np.mean(lengths) / G, rel=1e-6)


def test_gravity_at_rest_measures_one():
    sensors = Sensors()
    sensors.sample(acc=(100, 200, 1400), times=1500)
    assert np.linalg.norm(list(sensors.struct.data.acc.axis)) == pytest.approx(1.0, rel=3e-6)


# ---- alignment and filters, docs/reference/estimators.md#12.5 and #12.7


@pytest.mark.parametrize("angles", [(0, 0, 90), (180, 0, 0), (10, -20, 30), (-170, 80, 5)])
def test_board_is_turned_into_the_airframe(angles):
    """The matrix of docs/reference/estimators.md#12.5 is the transpose of Rz(psi) Ry(theta) Rx(phi)."""
    sensors = Sensors()
    sensors.struct.imu_phi, sensors.struct.imu_theta, sensors.struct.imu_psi = angles
    sensors.sample(gyro=(3000, -2000, 1000), acc=(1000, 500, -700), times=400)
    turned = Rotation.from_euler("ZYX", angles[::-1], degrees=True).inv()
    rates, force = turned.apply([3000, -2000, 1000]), turned.apply([1000, 500, -700])
    np.testing.assert_allclose(list(sensors.struct.data.gyro.axis), rates * 4000 / 65536, rtol=1e-4, atol=1e-3)
    np.testing.assert_allclose(list(sensors.struct.data.acc.axis), force / G, rtol=1e-4, atol=1e-5)


def test_changed_alignment_counts_from_the_next_sample():
    sensors = Sensors()
    sensors.sample(acc=(1000, 0, 0), times=200)
    sensors.struct.imu_psi = -90.0
    sensors.sample(acc=(1000, 0, 0), times=200)
    assert list(sensors.struct.data.acc.axis) == pytest.approx([0, 1000 / G, 0], abs=1e-5)


@pytest.mark.parametrize(("member", "cutoff"), [("gyro", 80.0), ("acc", 30.0)])
def test_samples_pass_a_low_pass_that_starts_from_zero(member, cutoff):
    sensors, twin = Sensors(), ffi.new("lpf2pData *")
    lib.lpf2pInit(twin, 1000.0, cutoff)
    step = {"gyro": 1000 * 4000 / 65536, "acc": 1000 * 48 / 65536}[member]
    for _ in range(60):
        sensors.sample(gyro=(1000, 0, 0), acc=(1000, 0, 0))
        assert getattr(sensors.struct.data, member).x == pytest.approx(lib.lpf2pApply(twin, step), rel=1e-6)
    # docs/reference/estimators.md#12.7: a transient of about 40 ms
    assert getattr(sensors.struct.data, member).x == pytest.approx(step, rel=0.01)


def test_samples_are_stamped_in_microseconds():
    sensors = Sensors()
    sensors.sample(tick=5_000_000)
    assert sensors.struct.data.interruptTimestamp == 5_000_000_000


# ---- trim, docs/reference/estimators.md#12.6


@pytest.mark.parametrize(("pitch", "roll"), [(0.0, 0.0), (2.0, 0.0), (0.0, -3.0), (4.0, 1.5), (-30.0, 20.0)])
def test_trim_makes_a_tilted_accelerometer_level(pitch, roll):
    """The accelerometer shows what one mounted with this pitch (legacy) and roll shows on level ground."""
    mount = Rotation.from_euler("ZYX", [0, -pitch, roll], degrees=True)
    sensors = Sensors()
    lib.cf_sensors_set_trim(sensors.struct, pitch, roll)
    np.testing.assert_allclose(sensors.settled_acc(mount.inv().apply([0, 0, 1.0])), [0, 0, 1], atol=0.001)


def test_trim_turns_about_x_then_about_y():
    """docs/reference/estimators.md#12.6, written out."""
    pitch, roll = np.radians(10.0), np.radians(20.0)
    x, y, z = 0.3, -0.2, 0.9
    y, z = y * np.cos(roll) - z * np.sin(roll), y * np.sin(roll) + z * np.cos(roll)
    x, z = x * np.cos(pitch) - z * np.sin(pitch), x * np.sin(pitch) + z * np.cos(pitch)
    sensors = Sensors()
    lib.cf_sensors_set_trim(sensors.struct, 10.0, 20.0)
    np.testing.assert_allclose(sensors.settled_acc((0.3, -0.2, 0.9)), [x, y, z], atol=0.001)


def test_no_trim_is_the_identity():
    plain, zero = Sensors(), Sensors()
    lib.cf_sensors_set_trim(zero.struct, 0.0, 0.0)
    assert plain.settled_acc((0.3, -0.2, 0.9)) == zero.settled_acc((0.3, -0.2, 0.9))


# pressure (Pa), height above sea level (m) in float32
@pytest.mark.parametrize(("pressure", "asl"), [(101570.0, 0.0), (101325.0, 21.079), (100000.0, 136.154)])
def test_barometer_is_scaled_to_height(pressure, asl):
    sensors = Sensors()
    lib.cf_sensors_update_baro(sensors.struct, pressure, 31.0)
    baro = sensors.struct.data.baro
    assert baro.asl == pytest.approx(asl, abs=0.0006)
    assert baro.pressure == pytest.approx(pressure / 100)
    assert baro.temperature == 31.0


def test_there_is_no_magnetometer():
    sensors = Sensors()
    sensors.settled_acc((0, 0, 1))
    assert list(sensors.struct.data.mag.axis) == [0.0, 0.0, 0.0]


def test_variables_have_the_names_of_the_firmware():
    def rows(table: Any) -> list[tuple[str, int]]:
        found = [table.rows[i] for i in range(table.count)]
        return [(f"{ffi.string(r.group).decode()}.{ffi.string(r.name).decode()}", r.flags) for r in found]

    core, persistent = lib.CF_CORE, lib.CF_PERSISTENT
    assert rows(lib.cf_sensors_parameters()) == [
        ("imu_sensors.BMP3XX", lib.CF_READ_ONLY),
        *((f"imu_sensors.{name}", persistent) for name in ("imuPhi", "imuTheta", "imuPsi")),
    ]
    assert rows(lib.cf_sensors_logs()) == [
        *((f"{group}.{axis}", core) for group in ("acc", "gyro", "mag") for axis in "xyz"),
        *(("baro.asl", core), ("baro.temp", 0), ("baro.pressure", core)),
        *((f"gyro.{axis}Raw", 0) for axis in "xyz"),
        *((f"gyro.{axis}Variance", 0) for axis in "xyz"),
    ]
