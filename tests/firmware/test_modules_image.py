"""Drones that fly the firmware's own modules: their memory is theirs, and nothing of it is elsewhere."""

import numpy as np
import pytest
from level_flights import airborne, world_of

from crazychoir_fw.firmware.levels import ALGORITHMS, MODULES, STABILIZER
from crazychoir_fw.simulation.world import set_threads

NEWEST = "2026.08"


@pytest.fixture
def every_word(level_word):
    """One provider of each kind."""
    return ["builtin", *(level_word(NEWEST, level) for level in (ALGORITHMS, MODULES, STABILIZER))]


@pytest.fixture(autouse=True)
def one_thread():
    yield
    set_threads(1)


def busy(world, seconds=1.5):
    """Fly on, every drone its own plan, and return all that the world is then."""
    for i, drone in enumerate(world.drones):
        drone.high_level_commander.go_to(0.3, 0.1 * i, 0.1, 0.5, duration_s=1.0, relative=True)
    world.run(seconds)
    return bits(world)


def bits(world):
    """Return what the world is, and what every drone tells: the blocks themselves hold addresses."""
    told = [[drone.log[name] for name in sorted(drone.log)] for drone in world.drones]
    kept = [[drone.param[name] for name in sorted(drone.param)] for drone in world.drones]
    motion = [world.data.qpos.tolist(), world.data.qvel.tolist(), world.data.act.tolist()]
    return repr([motion, told, kept, [drone.console for drone in world.drones]])


def test_snapshot_in_flight_brings_back_the_future(every_word):
    world = airborne(*every_word)
    snapshot = world.snapshot()
    first = busy(world)
    world.restore(snapshot)
    assert busy(world) == first
    # also in another world, whose drones are elsewhere
    other = world_of(*every_word)
    other.run(0.7)
    other.restore(snapshot)
    assert busy(other) == first


def test_snapshot_at_boot_brings_back_the_start(every_word):
    world = world_of(*every_word, positioning="lighthouse")
    world.run(1.2)  # measurements wait, since no loop runs yet
    snapshot = world.snapshot()
    world.run(2.5)
    first = bits(world)
    other = world_of(*every_word, positioning="lighthouse")
    other.run(1.3)
    other.restore(snapshot)
    other.run(2.5)
    assert bits(other) == first


def test_fork_in_flight_goes_its_own_way(every_word):
    world = airborne(*every_word)
    fork, other = world.fork(2)
    drone = other.drones[0]
    for drone in other.drones:
        drone.emergency_stop()
    other.run(1.5)
    future = busy(world)
    assert busy(fork) == future
    assert all(drone.is_locked for drone in other.drones)
    assert not any(drone.is_locked for drone in (*world.drones, *fork.drones))


def test_threads_change_no_bit(every_word):
    words = [*every_word, *every_word[2:]]
    found = []
    for threads in (1, 2):
        world = airborne(*words, threads=threads)
        found.append(busy(world))
    assert found[0] == found[1]


def test_two_flights_are_the_same_bit_by_bit(every_word):
    worlds = [airborne(*every_word) for _ in range(2)]
    assert busy(worlds[0]) == busy(worlds[1])


def test_each_flies_in_company_as_alone(every_word):
    """The noise of a drone depends on its index, so that the swarm has others, which stay on the floor.

    Whether they touch the floor shows in the last bits of the solver of the engine.
    """
    together = airborne(*every_word)
    busy(together)
    for place, word in enumerate(every_word):
        words = ["builtin"] * len(every_word)
        words[place] = word
        alone = world_of(*words)
        alone.wait_until_ready()
        drone = alone.drones[place]
        drone.high_level_commander.takeoff(absolute_height_m=0.5, duration_s=1.5)
        alone.run(2.0)
        drone.high_level_commander.go_to(0.3, 0.1 * place, 0.1, 0.5, duration_s=1.0, relative=True)
        alone.run(1.5)
        np.testing.assert_allclose(drone.true_position, together.drones[place].true_position, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(
            drone.estimated_position, together.drones[place].estimated_position, rtol=0.0, atol=1e-9
        )


def test_reset_of_a_world_begins_the_same_flight(every_word):
    world = airborne(*every_word)
    first = busy(world)
    world.reset()
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(absolute_height_m=0.5, duration_s=1.5)
    world.run(2.0)
    assert busy(world) == first
