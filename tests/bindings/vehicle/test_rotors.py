"""Motors and propellers against the tables of docs/reference/vehicle.md#1, #3, #4, #5 and #14."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

Make = Callable[..., Any]
GRAVITY = 9.81


def bench(config: Any) -> None:
    """Exact duty from a 4 V supply."""
    config.airframe.rotors.duty_bits = 16
    config.airframe.rotors.duty_lowest_level = 0
    config.airframe.battery.constant_voltage = 4.0


# docs/reference/vehicle.md#3: thrust (N) at four motor voltages
THRUST = {
    "cf2": {3.0: 0.1128, 3.3: 0.1423, 3.6: 0.1790, 4.0: 0.2412},
    "cf21bl": {3.0: 0.1860, 3.3: 0.2206, 3.6: 0.2592, 4.0: 0.3176},
}


@pytest.mark.parametrize(
    ("platform", "voltage", "thrust"), [(p, v, f) for p, rows in THRUST.items() for v, f in rows.items()]
)
def test_steady_thrust_follows_the_table(make_config: Make, platform: str, voltage: float, thrust: float) -> None:
    rotors = ffi.addressof(make_config(platform).airframe.rotors)
    assert lib.cf_rotor_steady_thrust(rotors, voltage) == pytest.approx(thrust, abs=5.1e-5)


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
@pytest.mark.parametrize("voltage", [0.5, 0.8, 1.5, 2.4, 3.3, 4.2])
def test_steady_thrust_is_the_cubic_of_the_platform(make_config: Make, platform: str, voltage: float) -> None:
    rotors = make_config(platform).airframe.rotors
    cubic = np.polynomial.Polynomial([rotors.curve.c0, rotors.curve.c1, rotors.curve.c2, rotors.curve.c3])
    assert lib.cf_rotor_steady_thrust(ffi.addressof(rotors), voltage) == pytest.approx(cubic(voltage), rel=2e-5)


# docs/reference/control-pid.md#14: compensated duty at two supplies for a normalized thrust
COMPENSATED = [
    ("cf2", 4.2, {7000: 12075, 10000: 14571, 20000: 23883, 30000: 32053, 36000: 35861, 50000: 42601, 65535: 48057}),
    ("cf2", 3.7, {7000: 13707, 10000: 16540, 20000: 27111, 30000: 36384, 36000: 40708, 50000: 48358, 65535: 54551}),
    ("cf21bl", 4.2, {7000: 12190, 10000: 15015, 20000: 23417, 30000: 30472, 36000: 34193, 50000: 41747, 65535: 48771}),
    ("cf21bl", 3.7, {7000: 13837, 10000: 17044, 20000: 26581, 30000: 34590, 36000: 38814, 50000: 47389, 65535: 55362}),
]


@pytest.mark.parametrize(
    ("platform", "supply", "command", "duty"),
    [(platform, supply, command, duty) for platform, supply, rows in COMPENSATED for command, duty in rows.items()],
)
def test_compensated_duty_returns_the_commanded_thrust(
    make_config: Make, platform: str, supply: float, command: int, duty: int
) -> None:
    rotors = make_config(platform).airframe.rotors
    thrust = lib.cf_rotor_steady_thrust(ffi.addressof(rotors), duty / 65535 * supply)
    assert thrust == pytest.approx(command / 65535 * rotors.curve.thrust_max, rel=1e-3)


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
def test_thrust_and_speed_grow_with_voltage_from_zero(make_config: Make, platform: str) -> None:
    rotors = ffi.addressof(make_config(platform).airframe.rotors)
    voltages = np.linspace(-0.5, 4.5, 2001)
    thrust = np.array([lib.cf_rotor_steady_thrust(rotors, v) for v in voltages])
    rpm = np.array([lib.cf_rotor_steady_rpm(rotors, v) for v in voltages])
    assert (thrust[voltages <= 0] == 0).all()
    assert (rpm[voltages <= 0] == 0).all()
    assert (np.diff(thrust) >= 0).all()
    assert (np.diff(rpm[voltages > 0]) > 0).all()
    assert np.abs(np.diff(rpm)).max() < 100  # continuous, also where the line meets the curve


# docs/reference/vehicle.md#14.1: thrust (N), voltage, duty at 3.7 V, rpm, rad/s, torque with the mixer's ratio (N m)
HOVER = {
    "cf2": (0.0711, 2.40, 0.65, 22200, 2325, 5.0e-4),
    "cf21bl": (0.0964, 2.02, 0.55, 15150, 1586, 0.0964 * 0.0056927884),
}


@pytest.fixture(params=["cf2", "cf21bl"])
def hovering(request: pytest.FixtureRequest, make_vehicle: Make, run: Make) -> tuple[str, Any]:
    """Return a platform and its vehicle, turning steadily at a voltage of docs/reference/vehicle.md#14.1."""

    def change(config: Any) -> None:
        bench(config)
        config.airframe.battery.constant_voltage = 3.7

    vehicle = make_vehicle(request.param, change)
    run(vehicle, [round(HOVER[request.param][1] / 3.7 * 65535)] * 4, 2000)
    return request.param, vehicle


