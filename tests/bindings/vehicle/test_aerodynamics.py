"""Drag and the moment of forward flight against docs/reference/vehicle.md#7."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from crazychoir_fw._core import lib

Make = Callable[..., Any]
GRAVITY = 9.81
DRAG = {"cf2": (0.01351483, 0.01677452), "cf21bl": (0.02149163, 0.02359736)}
ROTOR_DRAG = {"cf2": (1.45e-6, 1.80e-6), "cf21bl": (3.39e-6, 3.72e-6)}
HOVER_SPEED = {"cf2": 2325.0, "cf21bl": 1586.0}


def only(form: int, moment: bool = False) -> Callable[[Any], None]:
    """Return a change that leaves this drag, on a bench supply without steps of the duty."""

    def change(config: Any) -> None:
        config.airframe.aerodynamics.form = form
        config.airframe.aerodynamics.body_drag = 0.0
        config.airframe.aerodynamics.has_flight_moment = moment
        config.airframe.rotors.duty_bits = 16
        config.airframe.rotors.duty_lowest_level = 0
        config.airframe.battery.constant_voltage = 4.0

    return change


def set_speed(vehicle: Any, speed: float) -> None:
    """Let all rotors turn at *speed* (rad/s), without thrust."""
    for i in range(4):
        vehicle.rotors.rpm[i] = speed * 30 / np.pi


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
def test_linear_drag_is_that_of_the_table(make_vehicle: Make, wrench: Make, platform: str) -> None:
    force, torque = wrench(make_vehicle(platform, only(lib.CF_DRAG_LINEAR)), velocity=(1.0, -2.0, 3.0))
    xy, z = DRAG[platform]
    assert force == pytest.approx([-xy, 2 * xy, -3 * z], rel=1e-5)
    assert torque == pytest.approx([0, 0, 0])


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
def test_rotor_drag_in_hover_is_the_linear_drag(make_vehicle: Make, wrench: Make, platform: str) -> None:
    vehicle = make_vehicle(platform, only(lib.CF_DRAG_ROTORS))
    set_speed(vehicle, HOVER_SPEED[platform])
    force, _ = wrench(vehicle, velocity=(1.0, 1.0, 1.0))
    xy, z = DRAG[platform]
    assert force == pytest.approx([-xy, -xy, -z], rel=0.005)


@pytest.mark.parametrize("form", [lib.CF_DRAG_ROTORS, lib.CF_DRAG_NONE])
def test_stopped_rotors_have_no_drag(make_vehicle: Make, wrench: Make, form: int) -> None:
    force, torque = wrench(make_vehicle("cf2", only(form)), velocity=(5.0, 1.0, -4.0), rates=(1.0, 2.0, 3.0))
    assert force == pytest.approx([0, 0, 0], abs=1e-12)
    assert torque == pytest.approx([0, 0, 0], abs=1e-12)


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
@pytest.mark.parametrize("seed", range(6))
def test_rotor_drag_is_the_sum_over_the_rotors(make_vehicle: Make, wrench: Make, platform: str, seed: int) -> None:
    """F_i = -Omega_i K (v + w x r_i), torque r_i x F_i, written out."""
    rng = np.random.default_rng(seed)
    vehicle = make_vehicle(platform, only(lib.CF_DRAG_ROTORS))
    speeds = rng.uniform(0, 3000, 4)
    for i in range(4):
        vehicle.rotors.rpm[i] = speeds[i] * 30 / np.pi
    velocity, rates = rng.normal(0, 2, 3), rng.normal(0, 8, 3)
    rotation = Rotation.from_rotvec(rng.normal(0, 1.5, 3)).as_matrix()

    arm = vehicle.rotors.config.arm_x
    drag = np.diag([ROTOR_DRAG[platform][0]] * 2 + [ROTOR_DRAG[platform][1]])
    force, torque = np.zeros(3), np.zeros(3)
    for omega, (x, y) in zip(speeds, [(1, -1), (-1, -1), (-1, 1), (1, 1)], strict=True):
        place = np.array([x * arm, y * arm, 0.012])
        push = -omega * drag @ (rotation.T @ velocity + np.cross(rates, place))
        force += push
        torque += np.cross(place, push)
    momentum = np.array([0, 0, vehicle.rotors.config.inertia * (speeds @ [1, -1, 1, -1])])
    torque -= np.cross(rates, momentum)

    got_force, got_torque = wrench(vehicle, rotation, velocity, rates)
    assert got_force == pytest.approx(rotation @ force, rel=1e-4, abs=1e-7)
    assert got_torque == pytest.approx(torque, rel=1e-4, abs=1e-8)


def test_drag_at_the_rotor_plane_lifts_the_leading_edge(make_vehicle: Make, wrench: Make) -> None:
    """docs/reference/vehicle.md#7: 160 to 200 uN m per m/s."""
    vehicle = make_vehicle("cf2", only(lib.CF_DRAG_ROTORS))
    set_speed(vehicle, HOVER_SPEED["cf2"])
    _, torque = wrench(vehicle, velocity=(1.0, 0.0, 0.0))
    assert -200e-6 < torque[1] < -160e-6


def identified_thrust(vehicle: Any) -> None:
    for i in range(4):
        vehicle.rotors.thrust[i] = vehicle.aerodynamics.config.flight_moment_thrust / 4


@pytest.mark.parametrize(("platform", "k_x", "k_y"), [("cf2", 7.1e-4, 7.9e-4), ("cf21bl", 8e-4, 8e-4)])
def test_flight_moment_is_that_of_the_regression(
    make_vehicle: Make, wrench: Make, platform: str, k_x: float, k_y: float
) -> None:
    vehicle = make_vehicle(platform, only(lib.CF_DRAG_LINEAR, moment=True))
    identified_thrust(vehicle)
    _, torque = wrench(vehicle, velocity=(0.5, 0.25, 0.0))
    assert torque == pytest.approx([0.25 * k_x, -0.5 * k_y, 0], rel=1e-5)


