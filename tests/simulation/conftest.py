"""Worlds that the tests of the simulation share."""

import pytest
from worlds import make_world

from crazychoir_fw.simulation import set_threads


@pytest.fixture
def ready_world():
    """One drone on the floor that can fly."""
    world = make_world()
    world.wait_until_ready()
    return world


@pytest.fixture
def hovering_world():
    """One drone hovering at 0.5 m; the cameras tell the deviations that the firmware has from the factory."""
    world = make_world()
    world.drones[0].param["locSrv.extPosStdDev"] = 0.01
    world.drones[0].param["locSrv.extQuatStdDev"] = 4.5e-3
    world.wait_until_ready()
    world.drones[0].high_level_commander.takeoff(0.5, 1.5)
    world.run(3.0)
    return world


@pytest.fixture(autouse=True)
def one_thread():
    """Every test starts with one thread."""
    set_threads(1)
    yield
    set_threads(1)
