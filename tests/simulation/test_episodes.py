"""Episodes in C threads give the bits of single worlds; so does `mujoco.rollout`."""

import copy

import mujoco
import numpy as np
import pytest
from mujoco import rollout
from worlds import make_world

from crazychoir_fw.common.errors import RangeError

pytest.importorskip("mujoco.batch", reason="this MuJoCo has no batches")

from crazychoir_fw.simulation import DroneConfig, Episodes, World


@pytest.fixture(scope="module")
def start():
    world = make_world(3, seed=2)
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(0.5, 1.0)
    world.run(1.0)
    return world


def command(drones, number):
    drones[0].high_level_commander.go_to(0.1 * number, 0.3, 0.6, 0.0, 1.0)
    drones[1].param["pid_rate.roll_kp"] = 200 + 10 * number
    if number == 2:
        drones[2].emergency_stop()


@pytest.mark.parametrize("threads", [1, 2])
def test_a_batch_gives_the_bits_of_single_worlds(start, threads):
    episodes = Episodes(start, 5, threads)
    for number in range(len(episodes)):
        command(episodes.drones(number), number)
    episodes.run(0.4)
    episodes.drones(4)[1].high_level_commander.land(0.0, 1.0)
    episodes.run(0.4)
    for number, world in enumerate(start.fork(5)):
        command(world.drones, number)
        world.run(0.4)
        if number == 4:
            world.drones[1].high_level_commander.land(0.0, 1.0)
        world.run(0.4)
        assert episodes.snapshot(number).tobytes() == world.snapshot().tobytes()
        np.testing.assert_array_equal(episodes.positions()[number], world.positions())
    assert episodes.time == pytest.approx(start.time + 0.8)


def test_the_world_goes_on_with_the_best_episode(start):
    world = start.fork()[0]
    episodes = Episodes(world, 3, 1)
    for number in range(3):
        command(episodes.drones(number), number)
    episodes.run(0.5)
    assert world.time == start.time
    world.restore(episodes.snapshot(1))
    assert world.time == pytest.approx(start.time + 0.5)
    # the commands before the start, then those of this episode
    assert [request.verb for request in world.journal][len(start.journal) :] == ["cf_go_to", "param"]
    (other,) = start.fork()
    command(other.drones, 1)
    other.run(0.5)
    for flight in (world, other):
        flight.run(0.2)
    assert world.snapshot().tobytes() == other.snapshot().tobytes()


@pytest.mark.parametrize("threads", [0, 2])
def test_rollout_gives_the_bits_of_single_worlds(start, threads):
    model = start.model
    spec = mujoco.mjtState.mjSTATE_FULLPHYSICS
    first = np.empty(mujoco.mj_stateSize(model, spec))
    mujoco.mj_getState(model, start.data, first, spec)
    workspaces = [copy.copy(start.data) for _ in range(max(1, threads))]
    with rollout.Rollout(nthread=threads) as roll:
        states, _ = roll.rollout(
            model, workspaces, np.tile(first, (4, 1)), nstep=60, initial_warmstart=start.data.qacc_warmstart.copy()
        )
    (world,) = start.fork()
    world.step(60)
    end = np.empty_like(first)
    mujoco.mj_getState(model, world.data, end, spec)
    assert all(states[k, -1].tobytes() == end.tobytes() for k in range(4))


def test_impossible_numbers_are_refused(start):
    with pytest.raises(RangeError, match="count is 0"):
        Episodes(start, 0)
    with pytest.raises(RangeError, match="threads is -1"):
        Episodes(start, 1, -1)
    with pytest.raises(RangeError, match=r"run\(nan\)"):
        Episodes(start, 1, 1).run(float("nan"))
    assert isinstance(start, World)


def test_each_episode_has_its_own_payload():
    payload = {"mass": 0.006, "offset": (0, 0, -0.006), "detachable": True}
    world = World([DroneConfig("cf", (0, 0), payload=payload)], visuals=False)
    world.wait_until_ready()
    world["cf"].high_level_commander.takeoff(0.6, 1.0)
    world.run(1.5)
    episodes = Episodes(world, 2, 1)
    (keeps,), (drops,) = episodes.drones(0), episodes.drones(1)
    drops.drop_payload()
    assert (keeps.payload.is_attached, drops.payload.is_attached) == (True, False)
    episodes.run(0.3)
    assert keeps.payload.position[2] > 0.4 > drops.payload.position[2] + 0.1
    drops.place((1.0, 1.0, 0.5))
    keeps.place((1.0, 0.0, 0.5))
    assert keeps.payload.position == pytest.approx([1.0, 0.0, 0.494])
