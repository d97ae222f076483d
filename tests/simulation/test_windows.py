"""Ticks that the plugin makes without MuJoCo, while nothing can touch anything, change no bit."""

import mujoco
import numpy as np
import pytest

from crazychoir_fw._core import lib
from crazychoir_fw.simulation import DroneConfig, World, set_threads


@pytest.fixture(autouse=True)
def one_thread():
    yield
    set_threads(1)


def state_of(world):
    state = np.empty(mujoco.mj_stateSize(world.model, mujoco.mjtState.mjSTATE_INTEGRATION))
    mujoco.mj_getState(world.model, world.data, state, mujoco.mjtState.mjSTATE_INTEGRATION)
    return state.tobytes() + world.data.qacc.tobytes()


def window(world, ticks):
    """Try a window; returns the ticks it made, or a negative number."""
    model, data = world.model._address, world.data._address
    lib.cf_plugin_overlap(model, data, True)
    flown = lib.cf_plugin_window(model, data, ticks)
    lib.cf_plugin_overlap(model, data, False)
    return flown


def hovering(places, **options):
    world = World(
        [DroneConfig(f"cf{i + 1}", place, **options) for i, place in enumerate(places)], seed=5, visuals=False
    )
    world.wait_until_ready()
    for i, drone in enumerate(world.drones):
        drone.high_level_commander.takeoff(0.5 + 0.3 * i, 1.0)
    world.run(2.0)
    return world


def both(world, ticks):
    """Go on by raw steps, and from the same instant by those of a world."""
    snapshot = world.snapshot()
    mujoco.mj_step(world.model, world.data, nstep=ticks)
    raw = state_of(world)
    world.restore(snapshot)
    world.step(ticks)
    return raw, state_of(world)


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
@pytest.mark.parametrize("threads", [1, 2])
def test_drones_that_hover_fly_in_windows(platform, threads):
    set_threads(threads)
    world = hovering([(0.5 * (i % 3), 0.5 * (i // 3)) for i in range(9)], platform=platform)
    snapshot = world.snapshot()
    assert window(world, 99) == 99
    flown = state_of(world)
    world.restore(snapshot)
    mujoco.mj_step(world.model, world.data, nstep=99)
    assert state_of(world) == flown


def test_downwash_and_broadcasts_are_heeded():
    world = hovering([(0.0, 0.0), (0.05, 0.0), (0.0, 0.4), (1.0, 0.0)])
    for drone in world.drones:
        drone.param["colAv.enable"] = 1
    raw, stepped = both(world, 500)
    assert raw == stepped
    assert world.drones[0].struct.vehicle.downwash > 0
    assert len(world.drones[0].peers) == 3


def test_held_drones_lie_beside_those_that_fly_until_they_wake():
    world = World([DroneConfig(f"cf{i + 1}", (0.7 * i, 0.0)) for i in range(12)], seed=5, visuals=False)
    world.run(1.7)
    world.drones[0].high_level_commander.takeoff(0.8, 1.0)
    world.run(2.0)
    assert sum(drone.struct.rest.is_held for drone in world.drones) == 11
    assert window(world, 20) == 20
    for number in (9, 3):
        snapshot = world.snapshot()
        world.drones[number].high_level_commander.takeoff(0.3, 0.5)
        raw, stepped = both(world, 60)
        assert raw == stepped
        assert not world.drones[number].struct.rest.is_held
        world.restore(snapshot)


@pytest.mark.parametrize("seed", range(8))
def test_drones_that_fall_and_run_into_each_other_are_left_to_mujoco_in_time(seed):
    random = np.random.default_rng(seed)
    count = 10
    world = World([DroneConfig(f"cf{i + 1}", (float(i), 0.0, 1.0)) for i in range(count)], seed=seed, visuals=False)
    pose = world.data.qpos.reshape(count, 7)
    pose[:, :3] = random.uniform((0.0, 0.0, 0.3), (1.2, 1.2, 1.5), (count, 3))
    twist = world.data.qvel.reshape(count, 6)
    twist[:, :3] = random.normal(0, 3.0, (count, 3))
    twist[:, 3:] = random.normal(0, 10.0, (count, 3))
    hits = 0
    for _ in range(12):
        raw, stepped = both(world, 40)
        assert raw == stepped
        hits += len(world.events)
    assert hits  # with the floor or each other


@pytest.mark.parametrize("seed", range(3))
def test_flights_that_cross_each_other_are_left_to_mujoco_in_time(seed):
    random = np.random.default_rng(seed)
    world = hovering([(0.5 * (i % 3), 0.5 * (i // 3)) for i in range(6)])
    for _ in range(6):
        for drone in world.drones:
            drone.high_level_commander.go_to(*random.uniform(0.2, 0.8, 3), 0.0, 0.4)
        raw, stepped = both(world, 300)
        assert raw == stepped


@pytest.mark.parametrize("far", [False, True])
def test_a_push_by_hand_is_left_to_mujoco(far):
    world = hovering([(0.0, 0.0), (1.0, 0.0)])
    if far:
        world.data.qfrc_applied[6] = 0.01
    else:
        world.data.xfrc_applied[world.model.body("cf1").id, 0] = 0.01
    assert window(world, 20) < 0
    raw, stepped = both(world, 50)
    assert raw == stepped


def test_what_is_not_known_is_left_to_mujoco():
    assert window(World([DroneConfig("cf1", (0.0, 0.0, 9.0))], scene="pillars", seed=1), 20) < 0
    world = hovering([(0.0, 0.0)])
    assert window(world, 20) == 20
    called = []
    mujoco.set_mjcb_passive(lambda model, data: called.append(data.time))
    try:
        assert window(world, 20) < 0
        world.step(10)
    finally:
        mujoco.set_mjcb_passive(None)
    assert len(called) == 10
    world.model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    assert window(world, 20) < 0


POSED = ("xpos", "xquat", "xipos", "geom_xpos", "geom_xmat", "site_xpos", "cam_xpos", "light_xpos", "subtree_com")


def poses_of(world):
    return {name: getattr(world.data, name).tobytes() for name in POSED}


def test_bodies_are_where_the_last_step_began():
    """As after any step of MuJoCo, however many ticks the plugin made, and as little as one."""
    world = hovering([(0.0, 0.0), (1.0, 0.0)])
    world.drones[0].high_level_commander.go_to(1.0, 1.0, 1.0, 0.0, 1.0)
    world.step(499)
    before = world.data.qpos[:3].copy()
    world.step(1)
    np.testing.assert_array_equal(world.data.xpos[world.model.body("cf1").id], before)
    for ticks in (1, 3, 100):
        snapshot = world.snapshot()
        mujoco.mj_step(world.model, world.data, nstep=ticks)
        raw = poses_of(world)
        world.restore(snapshot)
        assert window(world, ticks) == ticks
        assert poses_of(world) == raw
        assert world.data.ncon == 0


def test_single_ticks_are_made_without_mujoco_as_well():
    world = hovering([(0.0, 0.0), (1.0, 0.0)])
    snapshot = world.snapshot()
    mujoco.mj_step(world.model, world.data, nstep=20)
    raw = state_of(world)
    world.restore(snapshot)
    world.data.cvel[:] = np.nan  # which MuJoCo computes in each step
    for _ in range(20):
        world.step(1)
    assert state_of(world) == raw
    assert np.isnan(world.data.cvel).all()
