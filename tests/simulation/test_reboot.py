"""A reboot: the onboard software starts over, the vehicle goes on."""

import numpy as np
import pytest
from worlds import make_world

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.onboard.variables import factory_values, parameter_table
from crazychoir_fw.simulation import DroneConfig, World

START = {"kalman.initialX", "kalman.initialY", "kalman.initialZ", "kalman.initialYaw"}
CAMERAS = {"locSrv.extPosStdDev": 0.003, "locSrv.extQuatStdDev": 0.04}  # their client writes these again


def software(cf) -> bytes:
    """Return every byte of the onboard software and of its provider."""
    return bytes(ffi.buffer(ffi.addressof(cf, "onboard"))) + bytes(ffi.buffer(ffi.addressof(cf, "provider_state")))


def fresh_boot(cf):
    """Return a drone of the same configuration that has just been switched on."""
    fresh = ffi.new("cf_t *")
    assert lib.cf_init(fresh, ffi.addressof(cf, "config")) == lib.CF_OK
    return fresh


def change_all_parameters(drone) -> int:
    """Write a new value into every parameter that a client may write; returns how many there are."""
    writable = [row for row in parameter_table().values() if not row.is_read_only]
    for row in writable:
        value = drone.param[row.name]
        drone.param[row.name] = 0.5 * value + 0.25 if row.dtype.kind == "f" else int(value == 0)
    return len(writable)


def changed_parameters(world, drone):
    assert change_all_parameters(drone) > 150


def uploaded_trajectories(world, drone):
    pieces = np.zeros((31, 33))
    pieces[:, 0], pieces[:, 32] = np.arange(31), 1.0
    for k in range(31):
        drone.high_level_commander.upload_trajectory(k, pieces[: 31 - k])
    drone.high_level_commander.start_trajectory(0, relative_position=True)
    world.run(0.3)


def locked(world, drone):
    drone.high_level_commander.takeoff(0.5, 1.0)
    world.run(0.8)
    drone.emergency_stop()
    world.run(0.5)
    assert drone.is_locked


def lost_motion(world, drone):
    drone._qvel[1] = np.nan
    world.run(0.1)
    assert drone.failure is not None


def flown_low_level(world, drone):
    for _ in range(100):
        drone.commander.send_hover_setpoint(0.1, 0.1, 20.0, 0.4)
        world.run(0.02)
    drone.send_extpos(0.0, 0.0, 0.1)
    assert drone.is_flying


def other_controller_and_estimator(world, drone):
    drone.param["stabilizer.controller"] = 2
    drone.param["stabilizer.estimator"] = 1
    world.run(0.2)


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
@pytest.mark.parametrize(
    "life",
    [
        changed_parameters,
        uploaded_trajectories,
        locked,
        lost_motion,
        flown_low_level,
        other_controller_and_estimator,
    ],
)
def test_reboot_makes_the_software_byte_for_byte_that_of_a_fresh_boot(life, platform):
    world = World([DroneConfig("cf1", (0.5, -0.25), yaw_deg=30.0, platform=platform)], seed=4)
    world.wait_until_ready()
    drone = world.drones[0]
    fresh = software(fresh_boot(drone.struct))
    life(world, drone)
    assert software(drone.struct) != fresh

    vehicle = bytes(ffi.buffer(ffi.addressof(drone.struct, "vehicle")))
    config = bytes(ffi.buffer(ffi.addressof(drone.struct, "config")))
    drone.reboot()
    assert software(drone.struct) == fresh
    # battery, rotors, sensor biases and dice stay as they are
    assert bytes(ffi.buffer(ffi.addressof(drone.struct, "vehicle"))) == vehicle
    assert bytes(ffi.buffer(ffi.addressof(drone.struct, "config"))) == config


def test_reboot_brings_every_parameter_back_to_its_factory_value():
    world = World([DroneConfig("cf1", (0.5, 0.0), platform="cf21bl")])
    drone = world.drones[0]
    change_all_parameters(drone)
    drone.reboot()
    factory = factory_values("cf21bl", parameter_table())
    assert CAMERAS.keys() <= factory.keys()
    factory |= {name: np.float32(value) for name, value in CAMERAS.items()}
    assert {n: drone.param[n] for n in factory if n not in START} == {
        n: v for n, v in factory.items() if n not in START
    }
    assert drone.param["kalman.initialX"] == 0.5  # the place of its start, told by the plugin


def test_reboot_leaves_the_battery_as_empty_as_it_is():
    world = World([DroneConfig("cf1", battery=0.4)])
    world.wait_until_ready()
    drone = world.drones[0]
    drone.high_level_commander.takeoff(0.5, 1.0)
    world.run(3.0)
    charge, rpm = drone.log["sim.charge"], drone.log["sim.rpm1"]
    assert charge < 0.4
    assert rpm > 15000
    drone.reboot()
    assert drone.log["sim.charge"] == charge
    assert drone.log["sim.rpm1"] == rpm
    world.run(0.1)
    assert [drone.log[f"motor.m{i}"] for i in (1, 2, 3, 4)] == [0, 0, 0, 0]
    assert 0 < drone.log["sim.rpm1"] < rpm  # they run down


def test_drone_flies_again_after_a_reboot_in_the_middle_of_a_flight():
    world = make_world(2)
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(0.5, 1.0)
    world.run(2.0)
    first, second = world.drones
    first.reboot()
    world.run(1.5)
    assert first.true_position[2] < 0.03
    assert second.true_position[2] == pytest.approx(0.5, abs=0.1)
    world.wait_until_ready()
    first.high_level_commander.takeoff(0.5, 1.0)
    world.run(3.0)
    assert first.true_position[2] == pytest.approx(0.5, abs=0.1)
