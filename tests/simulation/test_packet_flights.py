"""Drones flown by nothing but bytes."""

import struct

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError, StateError, UnknownNameError
from crazychoir_fw.simulation import DroneConfig, World

RPYT, LOCALIZATION, GENERIC, SUPERVISOR = 3, 6, 7, 9
HOLD = 32767  # thrust that holds the height


def stream(world, seconds: float, port: int, data: bytes) -> None:
    """Send one packet fifty times a second."""
    for _ in range(round(seconds * 50)):
        assert world.drones[0].receive_packet(port, 0, data) is None
        world.run(0.02)


def rpyt(roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0, thrust: int = HOLD) -> bytes:
    return struct.pack("<3fH", roll, pitch, yaw, thrust)


def yaw_deg(drone) -> float:
    w, x, y, z = drone.true_quat_wxyz
    return float(np.degrees(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))))


def test_hover_packets_fly_a_drone_from_the_floor_and_back(ready_world) -> None:
    drone = ready_world.drones[0]
    stream(ready_world, 3.0, GENERIC, b"\x0a" + struct.pack("<4f", 0, 0, 0, 0.5))
    assert drone.true_position == pytest.approx([0, 0, 0.5], abs=0.06)
    stream(ready_world, 3.0, GENERIC, b"\x0a" + struct.pack("<4f", 0.2, 0.1, 0, 0.5))
    assert drone.true_velocity == pytest.approx([0.2, 0.1, 0], abs=0.05)
    stream(ready_world, 2.0, GENERIC, b"\x0a" + struct.pack("<4f", 0, 0, 45.0, 0.5))
    assert np.degrees(drone.true_rates[2]) == pytest.approx(45, abs=3)
    stream(ready_world, 2.0, GENERIC, b"\x0a" + struct.pack("<4f", 0, 0, 0, 0.05))
    stream(ready_world, 0.5, GENERIC, b"\x00")
    assert drone.true_position[2] < 0.03
    assert drone.log["motor.m1"] == 0
    assert drone.failure is None


def test_legacy_hover_packets_turn_the_other_way(hovering_world) -> None:
    stream(hovering_world, 1.0, GENERIC, b"\x05" + struct.pack("<4f", 0, 0, 45.0, 0.5))
    assert np.degrees(hovering_world.drones[0].true_rates[2]) == pytest.approx(-45, abs=3)


def test_legacy_packets_hold_height_and_position(hovering_world) -> None:
    """The velocity loop starts over, so the drone sinks until its integral carries the weight again."""
    drone = hovering_world.drones[0]
    missing = drone.log["stabilizer.thrust"] - drone.param["posCtlPid.thrustBase"]
    sink = missing / 1000 / drone.param["velCtlPid.vzKi"]
    assert 0.1 < sink < 0.3

    drone.param["flightmode.althold"] = 1
    drone.param["flightmode.poshold"] = 1
    stream(hovering_world, 8.0, RPYT, rpyt())
    assert drone.true_position == pytest.approx([0, 0, 0.5 - sink], abs=0.05)
    assert drone.true_velocity == pytest.approx([0, 0, 0], abs=0.02)

    stream(hovering_world, 3.0, RPYT, rpyt(roll=3.0, pitch=9.0))
    assert drone.true_velocity == pytest.approx([0.3, 0.1, 0], abs=0.06)
    stream(hovering_world, 1.0, RPYT, rpyt(thrust=HOLD + 16384))
    assert drone.true_velocity[2] == pytest.approx(0.5, abs=0.1)


def test_legacy_packets_hold_the_height_while_the_pilot_leans(hovering_world) -> None:
    """The client negates the pitch: nose down in its own sign, forward."""
    drone = hovering_world.drones[0]
    drone.param["flightmode.althold"] = 1
    stream(hovering_world, 1.0, RPYT, rpyt(pitch=-5.0))
    assert drone.true_velocity[0] > 0.4
    assert abs(drone.true_velocity[1]) < 0.1
    assert drone.true_position[2] == pytest.approx(0.5, abs=0.08)


def test_legacy_packets_send_the_drone_to_a_position(hovering_world) -> None:
    drone = hovering_world.drones[0]
    drone.param["flightmode.posSet"] = 1
    stream(hovering_world, 4.0, RPYT, rpyt(roll=-0.3, pitch=-0.4, yaw=30.0, thrust=700))
    assert drone.true_position == pytest.approx([0.4, -0.3, 0.7], abs=0.06)
    assert yaw_deg(drone) == pytest.approx(30, abs=2)


def test_legacy_packets_hold_a_yaw_angle(hovering_world) -> None:
    drone = hovering_world.drones[0]
    for mode in ("althold", "poshold", "stabModeYaw"):
        drone.param[f"flightmode.{mode}"] = 1
    stream(hovering_world, 2.0, RPYT, rpyt(yaw=60.0))
    assert yaw_deg(drone) == pytest.approx(60, abs=2)


