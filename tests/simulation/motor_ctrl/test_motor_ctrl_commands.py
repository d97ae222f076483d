"""What each class of the family makes the drone do: newtons, signs, rates."""

import math

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.simulation import (
    DroneConfig,
    MotorCtrl,
    MotorCtrlFPQR,
    MotorCtrlFRPY,
    MotorCtrlVel,
    MotorCtrlXYZ,
    World,
)

QUIET = {"bias": 0, "mocap_noise": 0, "mocap_attitude_noise": 0, "baro_noise": 0}


def flown_by(cls, **options):
    world = World([DroneConfig("cf1", noise=0, attributes=QUIET, motor_ctrl=cls, **options)])
    world.wait_until_ready()
    world.run(0.1)  # the accelerometer finds its scale at rest
    return world, world.drones[0].motor_ctrl


def in_the_air(cls, **options):
    world, control = flown_by(cls, **options)
    control.drone.place((0.0, 0.0, 20.0))
    control.command(control.weight, 0.0, 0.0, 0.0)
    world.run(0.5)
    return world, control


def mean_over(world, seconds, read):
    samples = []
    for _ in range(round(seconds * 100)):
        world.run(0.01)
        samples.append(read())
    return np.mean(samples, axis=0)


@pytest.mark.parametrize("battery", [1.0, 0.5])
@pytest.mark.parametrize(
    ("platform", "steps"), [("cf2", (0.2844, 0.22, 0.40, 0.33)), ("cf21bl", (0.3855, 0.30, 0.65, 0.5))]
)
def test_the_newtons_that_are_asked_for_are_delivered(platform, steps, battery):
    world, control = flown_by(MotorCtrlFPQR, platform=platform, battery=battery)
    control.drone.place((0.0, 0.0, 20.0))
    for newtons in steps:
        control.command(newtons, 0.0, 0.0, 0.0)
        world.run(0.6)  # rotors, and the filter of the supply voltage, settle
        delivered = mean_over(world, 0.2, lambda: control.rotor_thrust.sum())
        assert delivered == pytest.approx(newtons, rel=0.01)


def test_thrust_saturates_where_motors_do():
    _, control = flown_by(MotorCtrlFPQR)
    for asked, counts in ((-1.0, 0.0), (9.0, 65535.0), (0.24, 32767.5)):
        control.command(asked, 0.0, 0.0, 0.0)
        assert control.drone.struct.onboard.client_setpoint.thrust == pytest.approx(counts)
    assert control.max_thrust == pytest.approx(0.48)


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_body_rates_have_the_right_sign_and_size(platform, axis):
    world, control = in_the_air(MotorCtrlFPQR, platform=platform)
    rates = [0.0, 0.0, 0.0]
    rates[axis] = 1.0
    control.command(control.weight, *rates)
    world.run(0.4)
    found = mean_over(world, 0.1, lambda: control.body_rates)
    assert found[axis] == pytest.approx(1.0, abs=0.35)
    assert np.abs(np.delete(found, axis)).max() < 0.05


@pytest.mark.parametrize("controller", ["pid", "mellinger", "lee", "indi"])
@pytest.mark.parametrize(("axis", "flies_to"), [(0, (0, -1)), (1, (1, 0)), (2, (0, 0))])
def test_attitudes_have_the_right_sign_and_size(controller, axis, flies_to):
    world, control = in_the_air(MotorCtrlFRPY, controller=controller)
    angles = [0.0, 0.0, 0.0]
    angles[axis] = 0.2
    control.command(control.weight, *angles)
    world.run(0.9)
    found = mean_over(world, 0.1, lambda: control.roll_pitch_yaw)
    assert found[axis] == pytest.approx(0.2, abs=0.06)
    assert np.abs(np.delete(found, axis)).max() < 0.02
    assert np.round(control.velocity[:2] / 1.5).tolist() == pytest.approx(flies_to)


def test_yaw_beyond_half_a_turn_is_the_same_heading():
    _, control = flown_by(MotorCtrlFRPY)
    control.command(0.3, 0.0, 0.0, 1.5 * math.pi)
    assert control.drone.struct.onboard.client_setpoint.attitude.yaw == pytest.approx(-90.0)


def test_velocity_is_that_of_the_world_whatever_the_heading():
    world, control = flown_by(MotorCtrlVel, yaw_deg=90.0)
    control.command(0.0, 0.0, 0.5)
    world.run(1.5)
    control.command(0.4, 0.0, 0.0, yaw_rate=0.5)
    world.run(2.5)
    # the firmware's velocity loop has little integral against drag
    assert mean_over(world, 0.2, lambda: control.velocity) == pytest.approx([0.35, 0.0, 0.0], abs=0.06)
    assert control.body_rates[2] == pytest.approx(0.5, abs=0.05)


def test_a_velocity_of_zero_is_kept_alive():
    """The original sent nothing when nearly still, and the watchdog took the drone down."""
    world, control = flown_by(MotorCtrlVel)
    control.command(0.0, 0.0, 0.4)
    world.run(1.5)
    control.command(0.0, 0.0, 0.0)
    world.run(3.0)
    assert control.drone.supervisor_state == "Flying"
    assert np.linalg.norm(control.velocity) < 0.05


def test_a_point_is_flown_to_from_the_floor_and_again_in_flight():
    world, control = flown_by(MotorCtrlXYZ)
    control.command(0.0, 0.4, 0.6, 1.5)
    world.run(0.75)
    before = control.drone.log["ctrltarget.vz"]
    control.command_point([0.3, 0.0, 0.8], 2.0, yaw=0.5)
    world.run(0.02)
    # the plan goes on with the velocity that it had
    assert before > 0.5
    assert control.drone.log["ctrltarget.vz"] == pytest.approx(before, rel=0.05)
    assert not control.is_there
    world.run(4.0)
    assert control.is_there
    assert control.position == pytest.approx([0.3, 0.0, 0.8], abs=0.08)
    assert control.roll_pitch_yaw[2] == pytest.approx(0.5, abs=0.05)