def test_hover_thrust_is_the_weight(hovering: tuple[str, Any]) -> None:
    platform, vehicle = hovering
    assert list(vehicle.rotors.thrust) == pytest.approx([HOVER[platform][0]] * 4, rel=0.01)
    assert lib.cf_rotors_total_thrust(ffi.addressof(vehicle.rotors)) == pytest.approx(vehicle.mass * GRAVITY, rel=0.01)


def test_hover_speed(hovering: tuple[str, Any]) -> None:
    platform, vehicle = hovering
    assert list(vehicle.rotors.rpm) == pytest.approx([HOVER[platform][3]] * 4, rel=0.01)
    assert vehicle.rotors.rpm[0] * np.pi / 30 == pytest.approx(HOVER[platform][4], rel=0.01)
    assert vehicle.rotors.vibration == pytest.approx(1.0, rel=0.01)


def test_hover_torque(hovering: tuple[str, Any]) -> None:
    platform, vehicle = hovering
    assert list(vehicle.rotors.torque) == pytest.approx([HOVER[platform][5]] * 4, rel=0.01)


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
def test_hover_duty_at_3_7_volts(platform: str) -> None:
    _, voltage, duty, *_ = HOVER[platform]
    assert voltage / 3.7 == pytest.approx(duty, rel=0.01)


@pytest.mark.parametrize(("platform", "mass", "speed"), [("cf2", 0.029, 2325), ("cf21bl", 0.0393, 1586)])
def test_speed_that_carries_the_weight(make_config: Make, platform: str, mass: float, speed: float) -> None:
    rotors = make_config(platform).airframe.rotors
    f1, f2 = rotors.thrust_per_rpm, rotors.thrust_per_rpm2
    rpm = (-f1 + (f1 * f1 + f2 * mass * GRAVITY) ** 0.5) / (2 * f2)
    assert rpm == pytest.approx(rotors.hover_rpm, rel=0.01)
    assert rpm * np.pi / 30 == pytest.approx(speed, rel=0.01)


def test_brushless_idle_is_on_the_cubic(make_vehicle: Make, run: Make) -> None:
    """docs/reference/vehicle.md#4: idle 7000 at 4.2 V is about 0.0055 N per motor."""

    def change(config: Any) -> None:
        config.airframe.battery.constant_voltage = 4.2

    vehicle = make_vehicle("cf21bl", change)
    run(vehicle, [7000] * 4, 1000)
    assert vehicle.rotors.thrust[2] == pytest.approx(0.0055, rel=0.03)


