"""Positions of peers that the world sends to drones: the nearest ten, at 100 Hz, to drones that use them."""

import mujoco
import numpy as np
import pytest
from worlds import make_world

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.simulation import DroneConfig, World, set_threads

PERIOD = 10  # [ms]
ON = {"colAv.enable": 1}


def scattered_world(count, size=4.0, parameters=ON, seed=2):
    """Return a world with drones scattered above a square, none of them nearer than 0.2 m to another."""
    random = np.random.default_rng(seed)
    places = []
    while len(places) < count:
        place = random.uniform(-size / 2, size / 2, 2)
        if all(np.linalg.norm(place - other) > 0.2 for other in places):
            places.append(place)
    configs = [
        DroneConfig(f"cf{i + 1}", (x, y, 20.0 + 0.1 * i), parameters=parameters) for i, (x, y) in enumerate(places)
    ]
    return World(configs, seed=seed, visuals=False)


def sorted_rows(array):
    return array[np.lexsort(array.T)]


def entries(drone):
    """Return (id, timestamp) of the peers whose positions a drone has received."""
    return [(peer.id, peer.pos.timestamp) for peer in drone.struct.onboard.peers.peers if peer.id]


def test_nobody_is_told_anything_unless_collision_avoidance_is_on():
    world = make_world(3)
    world.run(0.1)
    assert [len(drone.peers) for drone in world.drones] == [0, 0, 0]
    assert world.drones[0].peers.shape == (0, 3)


def test_only_who_listens_is_told():
    world = make_world(3)
    world.drones[1].param["colAv.enable"] = 1
    world.run(0.1)
    assert [len(drone.peers) for drone in world.drones] == [0, 2, 0]


def test_positions_are_true_and_told_every_ten_ticks():
    world = scattered_world(3)
    first = world.drones[0]
    told_at = []
    for tick in range(1, 41):
        before = first.peers
        world.step()
        if not np.array_equal(before, first.peers):
            told_at.append(tick)
            seen = world.positions()[1:].astype(np.float32)
            np.testing.assert_array_equal(sorted_rows(first.peers), sorted_rows(seen))
    assert told_at == [10, 20, 30, 40]


def test_ids_count_from_one_and_times_are_ticks_of_the_listener():
    world = scattered_world(3)
    world.run(0.02)
    assert dict(entries(world.drones[1])) == {1: 19, 3: 19}  # told before the 20th tick


@pytest.mark.parametrize(("count", "size"), [(14, 4.0), (60, 12.0)])
def test_the_ten_nearest_are_told(count, size):
    world = scattered_world(count, size)
    world.step(PERIOD)
    positions = world.positions().astype(np.float32)
    for i, drone in enumerate(world.drones):
        distances = np.linalg.norm(positions - positions[i], axis=1)
        nearest = positions[np.argsort(distances)[1:11]]
        np.testing.assert_array_equal(sorted_rows(drone.peers), sorted_rows(nearest))


