"""What every handler sends, byte for byte (docs/reference/crtp-cflib.md#12 to #14 and #21)."""

import math
import struct

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.radio import (
    Mode,
    RadioHandler,
    RadioHandlerFPQR,
    RadioHandlerFRPY,
    RadioHandlerVel,
    RadioHandlerVelLightHouse,
    RadioHandlerXYZ,
)

STOP = [(7, 0, "00"), (8, 0, "03 00")]
STOP_AGAIN = [(7, 0, "00")]
RELEASE = [(7, 1, "00 00 00 00 00")]
ZERO = struct.pack("<fffH", 0.0, -0.0, 0.0, 0).hex(" ")


def rpyt(roll, pitch, yaw, thrust):
    return [(3, 0, struct.pack("<fffH", roll, pitch, yaw, thrust).hex(" "))]


def velocity(vx, vy, vz, yaw_rate):
    return [(7, 0, struct.pack("<Bffff", 8, vx, vy, vz, yaw_rate).hex(" "))]


def test_thrust_and_rates(fly, air):
    swarm = fly(RadioHandlerFPQR)
    swarm.takeoff()
    assert air["fake://0"].take() == [(3, 0, ZERO)]
    assert swarm.command(0, 0.24, math.radians(10), math.radians(20), math.radians(30))
    # right stays, nose down is negative on board, and left is negative in the packet
    assert air["fake://0"].take() == rpyt(10, -20, -30, 32768)


def test_thrust_and_angles(fly, air):
    swarm = fly(RadioHandlerFRPY, thrust="cf21bl")
    swarm.takeoff()
    air["fake://0"].take()
    assert swarm.command(0, 0.2, math.radians(10), math.radians(20), math.radians(200))
    (packet,) = air["fake://0"].take()
    roll, pitch, yaw, thrust = struct.unpack("<fffH", bytes.fromhex(packet[2]))
    assert (roll, pitch, yaw) == pytest.approx((10, -20, -160))
    assert thrust == 16384


@pytest.mark.parametrize(
    ("newtons", "raw"), [(-1.0, 0), (0.0, 0), (0.007, 0), (0.0075, 1024), (0.12, 16384), (0.48, 60000), (9.0, 60000)]
)
def test_thrust_is_kept_in_what_the_drone_takes(fly, air, newtons, raw):
    swarm = fly(RadioHandlerFPQR)
    swarm.takeoff()
    air["fake://0"].take()
    swarm.command(0, newtons, 0, 0, 0)
    assert struct.unpack("<H", bytes.fromhex(air["fake://0"].take()[0][2])[-2:])[0] == raw


def test_the_calibration_of_the_original_can_be_had(fly, air):
    swarm = fly(RadioHandlerFPQR, thrust=[(0, 0), (0.39, 42000)], weight=0.29)
    swarm.takeoff()
    air["fake://0"].take()
    swarm.command(0, 0.3, 0, 0, 0)
    assert struct.unpack("<H", bytes.fromhex(air["fake://0"].take()[0][2])[-2:])[0] == round(0.3 * 42000 / 0.39)


def test_rates_and_angles_are_limited(fly, air):
    rates = fly(RadioHandlerFPQR)
    rates.takeoff()
    air["fake://0"].take()
    rates.command(0, 0.12, 100, -100, 100)
    assert air["fake://0"].take() == rpyt(720, 720, -450, 16384)
    rates.close()
    angles = fly(RadioHandlerFRPY, max_tilt=math.radians(30))
    angles.takeoff()
    air["fake://0"].take()
    angles.command(0, 0.12, -1.5, 1.5, 0)
    assert air["fake://0"].take() == rpyt(-30, -30, 0, 16384)