# docs/reference/vehicle.md#1: sign of x, of y, of the reaction torque about z
MOTORS = [(+1, -1, -1), (-1, -1, +1), (-1, +1, -1), (+1, +1, +1)]


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
@pytest.mark.parametrize("motor", range(4))
def test_each_motor_pushes_and_turns_as_mounted(
    make_vehicle: Make, run: Make, wrench: Make, platform: str, motor: int
) -> None:
    vehicle = make_vehicle(platform, bench)
    ratios = [0, 0, 0, 0]
    ratios[motor] = 40000
    run(vehicle, ratios, 3000)
    force, torque = wrench(vehicle)
    x, y, z = MOTORS[motor]
    arm = {"cf2": 0.0325, "cf21bl": 0.03536}[platform]
    ratio = {"cf2": 0.0069928949, "cf21bl": 0.0056927884}[platform]
    thrust = vehicle.rotors.thrust[motor]
    assert force == pytest.approx([0, 0, thrust])
    assert torque == pytest.approx([y * arm * thrust, -x * arm * thrust, z * ratio * thrust], rel=1e-5)


@pytest.mark.parametrize(("platform", "tau"), [("cf2", 0.07), ("cf21bl", 0.055)])
def test_speed_follows_the_exact_first_order_step(make_vehicle: Make, run: Make, platform: str, tau: float) -> None:
    vehicle = make_vehicle(platform, bench)
    target = lib.cf_rotor_steady_rpm(ffi.addressof(vehicle.rotors.config), 2.0)
    run(vehicle, [32768] * 4, 70)
    assert vehicle.rotors.rpm[0] == pytest.approx(target * (1 - np.exp(-0.070 / tau)), rel=1e-4)
    run(vehicle, [32768] * 4, 2000)
    assert vehicle.rotors.rpm[0] == pytest.approx(target, rel=1e-4)
    run(vehicle, [0] * 4, 55)
    assert vehicle.rotors.rpm[0] == pytest.approx(target * np.exp(-0.055 / tau), rel=1e-4)


def test_rotors_come_to_a_full_stop(make_vehicle: Make, run: Make) -> None:
    """A decay without end would run into denormal numbers, which are slow."""
    vehicle = make_vehicle("cf2", bench)
    run(vehicle, [65535] * 4, 500)
    run(vehicle, [0] * 4, 2000)
    assert list(vehicle.rotors.rpm) == [0.0] * 4
    assert list(vehicle.rotors.thrust) == [0.0] * 4
    assert list(vehicle.rotors.spin_up) == [0.0] * 4


@pytest.mark.parametrize(("platform", "inertia"), [("cf2", 26.97e-9), ("cf21bl", 38.93e-9)])
def test_spin_up_torque_is_inertia_times_acceleration(
    make_vehicle: Make, run: Make, platform: str, inertia: float
) -> None:
    vehicle = make_vehicle(platform, bench)
    run(vehicle, [30000] * 4, 300)
    before = np.array(list(vehicle.rotors.rpm))
    run(vehicle, [40000, 20000, 30000, 65535], 1)
    acceleration = (np.array(list(vehicle.rotors.rpm)) - before) * np.pi / 30 / 0.001
    assert list(vehicle.rotors.spin_up) == pytest.approx(inertia * acceleration, rel=1e-3, abs=1e-8)


def test_spin_up_is_as_large_as_the_aerodynamic_torque(make_vehicle: Make, run: Make, wrench: Make) -> None:
    """docs/reference/vehicle.md#5: about 5.4e-4 N m at 20 000 rad/s^2."""
    vehicle = make_vehicle("cf2", bench)
    run(vehicle, [39000] * 4, 1000)
    _, steady = wrench(vehicle)
    run(vehicle, [60000, 39000, 60000, 39000], 1)
    _, torque = wrench(vehicle)
    assert torque[2] - steady[2] < -4e-4


