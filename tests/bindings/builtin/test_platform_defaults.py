"""Gains and limits a platform boots with (control-pid dossier section 12)."""

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib

F = np.float32
PLATFORMS = [lib.CF_PLATFORM_CF2, lib.CF_PLATFORM_CF21BL]

# loop: (kp, ki, kd, kff), the same on both platforms
COMMON_GAINS = {
    "yaw_rate": (120, 16.7, 0, 0),
    "roll": (6, 3, 0, 0),
    "pitch": (6, 3, 0, 0),
    "yaw": (6, 1, 0.35, 0),
    "x": (2, 0, 0, 0),
    "y": (2, 0, 0, 0),
    "z": (2, 0.5, 0, 0),
    "vx": (25, 1, 0, 0),
    "vy": (25, 1, 0, 0),
    "vz": (25, 15, 0, 0),
}
COMMON_LIMITS = {
    "roll_rate_integral_limit": 33.3,
    "pitch_rate_integral_limit": 33.3,
    "yaw_rate_integral_limit": 166.7,
    "roll_integral_limit": 20,
    "pitch_integral_limit": 20,
    "yaw_integral_limit": 360,
    "yaw_max_delta": 0,
    "roll_max": 20,
    "pitch_max": 20,
    "velocity_x_max": 1,
    "velocity_y_max": 1,
    "velocity_z_max": 1,
    "thrust_min": 20000,
    "roll_rate_cutoff": 30,
    "pitch_rate_cutoff": 30,
    "yaw_rate_cutoff": 30,
    "rate_filter_enabled": False,
}
COMMON_FILTERS = {
    "attitude_filter": (False, 15),
    "position_xy_filter": (True, 20),
    "position_z_filter": (True, 20),
    "velocity_xy_filter": (True, 20),
    "velocity_z_filter": (True, 20),
}


def gains(defaults, loop):
    pid = getattr(defaults, loop)
    return (pid.kp, pid.ki, pid.kd, pid.kff)


@pytest.mark.parametrize("platform", PLATFORMS)
@pytest.mark.parametrize(("loop", "expected"), COMMON_GAINS.items())
def test_most_gains_are_shared(platform, loop, expected):
    assert gains(lib.cf_platform_defaults(platform), loop) == tuple(map(F, expected))


@pytest.mark.parametrize("loop", ["roll_rate", "pitch_rate"])
@pytest.mark.parametrize(
    ("platform", "expected"),
    [(lib.CF_PLATFORM_CF2, (250, 500, 2.5, 0)), (lib.CF_PLATFORM_CF21BL, (200, 400, 2.5, 0))],
)
def test_rate_gains_differ(loop, platform, expected):
    assert gains(lib.cf_platform_defaults(platform), loop) == expected


@pytest.mark.parametrize("platform", PLATFORMS)
@pytest.mark.parametrize(("limit", "expected"), COMMON_LIMITS.items())
def test_most_limits_are_shared(platform, limit, expected):
    assert getattr(lib.cf_platform_defaults(platform), limit) == F(expected)


@pytest.mark.parametrize("platform", PLATFORMS)
@pytest.mark.parametrize(("name", "expected"), COMMON_FILTERS.items())
def test_filters_are_shared(platform, name, expected):
    settings = getattr(lib.cf_platform_defaults(platform), name)
    assert (settings.enabled, settings.cutoff) == expected


@pytest.mark.parametrize(
    ("platform", "thrust_base", "requires_arming", "idle_thrust"),
    [(lib.CF_PLATFORM_CF2, 36000, False, 0), (lib.CF_PLATFORM_CF21BL, 30000, True, 7000)],
)
def test_thrust_and_arming_differ(platform, thrust_base, requires_arming, idle_thrust):
    defaults = lib.cf_platform_defaults(platform)
    assert (defaults.thrust_base, defaults.idle_thrust) == (thrust_base, idle_thrust)
    assert lib.cf_platform_facts(platform).requires_arming == requires_arming


def test_an_unknown_platform_has_no_defaults():
    assert lib.cf_platform_defaults(lib.CF_PLATFORM_COUNT) == ffi.NULL