@pytest.mark.parametrize("handler", [RadioHandlerFPQR, RadioHandlerFRPY])
def test_thrust_is_locked_before_takeoff(fly, air, handler):
    swarm = fly(handler)
    assert not swarm.command(0, 0.3, 0, 0, 0)
    assert air["fake://0"].take() == []
    swarm.takeoff()
    assert swarm.command(0, 0.3, 0, 0, 0)
    swarm.stop()
    swarm.resume()
    assert swarm[0].mode is Mode.LOCKED
    assert not swarm.command(0, 0.3, 0, 0, 0)


def test_takeoff_with_a_height_flies_by_the_planner_first(fly, air, clock):
    swarm = fly(RadioHandlerFPQR)
    swarm.takeoff(0.5, 2.0)
    climb = struct.pack("<BBff?f", 7, 0, 0.5, 0.0, True, 2.0).hex(" ")
    # the zero of the lock comes before the planner has the commander, or it would stop it
    assert air["fake://0"].take() == [(3, 0, ZERO), *RELEASE, (8, 0, climb)]
    assert not swarm.command(0, 0.3, 0, 0, 0)
    clock.now += 2.0
    swarm.tick()
    assert swarm.command(0, 0.3, 0, 0, 0)


def test_velocity(fly, air):
    swarm = fly(RadioHandlerVel)
    assert swarm.command(0, 0.25, -0.5, 0.125, math.pi / 2)
    assert air["fake://0"].take() == velocity(0.25, -0.5, 0.125, 90.0)


def test_no_velocity_is_a_command_too(fly, air):
    swarm = fly(RadioHandlerVel)
    assert swarm.command(0, 0.0, 0.0, 0.0)
    assert air["fake://0"].take() == velocity(0, 0, 0, 0)


def test_velocity_is_limited(fly, air):
    swarm = fly(RadioHandlerVel, max_speed=0.5, max_yaw_rate=1.0)
    swarm.command(0, 2.0, -2.0, 0.25, -3.0)
    assert air["fake://0"].take() == velocity(0.5, -0.5, 0.25, -math.degrees(1.0))


def test_old_firmware_gets_the_old_packet(fly, air):
    air["fake://0"].protocol = 8
    swarm = fly(RadioHandlerVel)
    with pytest.warns(DeprecationWarning):
        swarm.command(0, 1.0, 0.0, 0.0, math.radians(10))
    assert air["fake://0"].take() == [(7, 0, struct.pack("<Bffff", 1, 1.0, 0, 0, -10.0).hex(" "))]


def test_go_to_with_yaw(fly, air):
    swarm = fly(RadioHandlerXYZ)
    assert swarm.command(0, 1.0, 2.0, 3.0, 2.0, yaw=0.5)
    assert air["fake://0"].take() == [(8, 0, struct.pack("<BBBBfffff", 12, 0, 0, 0, 1, 2, 3, 0.5, 2).hex(" "))]
    assert swarm[0].command_point(np.array([1.0, 2.0, 3.0]), 2.0)
    assert air["fake://0"].take() == [(8, 0, struct.pack("<BBBBfffff", 12, 0, 0, 0, 1, 2, 3, 0, 2).hex(" "))]


@pytest.mark.parametrize("handler", [RadioHandlerVel, RadioHandlerXYZ])
def test_takeoff_and_landing_by_the_planner(fly, air, clock, handler):
    swarm = fly(handler)
    swarm.takeoff(0.5, 1.5)
    climb = struct.pack("<BBff?f", 7, 0, 0.5, 0.0, True, 1.5).hex(" ")
    assert air["fake://0"].take() == [*RELEASE, (8, 0, climb)]
    assert swarm[0].mode is Mode.TAKING_OFF
    clock.now += 1.5
    swarm.tick()
    assert swarm[0].mode is Mode.READY
    swarm.land(0.0, 2.0)
    down = struct.pack("<BBff?f", 8, 0, 0.0, 0.0, True, 2.0).hex(" ")
    assert air["fake://0"].take() == [(8, 0, down)]
    assert not swarm.command(0, 0.1, 0.1, 0.1, 1.0)
    clock.now += 2.5
    swarm.tick()
    assert swarm[0].mode is Mode.LANDED
    swarm.resume()
    assert swarm.command(0, 0.1, 0.1, 0.1, 1.0)