def test_gyroscopic_torque_is_minus_rates_cross_momentum(make_vehicle: Make, run: Make, wrench: Make) -> None:
    def change(config: Any) -> None:
        bench(config)
        config.airframe.aerodynamics.form = lib.CF_DRAG_NONE

    vehicle = make_vehicle("cf2", change)
    run(vehicle, [50000, 10000, 40000, 20000], 2000)
    rates = np.array([3.0, -7.0, 2.0])
    speed = np.array(list(vehicle.rotors.rpm)) * np.pi / 30
    momentum = np.array([0, 0, 26.97e-9 * (speed @ [1, -1, 1, -1])])
    still, turning = wrench(vehicle)[1], wrench(vehicle, rates=rates)[1]
    assert turning - still == pytest.approx(-np.cross(rates, momentum), rel=1e-3, abs=1e-8)


@pytest.mark.parametrize(
    ("platform", "ratio", "duty"),
    [
        ("cf2", 0, 0.0),
        ("cf2", 255, 0.0),
        ("cf2", 256, 1 / 255),
        ("cf2", 40000, 156 / 255),
        ("cf2", 40191, 156 / 255),
        ("cf2", 65535, 1.0),
        ("cf21bl", 1503, 0.0),  # DSHOT levels below 47 stop the motor
        ("cf21bl", 1504, 47 / 2047),
        ("cf21bl", 40000, 1250 / 2047),
        ("cf21bl", 65535, 1.0),
    ],
)
def test_duty_has_the_steps_of_the_motor_driver(
    make_vehicle: Make, run: Make, platform: str, ratio: int, duty: float
) -> None:
    def change(config: Any) -> None:
        config.airframe.battery.constant_voltage = 4.0

    vehicle = make_vehicle(platform, change)
    run(vehicle, [ratio] * 4, 2500)
    expected = lib.cf_rotor_steady_rpm(ffi.addressof(vehicle.rotors.config), 4.0 * duty)
    assert vehicle.rotors.rpm[1] == pytest.approx(expected, rel=1e-4)


def test_one_brushed_level_is_about_one_percent_of_hover_thrust(make_config: Make) -> None:
    """docs/reference/vehicle.md#16, trap 9."""
    rotors = ffi.addressof(make_config("cf2").airframe.rotors)
    low, high = (lib.cf_rotor_steady_thrust(rotors, level / 255 * 3.7) for level in (165, 166))
    assert high / low - 1 == pytest.approx(0.01, rel=0.3)


# ------------------------------------------------------------------------------------------- heat


def heated(
    loss: float, time: float = 1.5, thrust: float = 0.0711, own_loss: float = 0.0, own_time: float = 1.5
) -> Callable[[Any], None]:
    def change(config: Any) -> None:
        bench(config)
        config.airframe.rotors.heat_loss = loss
        config.airframe.rotors.heat_time = time
        config.airframe.rotors.heat_own_loss = own_loss
        config.airframe.rotors.heat_own_time = own_time
        config.airframe.rotors.heat_thrust = thrust

    return change


def duty_of(vehicle: Any, thrust: float) -> int:
    """Return the lowest duty with a steady thrust (N) of warm motors."""
    return next(duty for duty in range(0, 65536, 16) if steady(vehicle, duty) >= thrust)


def steady(vehicle: Any, duty: int) -> float:
    return lib.cf_rotor_steady_thrust(ffi.addressof(vehicle.rotors.config), 4.0 * duty / 65535)


def test_cold_motors_deliver_more_and_warm_ones_what_the_curve_says(make_vehicle: Make, run: Make) -> None:
    plain, vehicle = make_vehicle("cf2", bench), make_vehicle("cf2", heated(0.15))
    duty = duty_of(plain, 0.0711)
    run(plain, [duty] * 4, 500)
    run(vehicle, [duty] * 4, 500)
    warmth = vehicle.rotors.warmth
    assert 0.15 < warmth < 0.35
    assert vehicle.rotors.thrust[0] == pytest.approx(plain.rotors.thrust[0] * (1 + 0.15 * (1 - warmth)), rel=1e-4)
    assert vehicle.rotors.torque[0] / vehicle.rotors.thrust[0] == pytest.approx(0.0069928949, rel=1e-5)
    run(plain, [duty] * 4, 20000)
    run(vehicle, [duty] * 4, 20000)
    assert list(vehicle.rotors.thrust) == pytest.approx(list(plain.rotors.thrust), rel=1e-3)


