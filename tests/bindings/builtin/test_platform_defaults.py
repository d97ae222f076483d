"""Facts, gains and limits of a platform (docs/reference/control-pid.md#12, docs/reference/control-geometric.md#5)."""

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


# member: cf2 with 2.1+ propellers, cf21bl
FACTS = {
    "mass": (0.029, 0.0393),
    "arm_length": (0.046, 0.050),
    "thrust.c0": (-0.02476537915958403, -0.014058926705279723),
    "thrust.c1": (0.06523793527519485, 0.04265273261724981),
    "thrust.c2": (-0.026792504967750107, 0.0018327760144017432),
    "thrust.c3": (0.006776789303971145, 0.0020576974784587178),
    "thrust.thrust_min": (0.012817578393224994, 0.02136263065537499),
    "thrust.thrust_max": (0.12, 0.2),
    "thrust.thrust_to_torque": (0.0069928948992470565, 0.00569278844371417),
}


@pytest.mark.parametrize("platform", PLATFORMS)
@pytest.mark.parametrize(("path", "expected"), FACTS.items())
def test_facts_of_the_airframe_are_exact(platform, path, expected):
    value = lib.cf_platform_facts(platform)
    for name in path.split("."):
        value = getattr(value, name)
    assert value == F(expected[platform])


@pytest.mark.parametrize(("platform", "counts"), [(lib.CF_PLATFORM_CF2, 38.8e3), (lib.CF_PLATFORM_CF21BL, 31.6e3)])
def test_hover_is_where_the_facts_put_it(platform, counts):
    facts = lib.cf_platform_facts(platform)
    assert facts.mass * 9.81 / 4 / facts.thrust.thrust_max * 65535 == pytest.approx(counts, abs=60)


def test_an_unknown_platform_has_no_defaults():
    assert lib.cf_platform_defaults(lib.CF_PLATFORM_COUNT) == ffi.NULL


# docs/reference/control-pid.md#12, "Physical constants": 2.1+ propellers, and the brushless
CONSTANTS = {
    "cf2": {
        "mass": 0.029,
        "arm_length": 0.046,
        "battery_low": 3.2,
        "c0": -0.02476537915958403,
        "c1": 0.06523793527519485,
        "c2": -0.026792504967750107,
        "c3": 0.006776789303971145,
        "thrust_min": 0.012817578393224994,
        "thrust_max": 0.12,
        "thrust_to_torque": 0.0069928948992470565,
    },
    "cf21bl": {
        "mass": 0.0393,
        "arm_length": 0.050,
        "battery_low": 3.35,
        "c0": -0.014058926705279723,
        "c1": 0.04265273261724981,
        "c2": 0.0018327760144017432,
        "c3": 0.0020576974784587178,
        "thrust_min": 0.02136263065537499,
        "thrust_max": 0.2,
        "thrust_to_torque": 0.00569278844371417,
    },
}


@pytest.mark.parametrize("platform", PLATFORMS)
def test_platform_has_the_constants_of_the_reference(platform):
    """docs/reference/control-pid.md#12; the low-battery limits stand in its table of limits."""
    facts = lib.cf_platform_facts(platform)
    expected = CONSTANTS[ffi.string(facts.name).decode()]
    found = {name: getattr(facts.thrust if hasattr(facts.thrust, name) else facts, name) for name in expected}
    assert found == {name: F(value) for name, value in expected.items()}


@pytest.mark.parametrize(("platform", "counts"), [(lib.CF_PLATFORM_CF2, 38800), (lib.CF_PLATFORM_CF21BL, 31600)])
def test_hover_takes_the_counts_of_the_reference(platform, counts):
    """docs/reference/control-pid.md#12, "Hover check"; the base thrust of the platform is a guess of it."""
    facts = lib.cf_platform_facts(platform)
    hover = facts.mass * 9.81 / 4 / facts.thrust.thrust_max * 65535
    assert hover == pytest.approx(counts, abs=50)
    assert lib.cf_platform_defaults(platform).thrust_base == pytest.approx(hover, rel=0.08)


def test_idle_duty_is_less_than_the_least_thrust_that_is_commanded():
    """docs/reference/control-pid.md#13: 7000 on the brushless is 10.7 % of the supply, 0.45 V and 0.006 N at 4.2 V."""
    facts = lib.cf_platform_facts(lib.CF_PLATFORM_CF21BL)
    curve = facts.thrust
    duty = lib.cf_platform_defaults(lib.CF_PLATFORM_CF21BL).idle_thrust / 65535
    voltage = 4.2 * duty
    force = curve.c0 + curve.c1 * voltage + curve.c2 * voltage**2 + curve.c3 * voltage**3
    assert duty == pytest.approx(0.107, abs=5e-4)
    assert voltage == pytest.approx(0.45, abs=5e-3)
    assert force == pytest.approx(0.006, abs=5e-4)
    # the compensated 7000 would be 12190, which is the least thrust
    assert lib.cf_battery_compensate(ffi.addressof(curve), 7000, 4.2) == pytest.approx(12190, abs=2)
    assert curve.thrust_min == pytest.approx(7000 / 65535 * curve.thrust_max, rel=1e-4)
