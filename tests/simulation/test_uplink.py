"""Requests of clients on their way to a drone."""

import pytest

from crazychoir_fw.simulation import DroneConfig, FlightRecorder, World, replay


@pytest.fixture
def drone():
    world = World([DroneConfig("cf1")])
    world.wait_until_ready()
    return world.drones[0]


def test_listeners_see_every_request_as_plain_data(drone):
    heard = []
    drone.uplink.listeners.append(lambda verb, arguments: heard.append((verb, arguments)))
    drone.high_level_commander.takeoff(0.5, 1.0)
    drone.param["pid_rate.roll_kp"] = 200
    drone.commander.send_hover_setpoint(0.1, 0.0, 5.0, 0.4)
    drone.loc.send_extpos([0.0, 0.0, 0.1])
    drone.receive_packet(8, 0, bytes([6]))
    drone.place((0.0, 0.0, 0.3))
    assert [verb for verb, _ in heard] == [
        "cf_takeoff",
        "param",
        "cf_send_hover",
        "cf_send_external_position",
        "packet",
        "place",
    ]
    assert heard[1][1] == ("pid_rate.roll_kp", 200.0)


def test_what_was_heard_can_be_delivered_to_another_drone(drone):
    heard = []
    drone.uplink.listeners.append(lambda verb, arguments: heard.append((verb, arguments)))
    drone.high_level_commander.spiral(1.0, 0.2, 0.4, 0.1, 2.0)
    drone.param["pid_rate.roll_kp"] = 200
    world = World([DroneConfig("cf1")])
    world.wait_until_ready()
    other = world.drones[0]
    for verb, arguments in heard:
        other.uplink.dispatch(verb, *arguments)
    assert (other.memory == drone.memory).all()


def test_a_closed_gate_swallows_requests_and_the_client_does_not_know(drone):
    before = drone.memory.copy()
    drone.uplink.fault_filter = lambda verb, arguments: False
    drone.high_level_commander.takeoff(0.5, 1.0)
    drone.param["pid_rate.roll_kp"] = 200
    assert drone.receive_packet(8, 0, bytes([6])) is None
    assert (drone.memory == before).all()


def test_what_c_cannot_take_is_not_in_the_journal():
    world = World([DroneConfig("cf1")])
    recorder = FlightRecorder(world)
    drone = world.drones[0]
    recorder.run(0.05)
    with pytest.raises((OverflowError, TypeError)):
        drone.arm(2**70)
    with pytest.raises((OverflowError, TypeError, ValueError)):
        drone.send_extpos("x", 1, 2)
    recorder.run(0.05)
    log = recorder.finish({})
    assert len(log.journal) == 0
    assert replay(log).deviation is None