def test_the_common_fade_is_the_same_for_strong_and_weak_motors(make_vehicle: Make, run: Make) -> None:
    plain, vehicle = make_vehicle("cf2", bench), make_vehicle("cf2", heated(0.1, time=3.0))
    ratios = [40000, 30000, 20000, 10000]
    for seconds in (1, 5):
        run(plain, ratios, 1000 * seconds)
        run(vehicle, ratios, 1000 * seconds)
        shares = np.array(list(vehicle.rotors.thrust)) / list(plain.rotors.thrust)
        assert np.ptp(shares) < 1e-5
        assert shares[0] == pytest.approx(1 + 0.1 * (1 - vehicle.rotors.warmth), rel=1e-4)


def test_warmth_follows_the_square_of_thrust_within_its_time(make_vehicle: Make, run: Make) -> None:
    vehicle = make_vehicle("cf2", heated(0.1, time=3.0, own_loss=0.1, own_time=3.0))
    run(vehicle, [40000, 30000, 20000, 10000], 60000)
    heat = np.square(list(vehicle.rotors.thrust)) / 0.0711**2
    assert list(vehicle.rotors.own_warmth) == pytest.approx(list(heat), rel=1e-3, abs=1e-6)
    assert vehicle.rotors.warmth == pytest.approx(heat.mean(), rel=1e-3)
    hot, own = vehicle.rotors.warmth, vehicle.rotors.own_warmth[0]
    run(vehicle, [0] * 4, 3000)
    assert vehicle.rotors.warmth == pytest.approx(hot * np.exp(-1.0), rel=0.03)
    assert vehicle.rotors.own_warmth[0] == pytest.approx(own * np.exp(-1.0), rel=0.03)
    run(vehicle, [0] * 4, 60000)
    assert vehicle.rotors.warmth == 0.0
    assert list(vehicle.rotors.own_warmth) == [0.0] * 4


def test_a_motor_that_works_harder_loses_more_and_all_together_none(make_vehicle: Make, run: Make) -> None:
    plain, vehicle = make_vehicle("cf2", bench), make_vehicle("cf2", heated(0.0, own_loss=0.15))
    ratios = [duty_of(plain, thrust) for thrust in (0.0811, 0.0711, 0.0711, 0.0611)]
    run(plain, ratios, 20000)
    run(vehicle, ratios, 20000)
    shares = np.array(list(vehicle.rotors.thrust)) / list(plain.rotors.thrust)
    assert shares[0] < 0.97 < 1.03 < shares[3]
    assert shares.mean() == pytest.approx(1.0, abs=0.002)


def test_a_strong_motor_that_holds_its_thrust_does_not_run_away(make_vehicle: Make, run: Make) -> None:
    """Its duty settles where the loss is that of the thrust that it has to deliver, and not of what it would cold."""
    vehicle = make_vehicle("cf2", heated(0.065, time=6.0, own_loss=0.15))
    wanted = np.array([0.0924, 0.0711, 0.0498, 0.0711])  # 30 % more and less than a quarter of the weight
    duty = np.array([duty_of(vehicle, thrust) for thrust in wanted], float)
    for _ in range(3000):
        duty += 40000 * (wanted - list(vehicle.rotors.thrust))
        run(vehicle, [round(value) for value in np.clip(duty, 0, 65535)], 10)
    assert list(vehicle.rotors.thrust) == pytest.approx(list(wanted), rel=2e-3)
    heat = np.square(wanted / 0.0711)
    lost = 0.065 * (heat.mean() - 1) + 0.15 * (heat[0] - heat.mean())
    assert steady(vehicle, round(duty[0])) == pytest.approx(wanted[0] / (1 - lost), rel=0.005)