def test_full_state_packets_are_followed(hovering_world) -> None:
    packet = struct.pack("<B9hI3h", 6, 300, 0, 600, 0, 0, 0, 0, 0, 0, 0xC0000000, 0, 0, 0)
    stream(hovering_world, 4.0, GENERIC, packet)
    assert hovering_world.drones[0].true_position == pytest.approx([0.3, 0, 0.6], abs=0.06)


def test_remote_control_packets_lean_the_drone(hovering_world) -> None:
    """A longer pulse is a negative roll, which leans to the left, where y is positive."""
    drone = hovering_world.drones[0]
    thrust = 1000 + round(drone.log["stabilizer.thrust"] / 65.535)
    stream(hovering_world, 0.4, GENERIC, b"\x03" + struct.pack("<B4H", 0, 1600, 1500, 1500, thrust))
    assert drone.log["stateEstimate.roll"] == pytest.approx(-10, abs=3)
    assert drone.true_velocity[1] > 0.2


def test_packet_of_a_closing_client_cuts_the_motors(hovering_world) -> None:
    """docs/reference/planner-commander.md#18, quirk 1: even under the high-level commander."""
    drone = hovering_world.drones[0]
    drone.receive_packet(RPYT, 0, bytes(14))
    hovering_world.run(0.02)
    assert drone.log["motor.m1"] == 0


def test_meta_packet_hands_the_drone_to_the_high_level_commander(hovering_world) -> None:
    drone = hovering_world.drones[0]
    stream(hovering_world, 0.5, GENERIC, b"\x0a" + struct.pack("<4f", 0, 0, 0, 0.5))
    drone.receive_packet(GENERIC, 1, bytes(5))
    drone.high_level_commander.go_to(0.3, 0.0, 0.6, 0.0, 1.5)
    hovering_world.run(3.0)
    assert drone.true_position == pytest.approx([0.3, 0, 0.6], abs=0.06)


def test_brushless_is_armed_by_packet() -> None:
    world = World([DroneConfig("cf1", platform="cf21bl")])
    world.run(2.0)
    drone = world.drones[0]
    assert drone.receive_packet(SUPERVISOR, 0, b"\x04") == b"\x84\x00"
    assert drone.receive_packet(SUPERVISOR, 1, b"\x01\x01") == b"\x81\x01\x01"
    world.run(0.1)
    assert drone.receive_packet(SUPERVISOR, 0, b"\x04") == b"\x84\x01"


def test_packed_positions_hold_a_drone_without_another_system() -> None:
    """Told by its radio id; packets about another drone do not concern it."""
    config = DroneConfig("cf1", positioning="none", estimator="kalman", attributes={"radio_id": 7})
    world = World([config])
    drone = world.drones[0]

    def run(seconds: float) -> None:
        for _ in range(round(seconds * 50)):
            own = [round(1000 * value) for value in drone.true_position]
            packet = struct.pack("<B3h", 8, 9000, 9000, 9000) + struct.pack("<B3h", 7, *own)
            drone.receive_packet(LOCALIZATION, 2, packet)
            world.run(0.02)

    world.run(1.6)  # boots: the estimator listens only then
    run(1.0)
    drone.high_level_commander.takeoff(0.5, 1.5)
    run(4.0)
    assert drone.true_position == pytest.approx([0, 0, 0.5], abs=0.06)
    assert drone.log["ext_pos.Z"] == pytest.approx(drone.true_position[2], abs=0.02)


@pytest.mark.parametrize(
    ("port", "channel", "data", "error", "sentence"),
    [
        (GENERIC, 0, b"\x07\x00", RangeError, "cf1: packet '07 00' on port 7 channel 0"),
        (GENERIC, 0, b"", RangeError, "cf1: packet '' on port 7 channel 0"),
        (GENERIC, 0, bytes(31), RangeError, "cf1: packet"),
        (GENERIC, 0, b"\x07" + struct.pack("<4f", 0, 0, float("nan"), 0), RangeError, "cf1: packet"),
        (2, 0, b"\x00", UnknownNameError, "cf1: packet '00' on port 2 channel 0"),
        (16, 0, b"\x00", RangeError, "allowed: ports 0 to 15, channels 0 to 3"),
        (7, -1, b"\x00", RangeError, "allowed: ports 0 to 15, channels 0 to 3"),
    ],
)
def test_bad_packet_is_refused_in_words(ready_world, port, channel, data, error, sentence) -> None:
    drone = ready_world.drones[0]
    before = drone.memory.tobytes()
    with pytest.raises(error, match=sentence):
        drone.receive_packet(port, channel, data)
    assert drone.memory.tobytes() == before


def test_carefree_yaw_mode_is_refused_in_words(ready_world) -> None:
    drone = ready_world.drones[0]
    drone.param["flightmode.yawMode"] = 0
    with pytest.raises(StateError, match="cf1: send_setpoint"):
        drone.commander.send_setpoint(0, 0, 0, 0)
