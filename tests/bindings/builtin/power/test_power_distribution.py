"""Mixer, compensation and cap (docs/reference/control-pid.md#13, #14, #18 and #19)."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

CF2, CF21BL = lib.CF_PLATFORM_CF2, lib.CF_PLATFORM_CF21BL
INT32 = (-(2**31), 2**31 - 1)
int16s = st.integers(-32767, 32767)
int32s = st.integers(*INT32)
# a few come back often, zero among them
commands = st.sampled_from([0, 7000, 36000]) | st.integers(-70000, 140000)


def make_power(platform=CF2):
    power = ffi.new("cf_power_distribution_t *")
    assert lib.cf_power_distribution_init(power, platform) == lib.CF_OK
    return power


@pytest.fixture
def power():
    return make_power()


def distribute(power, start=(0, 0, 0, 0), **control):
    uncapped = ffi.new("motors_thrust_uncapped_t *", {"list": start})
    lib.cf_power_distribution_update(power, ffi.new("control_t *", control), uncapped)
    return tuple(uncapped.list)


def legacy(power, thrust, roll, pitch, yaw):
    control = {"thrust": thrust, "roll": roll, "pitch": pitch, "yaw": yaw}
    return distribute(power, controlMode=lib.controlModeLegacy, **control)


def force_torque(power, thrust, torque=(0, 0, 0)):
    return distribute(power, controlMode=lib.controlModeForceTorque, thrustSi=thrust, torque=torque)


def cap(power, uncapped):
    pwm = ffi.new("motors_thrust_pwm_t *")
    capped = lib.cf_power_distribution_cap(power, ffi.new("motors_thrust_uncapped_t *", {"list": uncapped}), pwm)
    return capped, tuple(pwm.list)


def compensate(power, uncapped, supply):
    out = ffi.new("motors_thrust_uncapped_t *")
    lib.cf_power_distribution_compensate(power, ffi.new("motors_thrust_uncapped_t *", {"list": uncapped}), supply, out)
    return tuple(out.list)


def test_an_unknown_platform_is_refused():
    power = ffi.new("cf_power_distribution_t *")
    assert lib.cf_power_distribution_init(power, lib.CF_PLATFORM_COUNT) == lib.CF_ERR_UNKNOWN


# ---- mixer ----


@pytest.mark.parametrize(
    ("control", "motors"),
    [
        # docs/reference/control-pid.md#18
        ((10, 0, 0, 0), (10, 10, 10, 10)),
        ((0, 10, 0, 0), (-5, -5, 5, 5)),
        ((0, 0, 12, 0), (6, -6, -6, 6)),
        ((0, 0, 0, 20), (20, -20, 20, -20)),
        # docs/reference/control-pid.md#19
        ((30000, 11, -7, 5), (29997, 29993, 30013, 29997)),
        ((100.5, -3, 3, -1), (101, 101, 97, 101)),
        ((36000, 32767, 32767, -32767), (3233, 36001, 3233, 101533)),
    ],
)
def test_legacy_mixer(power, control, motors):
    assert legacy(power, *control) == motors


@given(thrust=st.integers(0, 65535), roll=int16s, pitch=int16s, yaw=int16s)
def test_legacy_mixer_keeps_the_total_and_the_moments(thrust, roll, pitch, yaw):
    m1, m2, m3, m4 = legacy(make_power(), thrust, roll, pitch, yaw)
    assert m1 + m2 + m3 + m4 == 4 * thrust
    assert m3 + m4 - m1 - m2 == 4 * int(roll / 2)
    assert m1 + m4 - m2 - m3 == 4 * int(pitch / 2)
    assert m1 + m3 - m2 - m4 == 4 * yaw


# docs/reference/control-pid.md#19; "fallback" are the constants of older trees: arm 0.046 m, 0.1125 N, 0.005964552 m
FORCE_TORQUE = [
    ("fallback", 0.1, (0, 0, 0), (14563,) * 4),
    ("cf2", 0.1, (0, 0, 0), (13653,) * 4),
    ("cf21bl", 0.1, (0, 0, 0), (8191,) * 4),
    ("fallback", 0.28, (0.001, -0.0005, 0.0002), (33655, 38944, 38132, 52376)),
    ("cf2", 0.28, (0.001, -0.0005, 0.0002), (32225, 35837, 36422, 48429)),
    ("cf21bl", 0.28, (0.001, -0.0005, 0.0002), (18900, 22339, 21217, 29290)),
]


def power_of(constants):
    power = make_power(CF21BL if constants == "cf21bl" else CF2)
    if constants == "fallback":
        power.thrust.thrust_max = 0.1125
        power.thrust.thrust_to_torque = 0.005964552
    return power


@pytest.mark.parametrize(("constants", "thrust", "torque", "motors"), FORCE_TORQUE)
def test_force_torque_mixer(constants, thrust, torque, motors):
    assert force_torque(power_of(constants), thrust, torque) == pytest.approx(motors, abs=1, rel=0)


def test_a_little_thrust_turns_all_motors(power):
    assert min(force_torque(power, 0.1)) > 0


@given(
    thrust=st.floats(0.2, 0.4),
    tx=st.floats(-0.001, 0.001),
    ty=st.floats(-0.001, 0.001),
    tz=st.floats(-0.0002, 0.0002),
)
def test_the_rotors_produce_the_wrench_that_was_asked_for(thrust, tx, ty, tz):
    power = make_power()
    forces = [m / 65535 * power.thrust.thrust_max for m in force_torque(power, thrust, (tx, ty, tz))]
    f1, f2, f3, f4 = forces
    arm = math.sqrt(0.5) * power.arm_length
    count = power.thrust.thrust_max / 65535
    assert sum(forces) == pytest.approx(thrust, abs=5 * count)
    assert arm * (f3 + f4 - f1 - f2) == pytest.approx(tx, abs=5 * count * arm)
    assert arm * (f2 + f3 - f1 - f4) == pytest.approx(ty, abs=5 * count * arm)
    assert power.thrust.thrust_to_torque * (f2 + f4 - f1 - f3) == pytest.approx(tz, abs=5 * count * 0.007)


def test_no_rotor_pulls(power):
    assert force_torque(power, 0.0, (0.001, 0, 0))[:2] == (0, 0)


@pytest.mark.parametrize("mode", [lib.controlModeForce, lib.controlModePWM])
def test_forces_go_to_their_motors(power, mode):
    forces = (0.25, -0.1, 1.5, 0.5)
    assert distribute(power, controlMode=mode, normalizedForces=forces) == (16383, 0, 65535, 32767)


def test_an_unknown_mode_changes_nothing(power):
    assert distribute(power, start=(1, 2, 3, 4), controlMode=99, thrust=30000) == (1, 2, 3, 4)


@pytest.mark.parametrize(
    ("thrust", "motor"), [(math.nan, 0), (math.inf, INT32[1]), (-math.inf, INT32[0]), (3e9, INT32[1]), (-3e9, INT32[0])]
)
def test_numbers_that_do_not_fit_saturate(power, thrust, motor):
    assert legacy(power, thrust, 0, 0, 0) == (motor,) * 4


# ---- cap ----


@pytest.mark.parametrize(
    ("uncapped", "capped", "motors"),
    [
        # docs/reference/control-pid.md#18
        ((1000, 2000, 3000, 4000), False, (1000, 2000, 3000, 4000)),
        ((-1000, -2000, -3000, -4000), False, (0, 0, 0, 0)),
        ((65536,) * 4, True, (65535,) * 4),
        ((65536, 65540, 65545, 65550), True, (65521, 65525, 65530, 65535)),
        ((0, 5, 1000, 65545), True, (0, 0, 990, 65535)),
        # docs/reference/control-pid.md#19
        ((3233, 36001, 3233, 101533), True, (0, 3, 0, 65535)),
        # both ends
        ((65535,) * 4, False, (65535,) * 4),
        ((INT32[0], 0, 0, INT32[1]), True, (0, 0, 0, 65535)),
    ],
)
def test_cap(power, uncapped, capped, motors):
    assert cap(power, uncapped) == (capped, motors)


@given(uncapped=st.tuples(int32s, int32s, int32s, int32s), idle=st.integers(0, 15000))
def test_capped_duties_keep_their_differences_above_the_floor(uncapped, idle):
    power = make_power(CF21BL)
    power.idle_thrust = idle
    capped, motors = cap(power, uncapped)
    reduction = max(0, max(uncapped) - 65535)
    assert capped == (reduction > 0)
    assert motors == tuple(max(value - reduction, idle) for value in uncapped)


@pytest.mark.parametrize(("platform", "idle"), [(CF2, 0), (CF21BL, 7000)])
def test_idle_thrust_is_the_floor_of_the_duty(platform, idle):
    power = make_power(platform)
    assert lib.cf_power_distribution_idle_thrust(power) == idle
    assert cap(power, (0, 100, 20000, -5))[1] == (max(0, idle), max(100, idle), 20000, idle)


def test_idle_thrust_counts_only_where_arming_is_required(power):
    power.idle_thrust = 5000
    assert lib.cf_power_distribution_idle_thrust(power) == 0


@pytest.mark.parametrize(("platform", "newton"), [(CF2, 0.48), (CF21BL, 0.8)])
def test_max_thrust_is_that_of_four_motors(platform, newton):
    assert lib.cf_power_distribution_max_thrust(make_power(platform)) == pytest.approx(newton)


# ---- compensation ----


@given(
    platform=st.sampled_from([CF2, CF21BL]),
    ticks=st.lists(
        st.tuples(st.lists(commands, min_size=4, max_size=4), st.floats(1.5, 4.25, width=32)),
        min_size=1,
        max_size=10,
    ),
    repeats=st.integers(1, 3),
)
def test_remembered_voltages_give_the_same_bits(platform, ticks, repeats):
    power = make_power(platform)
    curve = ffi.addressof(power, "thrust")
    for tick, supply in ticks:
        for repeat in range(repeats):
            voltage = supply + 0.01 * repeat
            pure = tuple(int(lib.cf_battery_compensate(curve, command, voltage)) for command in tick)
            assert compensate(power, tick, voltage) == pure


def test_a_repeated_command_is_not_solved_again(power):
    compensate(power, (30000, 36000, 36000, 36000), 4.0)
    power.solved_voltage[0] = 1.0
    assert compensate(power, (30000, 36000, 36000, 36000), 4.0)[0] == 65535 // 4
    assert compensate(power, (36000,) * 4, 4.0)[0] > 30000


def test_a_changed_supply_acts_on_a_remembered_command(power):
    commands = (36000,) * 4
    assert compensate(power, commands, 4.2) == pytest.approx((35861,) * 4, abs=2, rel=0)
    assert compensate(power, commands, 3.7) == pytest.approx((40708,) * 4, abs=2, rel=0)


def test_a_dead_supply_does_not_spoil_the_memory(power):
    commands = (36000,) * 4
    assert compensate(power, commands, 1.0) == (0,) * 4
    assert compensate(power, commands, 4.2) == pytest.approx((35861,) * 4, abs=2, rel=0)


@given(command=st.integers(7000, 65535), supply=st.floats(3.5, 4.2))
def test_the_plant_gives_back_the_commanded_thrust(command, supply):
    power = make_power()
    curve = power.thrust
    duty = compensate(power, (command,) * 4, supply)[0]
    v = duty / 65535 * supply
    force = curve.c0 + curve.c1 * v + curve.c2 * v**2 + curve.c3 * v**3
    assert force == pytest.approx(command / 65535 * curve.thrust_max, rel=1e-3)


def test_parameter_table():
    table = lib.cf_power_distribution_parameters()
    row = table.rows[0]
    assert table.count == 1
    assert (ffi.string(row.group), ffi.string(row.name)) == (b"powerDist", b"idleThrust")
    assert (row.type, row.flags) == (lib.CF_TYPE_UINT32, lib.CF_CORE | lib.CF_PERSISTENT)
    assert ffi.cast("uint32_t *", ffi.cast("char *", make_power(CF21BL)) + row.offset)[0] == 7000