def test_without_a_loss_motors_stay_cold(make_vehicle: Make, run: Make) -> None:
    plain, vehicle = make_vehicle("cf2", bench), make_vehicle("cf2", heated(0.0))
    for each in (plain, vehicle):
        run(each, [50000, 20000, 0, 65535], 3000)
    assert vehicle.rotors.warmth == 0.0
    assert list(vehicle.rotors.own_warmth) == [0.0] * 4
    assert list(vehicle.rotors.thrust) == list(plain.rotors.thrust)


def test_a_very_hot_motor_never_pulls(make_vehicle: Make, run: Make) -> None:
    vehicle = make_vehicle("cf2", heated(0.5, time=0.1, thrust=0.01, own_loss=0.5, own_time=0.1))
    for _ in range(300):
        run(vehicle, [65535, 0, 30000, 65535], 10)
        assert min(vehicle.rotors.thrust) >= 0.0
        # no motor is colder than cold
        assert max(vehicle.rotors.thrust) <= 2.0 * steady(vehicle, 65535)


def test_efficiency_scales_thrust_and_torque(make_vehicle: Make, run: Make) -> None:
    vehicle = make_vehicle("cf2", bench)
    assert lib.cf_rotors_set_efficiency(ffi.addressof(vehicle.rotors), 1, 0.9) == lib.CF_OK
    run(vehicle, [40000] * 4, 1000)
    rotors = vehicle.rotors
    assert rotors.thrust[1] == pytest.approx(0.9 * rotors.thrust[0], rel=1e-6)
    assert rotors.torque[1] == pytest.approx(0.9 * rotors.torque[0], rel=1e-6)
    assert rotors.rpm[1] == rotors.rpm[0]


def test_motor_without_efficiency_stops(make_vehicle: Make, run: Make) -> None:
    vehicle = make_vehicle("cf2", bench)
    run(vehicle, [40000] * 4, 500)
    assert lib.cf_rotors_set_efficiency(ffi.addressof(vehicle.rotors), 3, 0.0) == lib.CF_OK
    run(vehicle, [40000] * 4, 2000)
    assert vehicle.rotors.rpm[3] == 0.0
    assert vehicle.rotors.thrust[3] == 0.0
    assert vehicle.rotors.rpm[2] > 10000


@pytest.mark.parametrize(
    ("motor", "efficiency", "status"),
    [(4, 1.0, -5), (-1, 1.0, -5), (0, -0.1, -1), (0, 2.1, -1), (0, float("nan"), -1)],
)
def test_impossible_efficiency_is_refused(make_vehicle: Make, motor: int, efficiency: float, status: int) -> None:
    vehicle = make_vehicle("cf2")
    assert lib.cf_rotors_set_efficiency(ffi.addressof(vehicle.rotors), motor, efficiency) == status
    assert list(vehicle.rotors.efficiency) == [1.0] * 4


@given(st.lists(st.integers(0, 65535), min_size=4, max_size=4), st.floats(0.5, 4.4))
def test_thrust_stays_between_zero_and_the_steady_value(ratios: list[int], voltage: float) -> None:
    config = ffi.new("cf_vehicle_config_t *")
    lib.cf_vehicle_default_config(config, lib.CF_PLATFORM_CF2)
    rotors = ffi.new("cf_rotors_t *")
    assert lib.cf_rotors_init(rotors, ffi.addressof(config.airframe.rotors)) == lib.CF_OK
    top = lib.cf_rotor_steady_thrust(ffi.addressof(config.airframe.rotors), voltage)
    array = ffi.new("uint16_t[4]", ratios)
    for _ in range(200):
        lib.cf_rotors_step(rotors, array, voltage)
        assert all(0.0 <= thrust <= top * 1.0001 for thrust in rotors.thrust)
