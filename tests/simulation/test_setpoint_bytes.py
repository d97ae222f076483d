"""A setpoint as bytes, as programs and journals hand it over."""

import pytest

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.simulation import DroneConfig, World


@pytest.fixture(scope="module")
def drone():
    world = World([DroneConfig("cf1")])
    world.wait_until_ready()
    return world.drones[0]


def setpoint(**members):
    made = ffi.new("setpoint_t *")
    made.mode.z = lib.modeVelocity
    made.velocity.z = 0.5
    for name, value in members.items():
        setattr(made, name, value)
    return made


def as_bytes(made):
    return bytes(ffi.buffer(made))


def test_it_reaches_the_commander_whole(drone):
    data = as_bytes(setpoint(thrust=1234.5, timestamp=77))
    assert drone.uplink.request("setpoint", data) == lib.CF_OK
    assert bytes(ffi.buffer(ffi.addressof(drone.struct.onboard, "client_setpoint"))) == data
    # the commander stamps its own copy with its own clock
    assert drone.struct.onboard.commander.setpoint.timestamp == drone.struct.onboard.tick


def broken():
    wrong_mode = setpoint()
    ffi.cast("int *", ffi.addressof(wrong_mode, "mode"))[2] = 3
    wrong_truth = bytearray(as_bytes(setpoint()))
    wrong_truth[ffi.offsetof("setpoint_t", "velocity_body")] = 2
    return {
        "short": as_bytes(setpoint())[:-1],
        "long": as_bytes(setpoint()) + b"\0",
        "empty": b"",
        "not finite": as_bytes(setpoint(thrust=float("nan"))),
        "mode": as_bytes(wrong_mode),
        "truth": bytes(wrong_truth),
    }


@pytest.mark.parametrize("name", list(broken()))
def test_what_is_none_is_refused_and_changes_nothing(drone, name):
    before = drone.memory.copy()
    assert drone.uplink.request("setpoint", broken()[name]) == lib.CF_ERR_VALUE
    assert (drone.memory == before).all()


def test_a_failed_pilot_locks_the_drone_until_it_reboots():
    drone = World([DroneConfig("cf1")]).drones[0]
    drone.uplink.dispatch("cf_fail_pilot", b"a reason " * 40)
    drone.uplink.dispatch("cf_fail_pilot", b"another")
    assert drone.is_locked
    assert drone.failure.startswith("cf1: its motor control failed: a reason a reason")
    assert len(ffi.string(drone.struct.onboard.failure)) == lib.CF_FAILURE_BYTES - 1
    assert "a reason" in drone.console
    drone.reboot()
    assert drone.failure is None
