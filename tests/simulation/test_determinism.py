"""Same seed and same commands give the same bits: on every run, at any number of threads, from any snapshot."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from worlds import make_world

import crazychoir_fw
from crazychoir_fw.simulation import DroneConfig, World, set_threads

TENTHS = 60  # of a second: the flight lasts 6 s


def command(world, i):
    """The commands of the test flight, sent at 10 Hz."""
    if i == 17:
        for k, drone in enumerate(world.drones):
            drone.high_level_commander.takeoff(0.5 + 0.1 * k, 1.5)
    if i == 45:
        world.drones[0].high_level_commander.go_to(0.3, 0.2, 0.6, 1.0, 2.0)
        world.drones[3].high_level_commander.land(0.0, 2.0)
    if i > 50:
        world.drones[1].commander.send_hover_setpoint(0.1, -0.1, 20.0, 0.7)


def fly(world, first=0, last=TENTHS):
    for i in range(first, last):
        command(world, i)
        world.run(0.1)
    return world.data.plugin_state.tobytes() + world.data.qpos.tobytes() + world.data.qvel.tobytes()


@pytest.fixture(scope="module")
def reference():
    """The bytes of all states after the flight with one thread."""
    set_threads(1)
    return fly(make_world(8, seed=7))


def test_same_seed_gives_the_same_bytes_again(reference):
    assert fly(make_world(8, seed=7)) == reference


@pytest.mark.parametrize("threads", [2])
def test_threads_do_not_change_a_bit(reference, threads):
    set_threads(threads)
    assert fly(make_world(8, seed=7)) == reference


def test_another_seed_gives_other_bytes(reference):
    assert fly(make_world(8, seed=8)) != reference


def test_flight_goes_on_alike_after_a_snapshot_of_the_world(reference):
    world = make_world(8, seed=7)
    fly(world, 0, 40)
    snapshot = world.snapshot()
    fly(world, 40, 60)
    world.restore(snapshot)
    assert fly(world, 40) == reference


def test_snapshot_may_be_restored_into_a_world_built_anew(reference):
    world = make_world(8, seed=7)
    fly(world, 0, 40)
    other = make_world(8, seed=7)
    other.restore(world.snapshot())
    assert fly(other, 40) == reference


@pytest.mark.parametrize("tenths", [14, 40])
def test_snapshot_may_be_restored_while_the_drones_rest_or_fly(reference, tenths):
    """From a snapshot on the floor into a world that flies, and the other way round."""
    world = make_world(8, seed=7)
    fly(world, 0, tenths)
    other = make_world(8, seed=7)
    fly(other, 0, 54 - tenths)
    other.restore(world.snapshot())
    assert fly(other, tenths) == reference


def test_reset_world_flies_the_same_flight(reference):
    world = make_world(8, seed=7)
    fly(world, 0, 30)
    world.reset()
    assert fly(world) == reference


def test_a_drone_in_the_air_does_not_notice_how_large_its_swarm_is():
    """Its state does not depend on the others, nor on where it stands in the world's arrays."""
    states = []
    for count in (1, 5):
        world = World([DroneConfig(f"cf{i + 1}", (0.5 * i, 0.0, 50.0)) for i in range(count)], seed=3)
        world.run(1.7)  # falls while it boots
        world.drones[0].high_level_commander.go_to(0.2, 0.0, 35.0, 0.0, 1.0)
        world.run(2.0)
        assert world.drones[0].is_flying
        states.append(world.drones[0].memory.tobytes())
    assert states[0] == states[1]


def test_what_is_only_seen_does_not_change_a_bit(reference):
    assert fly(make_world(8, seed=7, visuals=False)) == reference


def test_one_drone_returns_to_its_snapshot():
    world = make_world(2, seed=5)
    world.wait_until_ready()
    first, second = world.drones
    for drone in world.drones:
        drone.high_level_commander.takeoff(0.5, 1.0)
    world.run(2.0)
    snapshot = first.snapshot()
    bytes_before = first.memory.tobytes()
    first.high_level_commander.go_to(0.5, 0.5, 1.0, 0.0, 1.0)
    world.run(1.0)
    assert first.memory.tobytes() != bytes_before

    height_of_second = second.true_position[2]
    first.restore(snapshot)
    assert first.memory.tobytes() == bytes_before
    assert second.true_position[2] == height_of_second
    world.run(1.0)
    assert np.linalg.norm(first.true_position - snapshot.qpos[:3]) < 0.2


def test_a_forked_child_flies_on_without_the_threads_of_its_parent():
    script = """
import os
from worlds import make_world
world = make_world(4, threads=2)
world.run(0.1)
child = os.fork()
world.run(0.1)
if child == 0:
    os._exit(7 if abs(world.time - 0.2) < 1e-9 else 1)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
"""
    paths = [str(Path(__file__).parent), str(Path(crazychoir_fw.__file__).parents[1])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    subprocess.run([sys.executable, "-c", script], check=True, timeout=60, env=environment)


@pytest.fixture(scope="module")
def large_swarm():
    """More drones than the cache of a core holds, just after take-off."""
    places = [(0.4 * (i % 18), 0.4 * (i // 18)) for i in range(300)]
    world = World([DroneConfig(f"cf{i}", place) for i, place in enumerate(places)], seed=3, visuals=False)
    set_threads(2)
    world.run(1.6)
    for drone in world.drones:
        if drone.can_arm:
            drone.arm()
    world.run(0.2)
    for drone in world.drones[::2]:
        drone.high_level_commander.takeoff(0.5, 1.0)
    return world


def test_large_swarm_flies_alike_on_any_number_of_threads_and_one_by_one(large_swarm):
    start = large_swarm.snapshot()
    ends = []
    for threads, ticks in ((1, 60), (2, 60), (3, 60), (1, 1)):
        set_threads(threads)
        large_swarm.restore(start)
        for _ in range(0, 60, ticks):
            large_swarm.step(ticks)
        ends.append(large_swarm.data.plugin_state.tobytes() + large_swarm.data.qpos.tobytes())
    assert ends[1:] == ends[:1] * 3
