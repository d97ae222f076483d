"""The numbers of each platform against docs/reference/vehicle.md#18."""

from __future__ import annotations

from typing import Any

import pytest

from crazychoir_fw._core import ffi, lib

TABLE = {
    "mass": (0.029, 0.0393),
    "inertia": ([16.572e-6, 16.656e-6, 29.262e-6], [25e-6, 28e-6, 49e-6]),
    "landed_height": (0.0145, 0.0175),
    "rotors.arm_x": (0.0325, 0.03536),
    "rotors.arm_y": (0.0325, 0.03536),
    "rotors.height": (0.012, 0.012),
    "rotors.thrust_per_rpm": (-3.62002e-7, -3.133427e-7),
    "rotors.thrust_per_rpm2": (1.606092e-10, 4.407355e-10),
    "rotors.curve.thrust_to_torque": (0.0069929, 0.0056928),
    "rotors.curve.thrust_max": (0.12, 0.20),
    "rotors.curve.thrust_min": (0.0128176, 0.0213626),
    "rotors.time_constant_up": (0.07, 0.055),
    "rotors.time_constant_down": (0.07, 0.055),
    "rotors.inertia": (26.97e-9, 38.93e-9),
    "battery.capacity": (0.250 * 3600, 0.350 * 3600),
    "battery.base_power": (1.10, 1.1),
    "battery.power_per_thrust": (0.2337 / 9.80665e-3, 0.193 / 9.80665e-3),
    "aerodynamics.drag_xy": (0.01351, 0.02149),
    "aerodynamics.drag_z": (0.01677, 0.02360),
    "aerodynamics.rotor_drag_xy": (1.45e-6, 3.39e-6),
    "aerodynamics.rotor_drag_z": (1.80e-6, 3.72e-6),
    "aerodynamics.body_drag": (0.003, 0.004),
    "aerodynamics.flight_moment_x": (7.1e-4, 8e-4),
    "aerodynamics.flight_moment_y": (7.9e-4, 8e-4),
    "imu.gyro_noise_rest": (0.16 * 0.0174533, 0.16 * 0.0174533),
    "imu.gyro_noise_flight": (0.0174533, 0.0174533),
    "imu.acc_noise_rest": (0.022, 0.022),
    "imu.acc_noise_flight": (0.2, 0.2),
}


def read(platform: int, path: str) -> Any:
    config = ffi.new("cf_vehicle_config_t *")
    assert lib.cf_vehicle_default_config(config, platform) == lib.CF_OK
    value: Any = config.airframe
    for name in path.split("."):
        value = getattr(value, name)
    return value if isinstance(value, float) else list(value)


@pytest.mark.parametrize("path", TABLE)
@pytest.mark.parametrize("platform", [lib.CF_PLATFORM_CF2, lib.CF_PLATFORM_CF21BL])
def test_airframe_has_the_number_of_the_table(platform: int, path: str) -> None:
    rel = 0.02 if path == "imu.acc_noise_rest" else 5e-4
    assert read(platform, path) == pytest.approx(TABLE[path][platform], rel=rel)


@pytest.mark.parametrize(("platform", "total"), [(lib.CF_PLATFORM_CF2, 0.22), (lib.CF_PLATFORM_CF21BL, 0.11)])
def test_resistance_of_the_pack(platform: int, total: float) -> None:
    """docs/reference/vehicle.md#6: 0.20 and 0.02 Ohm in the 250 mAh pack, 0.11 Ohm in all in the 350 mAh pack."""
    assert read(platform, "battery.resistance") + read(platform, "battery.slow_resistance") == pytest.approx(total)


@pytest.mark.parametrize("platform", [-1, 2, 1000])
def test_unknown_platform_is_refused(platform: int) -> None:
    number = ffi.cast("cf_platform_t", platform)
    assert lib.cf_vehicle_default_config(ffi.new("cf_vehicle_config_t *"), number) == lib.CF_ERR_UNKNOWN