def test_a_point_before_the_drone_can_fly_is_refused():
    control = World([DroneConfig("cf1", motor_ctrl=MotorCtrlXYZ)]).drones[0].motor_ctrl
    with pytest.raises(StateError, match="cf1: MotorCtrlXYZ: command: the motors may not run, state 'Not init"):
        control.command(0.0, 0.0, 1.0, 1.0)


@pytest.mark.parametrize("cls", [MotorCtrlFPQR, MotorCtrlFRPY, MotorCtrlVel])
def test_a_twist_says_the_same(cls):
    drone = World([DroneConfig("cf1", motor_ctrl=cls)]).drones[0]
    setpoint = drone.struct.onboard.client_setpoint
    sent = {
        MotorCtrlFPQR: lambda: (setpoint.thrust, setpoint.attitudeRate.roll, -setpoint.attitudeRate.pitch),
        MotorCtrlFRPY: lambda: (setpoint.thrust, setpoint.attitude.roll, -setpoint.attitude.pitch),
        MotorCtrlVel: lambda: (setpoint.velocity.x, setpoint.velocity.z, setpoint.attitudeRate.yaw),
    }[cls]
    drone.motor_ctrl.cmd_vel((0.1, 0.2, 0.3), (0.4, 0.5, 0.6))
    by_twist = sent()
    drone.motor_ctrl.command(*(0.1, 0.2, 0.3, 0.6) if cls is MotorCtrlVel else (0.3, 0.4, 0.5, 0.6))
    assert by_twist == sent()
    assert all(by_twist)


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), "0.3", None, [0.1, 0.2], True, 1j])
@pytest.mark.parametrize("cls", [MotorCtrlFPQR, MotorCtrlFRPY, MotorCtrlVel, MotorCtrlXYZ])
def test_what_is_no_number_is_refused_by_name(cls, bad):
    drone = World([DroneConfig("cf1", motor_ctrl=cls)]).drones[0]
    before = drone.memory.copy()
    with pytest.raises(RangeError, match=rf"cf1: {cls.__name__}: command: \w+ is .*, allowed: a finite number"):
        drone.motor_ctrl.command(0.1, bad, 0.3, 0.4)
    assert (drone.memory == before).all()


def test_numbers_of_numpy_are_numbers():
    control = World([DroneConfig("cf1", motor_ctrl=MotorCtrlFPQR)]).drones[0].motor_ctrl
    control.command(np.float32(0.3), np.array([0.1]), np.int64(0), 0)
    with pytest.raises(RangeError, match="angular is"):
        control.cmd_vel((0, 0, 1), (1, 2))


def test_the_parent_knows_no_twist():
    control = World([DroneConfig("cf1", motor_ctrl=MotorCtrl)]).drones[0].motor_ctrl
    with pytest.raises(StateError, match="cf1: MotorCtrl: cmd_vel: this class takes no such command"):
        control.cmd_vel((0, 0, 1), (0, 0, 0))


@pytest.mark.parametrize(
    ("cls", "controller"),
    [(MotorCtrlFPQR, "lee"), (MotorCtrlFPQR, "indi"), (MotorCtrlVel, "mellinger"), (MotorCtrlFRPY, "brescianini")],
)
def test_a_controller_that_ignores_these_setpoints_is_refused(cls, controller):
    with pytest.raises(RangeError, match=rf"cf1: {cls.__name__}: controller is '{controller}', allowed: pid"):
        World([DroneConfig("cf1", controller=controller, motor_ctrl=cls)])


def test_a_plan_that_the_reset_after_a_landing_would_drop_is_refused():
    """docs/reference/planner-commander.md#14.3: Landed becomes Reset after 3 s, unless motors turn by then."""
    world, control = flown_by(MotorCtrlXYZ)
    control.command(0.0, 0.0, 0.5, 1.0)
    world.run(2.0)
    control.drone.high_level_commander.land(0.0, 1.0)
    world.run(1.0)
    control.drone.high_level_commander.stop()
    supervisor = control.drone.struct.onboard.supervisor
    while control.drone.supervisor_state != "Landed":
        world.run(0.01)
    world.step(supervisor.landing_tick + 3000 - 45 - control.drone.struct.onboard.tick)
    in_time = world.snapshot()
    control.command(0.0, 0.0, 0.5, 1.0)
    world.run(3.0)
    assert control.position[2] == pytest.approx(0.5, abs=0.1)
    world.restore(in_time)
    world.step(6)
    with pytest.raises(StateError, match="the supervisor is about to reset on the floor and would drop this plan"):
        control.command(0.0, 0.0, 0.5, 1.0)
    world.run(0.3)
    control.command(0.0, 0.0, 0.5, 1.0)
    world.run(3.0)
    assert control.position[2] == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize("wait_ms", range(-60, 140, 10))
def test_no_plan_is_lost_to_the_reset_of_who_waits_on_the_floor(wait_ms):
    """30 s after it became ready, a drone cannot be commanded for some 80 ms.

    docs/reference/planner-commander.md#14.6.
    """
    world, control = flown_by(MotorCtrlXYZ)
    supervisor = control.drone.struct.onboard.supervisor
    supervisor.prefltTimeout = 1000
    world.step(supervisor.arming_tick + 1040 + wait_ms - world.tick)
    for _ in range(30):
        try:
            control.command(0.0, 0.0, 0.5, 1.0)
        except StateError:
            world.run(0.01)
        else:
            break
    world.run(3.0)
    assert control.position[2] == pytest.approx(0.5, abs=0.1)