def test_swarm_may_have_more_drones_than_there_are_ids():
    """Two neighbors whose ids are equal get an entry each."""
    places = [(1.0 + 0.3 * (i % 16), 0.3 * (i // 16), 5.0) for i in range(259)]
    places[0], places[255], places[256] = (-1.0, 0.0, 5.0), (-1.0, 0.3, 5.0), (-1.0, 0.6, 5.0)
    configs = [DroneConfig(f"cf{i + 1}", place) for i, place in enumerate(places)]
    configs[256].parameters = ON
    world = World(configs, visuals=False)
    world.step(2 * PERIOD)
    listener = world.drones[256]
    told = entries(listener)
    assert len(told) == 10
    assert [peer_id for peer_id, _ in told].count(1) == 2  # of drones 0 and 255
    positions = world.positions().astype(np.float32)
    nearest = positions[np.argsort(np.linalg.norm(positions - positions[256], axis=1))[1:11]]
    np.testing.assert_array_equal(sorted_rows(listener.peers), sorted_rows(nearest))


def test_drone_that_the_cameras_lost_grows_old_in_the_tables():
    world = scattered_world(3)
    world.step(PERIOD)
    world.drones[2].struct.vehicle.mocap.is_lost = True
    seen_last = world.drones[2].true_position
    world.step(5 * PERIOD)
    assert dict(entries(world.drones[0])) == {2: 59, 3: 9}
    assert seen_last.astype(np.float32).tolist() in world.drones[0].peers.tolist()
    assert dict(entries(world.drones[2])) == {1: 59, 2: 59}  # the radio still reaches it


def test_drone_that_has_run_wild_is_nobodys_neighbor():
    world = scattered_world(3)
    world.data.qpos[world.drones[1].qpos_address] = 5e4
    world.step(PERIOD)
    assert [peer_id for peer_id, _ in entries(world.drones[0])] == [3]
    assert len(world.drones[1].peers) == 0
    assert world.drones[0].failure is None


def test_reboot_forgets_the_others():
    world = scattered_world(3)
    world.step(PERIOD)
    world.drones[0].reboot()
    assert len(world.drones[0].peers) == 0
    assert world.drones[0].param["colAv.enable"] == 0


@pytest.mark.parametrize(("timestep", "steps"), [(0.0005, 2), (0.002, 1), (0.005, 1), (0.02, 1)])
def test_every_time_step_has_its_broadcasts(timestep, steps):
    world = scattered_world(2)
    world.model.opt.timestep = timestep
    told = []
    for _ in range(round(0.06 / timestep / steps)):
        mujoco.mj_step(world.model, world.data, nstep=steps)
        told += [time for _, time in entries(world.drones[0]) if time not in told]
    # the listener's tick before the first tick of the step
    period = max(PERIOD, round(timestep * 1000))
    ticks = max(1, round(timestep * 1000))
    expected = [k * period - ticks for k in range(1, 60 // period + 1)]
    assert told == [time for time in expected if time > 0]  # no drone receives before its first tick


# ----------------------------------------------------------------------------------------------------- determinism


def fly(world, first=0, last=60):
    """Drones that fall, start, and cross each other's ways for 3 s; returns every byte of their states."""
    for i in range(first, last):
        if i == 36:
            for k, drone in enumerate(world.drones):
                x, y, _ = -drone.true_position
                drone.high_level_commander.go_to(x, y, 8.0 + 0.01 * k, 0.0, 2.0)
        world.step(47)  # no multiple of the period: snapshots fall between broadcasts
    return world.data.plugin_state.tobytes() + world.data.qpos.tobytes() + world.data.qvel.tobytes()


@pytest.fixture(scope="module")
def reference():
    """The bytes after the flight with one thread; every drone avoids every other."""
    set_threads(1)
    world = scattered_world(14)
    state = fly(world)
    assert all(drone.is_flying for drone in world.drones)
    return state


def test_drones_of_this_flight_do_avoid_each_other():
    world = scattered_world(14)
    fly(world, 0, 45)
    onboard = [drone.struct.onboard for drone in world.drones]
    bent = [o.setpoint.position.x != o.commander.setpoint.position.x for o in onboard]
    assert sum(bent) > 5


@pytest.mark.parametrize("threads", [2])
def test_threads_do_not_change_a_bit(reference, threads):
    set_threads(threads)
    assert fly(scattered_world(14)) == reference


@pytest.mark.parametrize("threads", [1, 2])
def test_steps_of_mujoco_alone_give_the_same_bits(reference, threads):
    """Without the ticks beside the next step."""
    set_threads(threads)
    world = scattered_world(14)
    world.step = lambda n: mujoco.mj_step(world.model, world.data, nstep=n)
    assert fly(world) == reference


@pytest.mark.parametrize("moment", [1, 35, 50])
@pytest.mark.parametrize("threads", [1, 2])
def test_flight_goes_on_alike_after_a_snapshot(reference, moment, threads):
    set_threads(threads)
    world = scattered_world(14)
    fly(world, 0, moment)
    snapshot = world.snapshot()
    fly(world, moment, min(moment + 13, 60))
    world.restore(snapshot)
    assert fly(world, moment) == reference


def test_snapshot_may_be_restored_into_a_world_built_anew(reference):
    """The new world has sent no positions so far: whether a drone wants them is part of the snapshot."""
    world = scattered_world(14)
    fly(world, 0, 40)
    other = scattered_world(14, parameters={})
    other.restore(world.snapshot())
    assert fly(other, 40) == reference


def test_reset_world_flies_the_same_flight(reference):
    world = scattered_world(14)
    fly(world, 0, 45)
    world.reset()
    assert fly(world) == reference


# ------------------------------------------------------------------------------------------------------- parameters


def test_parameters_of_a_configuration_are_set_at_the_start_and_at_a_reset():
    world = World([DroneConfig("cf1", parameters={"colAv.horizon": 0.5, "stabilizer.controller": 1})])
    assert world["cf1"].param["colAv.horizon"] == 0.5
    world["cf1"].param["colAv.horizon"] = 2.0
    world.reset()
    assert world["cf1"].param["colAv.horizon"] == 0.5


def test_parameters_of_a_configuration_are_checked():
    with pytest.raises(UnknownNameError, match=r"cf1: no parameter named 'colAv.enable_'; did you mean colAv.enable"):
        World([DroneConfig("cf1", parameters={"colAv.enable_": 1})])
    with pytest.raises(RangeError, match=r"cf1: colAv.enable is 256, allowed: a whole number 0 to 255"):
        World([DroneConfig("cf1", parameters={"colAv.enable": 256})])