def test_the_planner_gets_the_commander_back_before_it_lands(fly, air):
    swarm = fly(RadioHandlerVel)
    swarm.command(0, 0.0, 0.0, 0.5)
    air["fake://0"].take()
    swarm.land()
    assert [packet[:2] for packet in air["fake://0"].take()] == [(7, 1), (8, 0)]


@pytest.mark.parametrize("handler", [RadioHandlerFPQR, RadioHandlerFRPY, RadioHandlerVel, RadioHandlerXYZ])
def test_stop_lasts_until_resume(fly, air, clock, handler):
    swarm = fly(handler)
    swarm.takeoff()
    clock.now += 3.0
    swarm.tick()
    air["fake://0"].take()
    swarm.stop()
    assert air["fake://0"].take()[:3] == STOP + STOP_AGAIN
    assert swarm[0].is_stopped
    clock.now += 1.0
    assert not swarm.command(0, 0.3, 0.1, 0.1, 1.0)
    swarm.tick()
    assert air["fake://0"].take() == STOP_AGAIN
    swarm.resume()
    assert not swarm[0].is_stopped
    assert air["fake://0"].take() == RELEASE
    clock.now += 10.0
    swarm.tick()
    assert air["fake://0"].take() == []


def test_a_drone_that_must_be_armed_is_armed_and_disarmed(fly, air, clock):
    air["fake://0"].bits = 1
    swarm = fly(RadioHandlerVel)
    swarm.takeoff(0.5, 1.0)
    assert air["fake://0"].take()[0] == (9, 1, "01 01")
    clock.now += 1.0
    swarm.tick()
    swarm.land(0.0, 1.0)
    air["fake://0"].take()
    clock.now += 2.0
    swarm.tick()
    swarm.tick()
    assert air["fake://0"].take() == [(9, 1, "01 00")]
    swarm.takeoff()
    air["fake://0"].take()
    swarm.stop()
    assert (9, 1, "01 00") in air["fake://0"].take()


def test_the_first_velocity_arms(fly, air):
    air["fake://0"].bits = 1
    swarm = fly(RadioHandlerVel)
    swarm.command(0, 0, 0, 0.5)
    assert (9, 1, "01 01") in air["fake://0"].take()


@pytest.mark.parametrize(
    ("bits", "why"),
    [
        (0b1000000, "it is locked, and must be restarted"),
        (0b100000, "it has tumbled"),
        (1 << 7, "recover"),
        (1, "not armed"),
    ],
)
def test_a_drone_that_may_not_fly_says_why(fly, air, bits, why):
    air["fake://0"].bits = bits
    swarm = fly(RadioHandlerXYZ, ready_timeout_s=0.0, arms=False)
    with pytest.raises(StateError, match=rf"agent_0 \(fake://0\): the motors may not run: .*{why}"):
        swarm.takeoff()
    with pytest.raises(StateError, match=why):
        swarm.command(0, 0, 0, 1, 1)
    assert air["fake://0"].take() == []


def test_one_drone_that_may_not_fly_keeps_no_other_on_the_floor(fly, air):
    swarm = fly(RadioHandlerXYZ, 3)
    air["fake://1"].bits = 1 << 6
    with pytest.raises(StateError, match="agent_1"):
        swarm.takeoff()
    assert [bool(air[f"fake://{i}"].take()) for i in range(3)] == [True, False, True]


def test_recovery(fly, air):
    fly(RadioHandlerVel).recover()
    assert air["fake://0"].take() == [(9, 1, "02")]


def test_emergency_stop(fly, air):
    swarm = fly(RadioHandlerVel)
    swarm.emergency_stop()
    sent = air["fake://0"].take()
    # disarmed after it: one that has just landed looks for neither until it is disarmed
    assert sent.index((9, 1, "03")) < sent.index((9, 1, "01 00"))