@pytest.mark.parametrize(("platform", "k_x", "k_y"), [("cf2", 7.1e-4, 7.9e-4), ("cf21bl", 8e-4, 8e-4)])
def test_flight_moment_includes_that_of_the_rotor_drag(
    make_vehicle: Make, wrench: Make, platform: str, k_x: float, k_y: float
) -> None:
    vehicle = make_vehicle(platform, only(lib.CF_DRAG_ROTORS, moment=True))
    identified_thrust(vehicle)
    set_speed(vehicle, HOVER_SPEED[platform])
    _, torque = wrench(vehicle, velocity=(1.0, 1.0, 0.0))
    assert torque == pytest.approx([k_x, -k_y, 0], rel=0.002)


def test_flight_moment_follows_thrust_and_is_capped_in_speed(make_vehicle: Make, wrench: Make) -> None:
    vehicle = make_vehicle("cf2", only(lib.CF_DRAG_LINEAR, moment=True))
    identified_thrust(vehicle)
    at_cap = wrench(vehicle, velocity=(3.0, 0.0, 0.0))[1][1]
    assert wrench(vehicle, velocity=(12.0, 0.0, 1.0))[1][1] == pytest.approx(at_cap, rel=1e-5)
    for i in range(4):
        vehicle.rotors.thrust[i] *= 0.5
    assert wrench(vehicle, velocity=(3.0, 0.0, 0.0))[1][1] == pytest.approx(0.5 * at_cap, rel=1e-5)


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
def test_flight_moment_is_on_by_default(make_config: Make, platform: str) -> None:
    assert make_config(platform).airframe.aerodynamics.has_flight_moment


def test_reference_config_is_plain_linear_drag(make_vehicle: Make, run: Make, wrench: Make) -> None:
    """What the closed-loop table of docs/reference/control-pid.md#19 was computed with."""

    def change(config: Any) -> None:
        only(lib.CF_DRAG_LINEAR)(config)
        config.airframe.aerodynamics.drag_xy = 0.0135
        config.airframe.aerodynamics.drag_z = 0.0168

    vehicle = make_vehicle("cf2", change)
    run(vehicle, [39000] * 4, 1000)
    hover, _ = wrench(vehicle)
    force, torque = wrench(vehicle, velocity=(1.0, 2.0, -1.0))
    assert force - hover == pytest.approx([-0.0135, -0.0270, 0.0168], rel=1e-4)
    assert torque == pytest.approx([0, 0, 0], abs=1e-9)


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
def test_terminal_speed_with_stopped_rotors(make_vehicle: Make, wrench: Make, platform: str) -> None:
    """docs/reference/vehicle.md#14.1: 9 to 10 m/s."""
    vehicle = make_vehicle(platform)
    weight = vehicle.mass * GRAVITY
    assert wrench(vehicle, velocity=(0, 0, -9.0))[0][2] < weight < wrench(vehicle, velocity=(0, 0, -10.0))[0][2]


@pytest.mark.parametrize(("platform", "speed"), [("cf2", 7.7), ("cf21bl", 6.5)])
def test_level_speed_held_at_twenty_degrees(make_vehicle: Make, wrench: Make, platform: str, speed: float) -> None:
    """docs/reference/vehicle.md#14.1, computed there with the linear drag."""
    vehicle = make_vehicle(platform, only(lib.CF_DRAG_LINEAR))
    force, _ = wrench(vehicle, velocity=(speed, 0, 0))
    assert -force[0] == pytest.approx(vehicle.mass * GRAVITY * np.tan(np.deg2rad(20)), rel=0.01)


@pytest.mark.parametrize(("platform", "b"), [("cf2", 0.003), ("cf21bl", 0.004)])
def test_body_drag_grows_with_the_square(make_vehicle: Make, wrench: Make, platform: str, b: float) -> None:
    def change(config: Any) -> None:
        config.airframe.aerodynamics.form = lib.CF_DRAG_NONE

    velocity = np.array([3.0, -1.0, 2.0])
    force, _ = wrench(make_vehicle(platform, change), Rotation.from_euler("x", 0.7).as_matrix(), velocity)
    assert force == pytest.approx(-b * np.linalg.norm(velocity) * velocity, rel=1e-5)


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
@pytest.mark.parametrize("form", [lib.CF_DRAG_LINEAR, lib.CF_DRAG_ROTORS])
def test_drag_takes_energy_away(make_vehicle: Make, wrench: Make, platform: str, form: int) -> None:
    vehicle = make_vehicle(platform, only(form))
    set_speed(vehicle, 2000.0)
    rng = np.random.default_rng(0)
    for _ in range(100):
        velocity, rates = rng.normal(0, 3, 3), rng.normal(0, 5, 3)
        rotation = Rotation.from_rotvec(rng.normal(0, 1.5, 3)).as_matrix()
        force, torque = wrench(vehicle, rotation, velocity, rates)
        assert force @ velocity + torque @ rates < 0


def test_wrench_has_no_side_effect(make_vehicle: Make, run: Make, wrench: Make) -> None:
    from crazychoir_fw._core import ffi

    vehicle = make_vehicle("cf2")
    run(vehicle, [30000] * 4, 100)
    before = bytes(ffi.buffer(vehicle))
    wrench(vehicle, velocity=(1, 2, 3), rates=(4, 5, 6))
    assert bytes(ffi.buffer(vehicle)) == before
