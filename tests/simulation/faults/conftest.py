"""A drone that hovers, for tests that inject faults."""

import pytest

from crazychoir_fw.simulation import DroneConfig, World


@pytest.fixture
def hovering():
    """Return a function that gives a world in which drones hover at 1 m, at rest."""

    def make(count=1, height=1.0, seed=1, settle=4.0, scene="arena", **config):
        drones = [DroneConfig(f"cf{i + 1}", (1.0 * i, 0.0), **config) for i in range(count)]
        world = World(drones, scene=scene, seed=seed, visuals=False)
        world.wait_until_ready()
        for drone in world.drones:
            drone.high_level_commander.takeoff(height, 2.0)
        world.run(settle)
        assert all(drone.is_flying for drone in world.drones)
        return world

    return make


@pytest.fixture
def follow():
    """Return a function that steps a world and gives what was looked at on the way."""

    def run(world, seconds, look, every=10, each=lambda: None):
        seen = []
        for _ in range(round(seconds * 1000 / every)):
            each()
            world.step(every)
            seen.append(look())
        return seen

    return run
