"""Flights that begin in the air: what a copied drone knows, what it keeps, and what is refused."""

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.simulation import DroneConfig, World


@pytest.fixture(scope="module")
def flying():
    world = World([DroneConfig("a"), DroneConfig("b", (1.0, 0.0))], seed=2, visuals=False)
    world.wait_until_ready()
    world.drones[0].high_level_commander.takeoff(0.6, 1.0)
    world.run(2.0)
    return world


def start_of(**changes):
    numbers = {"position": (2, 1, 3), "quat_wxyz": (0.8, 0.6, 0, 0), "velocity": (1, 0, 0), "rates": (0, 2, 0)}
    return ffi.new("cf_flight_start_t *", {**numbers, "seed": 5, "id": 0, **changes})


def test_the_copy_knows_where_it_is_and_the_pattern_stays(flying):
    pattern, copy = (drone.struct for drone in flying.drones)
    before = bytes(flying.drones[0].memory)
    assert lib.cf_start_flight(copy, pattern, start_of()) == lib.CF_OK
    assert bytes(flying.drones[0].memory) == before
    estimate = copy.onboard.estimator.estimate
    assert (estimate.position.x, estimate.position.y, estimate.position.z) == (2.0, 1.0, 3.0)
    assert np.isclose(estimate.velocity.x, 1.0, atol=1e-6)
    assert np.isclose(estimate.attitude.roll, np.degrees(2 * np.arctan2(0.6, 0.8)), atol=1e-3)
    assert np.isclose(copy.onboard.sensors.data.gyro.y, np.degrees(2.0), rtol=1e-5)
    assert copy.onboard.supervisor.state == pattern.onboard.supervisor.state == lib.supervisorStateFlying
    assert list(copy.last_rates) == [0.0, 2.0, 0.0]
    assert copy.vehicle.mocap.waiting == 0


def test_equal_seeds_give_equal_noise_and_others_do_not(flying):
    pattern, copy = (drone.struct for drone in flying.drones)
    found = []
    for seed in (1, 2, 1):
        lib.cf_start_flight(copy, pattern, start_of(seed=seed))
        dice = (copy.vehicle.imu.random, copy.vehicle.mocap.random, copy.vehicle.barometer.random)
        found.append([tuple(one.state) for one in dice])
    assert found[0] == found[2] != found[1]
    assert len(set(found[0])) == 3


@pytest.mark.parametrize(
    "wrong",
    [{"position": (float("nan"), 0, 1)}, {"rates": (0, float("inf"), 0)}, {"quat_wxyz": (1, 1, 0, 0)}],
    ids=["position", "rates", "quaternion"],
)
def test_a_wrong_start_changes_nothing(flying, wrong):
    before = bytes(flying.drones[1].memory)
    pattern, copy = (drone.struct for drone in flying.drones)
    assert lib.cf_start_flight(copy, pattern, start_of(**wrong)) == lib.CF_ERR_VALUE
    assert bytes(flying.drones[1].memory) == before


def test_a_held_control_flies_in_place_of_the_controllers(flying):
    world = flying.fork()[0]
    drone = world.drones[0]
    held = drone.struct.onboard.held_control
    held.control.controlMode = lib.controlModeForce
    for motor in range(4):
        held.control.normalizedForces[motor] = 0.25 + 0.01 * motor
    held.is_on = True
    world.step(5)
    uncapped = list(drone.struct.onboard.uncapped.list)
    assert uncapped == [int((np.float32(0.25 + 0.01 * motor)) * 65535) for motor in range(4)]
    held.is_on = False
    world.step(5)
    assert drone.struct.onboard.control.controlMode == lib.controlModeLegacy
