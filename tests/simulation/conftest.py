"""Worlds that the tests of the simulation share."""

import pytest

from crazychoir_fw.simulation import DroneConfig, World, set_threads


def make_world(count=1, **options):
    """Return a world with drones half a meter apart."""
    places = [(0.5 * i, 0.0) for i in range(count)]
    return World([DroneConfig(f"cf{i + 1}", place) for i, place in enumerate(places)], **options)


@pytest.fixture
def ready_world():
    """One drone on the floor that can fly."""
    world = make_world()
    world.wait_until_ready()
    return world


@pytest.fixture
def hovering_world():
    """One drone hovering at 0.5 m."""
    world = make_world()
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