def test_a_twist_says_the_same(fly, air, clock):
    rates = fly(RadioHandlerFPQR)
    rates.takeoff()
    air["fake://0"].take()
    rates.cmd_vel(0, (0, 0, 0.24), np.radians([10, 20, 30]))
    assert air["fake://0"].take() == rpyt(10, -20, -30, 32768)
    rates.close()
    speeds = fly(RadioHandlerVel)
    air["fake://0"].take()
    speeds.cmd_vel(0, (0.25, -0.5, 0.125), (0, 0, math.pi / 2))
    assert air["fake://0"].take() == velocity(0.25, -0.5, 0.125, 90.0)


def test_pose_from_outside(fly, air):
    swarm = fly(RadioHandlerVel)
    assert swarm.external_pose(0, (1, 2, 3), (0, 0, 0, 2))
    assert air["fake://0"].take() == [(6, 1, struct.pack("<Bfffffff", 8, 1, 2, 3, 0, 0, 0, 1).hex(" "))]
    np.testing.assert_array_equal(swarm[0].position, (1, 2, 3))


def test_position_from_outside(fly, air):
    swarm = fly(RadioHandlerVel)
    assert swarm.external_pose(0, (1, 2, 3))
    assert air["fake://0"].take() == [(6, 0, struct.pack("<fff", 1, 2, 3).hex(" "))]


@pytest.mark.parametrize(
    ("position", "quat"),
    [((0, 0, 0), (0, 0, 0, 0)), ((math.nan, 0, 0), (0, 0, 0, 1)), ((1, 2, 3), (0, 0, math.inf, 1))],
)
def test_a_body_that_was_not_seen_is_not_forwarded(fly, air, position, quat):
    swarm = fly(RadioHandlerVel)
    assert not swarm.external_pose(0, position, quat)
    assert air["fake://0"].take() == []
    assert swarm[0].dropped_poses == 1


def test_drones_that_position_themselves_get_no_poses(fly, air):
    swarm = fly(RadioHandlerVelLightHouse)
    assert not swarm.external_pose(0, (1, 2, 3), (0, 0, 0, 1))
    assert air["fake://0"].take() == []


@pytest.mark.parametrize(
    ("handler", "values"), [(RadioHandlerFPQR, 4), (RadioHandlerFRPY, 4), (RadioHandlerVel, 4), (RadioHandlerXYZ, 5)]
)
@pytest.mark.parametrize("bad", [math.nan, math.inf, "1", None])
def test_what_is_no_number_is_refused_by_name(fly, air, handler, values, bad):
    swarm = fly(handler)
    with pytest.raises(RangeError, match=r"agent_0 \(fake://0\): command: \w+ is .*allowed: a finite number"):
        swarm.command(0, *([0.1] * (values - 1)), bad)
    assert air["fake://0"].take() == []


def test_a_handler_without_commands_says_so(fly):
    swarm = fly(RadioHandler)
    with pytest.raises(StateError, match="takes no commands"):
        swarm.command(0, 1.0)
    with pytest.raises(StateError, match="takes no such commands"):
        swarm.cmd_vel(0, (0, 0, 0), (0, 0, 0))


def test_every_drone_gets_its_own_command(fly, air):
    swarm = fly(RadioHandlerVel, 3)
    swarm.command("agent_1", 0.5, 0, 0)
    assert [len(air[f"fake://{i}"].take()) for i in range(3)] == [0, 1, 0]
    assert swarm.command_all(0, 0, 0.5) == {"agent_0": True, "agent_1": True, "agent_2": True}
    # the second one came in the same instant as its first
    assert [len(air[f"fake://{i}"].take()) for i in range(3)] == [1, 0, 1]
    assert swarm["agent_1"] is swarm[1]
    assert len(swarm) == 3
    assert "agent_2" in swarm
    assert 3 not in swarm
