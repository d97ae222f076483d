"""Why a drone flies no more, in one sentence."""

import pytest

from crazychoir_fw._core import lib
from crazychoir_fw.simulation import DroneConfig, World


def crash(drone):
    drone.struct.onboard.supervisor.is_crashed = True


def lock(drone):
    drone.struct.onboard.supervisor.state = lib.supervisorStateLocked


def fail(drone):
    drone.struct.onboard.fault = lib.CF_FAULT_ESTIMATE
    drone.struct.onboard.fault_tick = 3010
    lock(drone)


@pytest.mark.parametrize(
    ("happen", "sentence"),
    [
        (crash, "cf2: crashed at 4.54 s"),
        (lock, "cf2: locked up at 4.54 s"),
        (fail, "cf2: the state estimate is not a number (at 3.010 s)"),
    ],
)
def test_what_happened_and_when(happen, sentence):
    world = World([DroneConfig("cf1"), DroneConfig("cf2", (1, 0))])
    assert [drone.outage(4.54) for drone in world.drones] == [None, None]
    happen(world["cf2"])
    assert [drone.outage(4.54) for drone in world.drones] == [None, sentence]
