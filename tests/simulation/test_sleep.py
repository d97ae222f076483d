"""Drones at rest: held to the last bit, and woken by everything that could move them."""

import mujoco
import numpy as np
import pytest

from crazychoir_fw._core import lib
from crazychoir_fw.simulation import DroneConfig, World, set_threads


def heap(count=12, seed=3):
    """Return a world whose drones fall onto each other."""
    places = [(0.03 * (i % 3), 0.03 * (i // 3 % 2), 0.05 + 0.05 * i) for i in range(count)]
    return World(
        [DroneConfig(f"cf{i}", place, yaw_deg=50 * i) for i, place in enumerate(places)], seed=seed, visuals=False
    )


def is_held(drone):
    return bool(drone.struct.rest.is_held)


@pytest.fixture
def landed():
    world = World([DroneConfig("cf1"), DroneConfig("cf2", (0.5, 0.0))], visuals=False)
    world.run(1.6)
    assert all(is_held(drone) for drone in world.drones)
    return world


def test_landed_drone_neither_creeps_nor_jitters(landed):
    """Contact rest: nothing at all in 10 s, against 0.1 mm that are allowed."""
    before = landed.data.qpos.copy()
    landed.run(10.0)
    assert np.array_equal(landed.data.qpos, before)
    assert not landed.data.qvel.any()
    assert landed.data.ncon == 0


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
def test_drone_that_has_just_landed_does_not_creep_before_it_is_held(platform):
    world = World([DroneConfig("cf1", (0.0, 0.0, 0.05), platform=platform)], visuals=False)
    world.run(0.6)
    before = world.positions()
    assert not is_held(world["cf1"])
    while not is_held(world["cf1"]):
        world.step(1)
        assert world.time < 3.0
    assert np.linalg.norm(world.positions() - before) < 1e-4


def test_held_drone_measures_one_g(landed):
    landed.run(1.0)
    assert landed["cf1"].struct.onboard.sensors.data.acc.z == pytest.approx(1.0, abs=0.05)


def test_held_drone_takes_off(landed):
    landed.wait_until_ready()
    landed["cf1"].high_level_commander.takeoff(0.5, 1.5)
    landed.run(3.0)
    assert landed["cf1"].true_position[2] == pytest.approx(0.5, abs=0.06)
    assert not is_held(landed["cf1"])
    assert is_held(landed["cf2"])


def test_hand_moves_a_held_drone(landed):
    landed["cf1"].place((0.2, 0.0, 0.3))
    landed.run(0.1)
    assert landed["cf1"].true_position[2] == pytest.approx(0.3 - 9.81 * 0.1**2 / 2, abs=2e-3)
    landed["cf1"].place((0.2, 0.0, 0.0145))
    landed.run(1.0)
    assert is_held(landed["cf1"])
    landed["cf1"].place((0.203, 0.0, 0.0145))
    landed.run(1.0)
    assert landed["cf1"].true_position[0] == pytest.approx(0.203, abs=1e-4)


def test_kick_sets_a_held_drone_moving(landed):
    landed["cf1"]._qvel[0] = 0.5
    landed.run(0.3)
    assert landed["cf1"].true_position[0] == pytest.approx(0.5**2 / (2 * 0.6 * 9.81), rel=0.15)


def test_force_pushes_a_held_drone_against_friction(landed):
    """Friction holds 0.6 of the weight, 0.17 N."""
    body = landed.model.body("cf1").id
    landed.data.xfrc_applied[body, 0] = 0.10
    landed.run(0.5)
    assert abs(landed["cf1"].true_position[0]) < 2e-3
    landed.data.xfrc_applied[body, 0] = 0.25
    landed.run(0.5)
    assert landed["cf1"].true_position[0] > 0.1


def test_drone_that_is_thrown_at_a_held_one_moves_it(landed):
    landed["cf2"].place((0.2, 0.0, 0.03))
    landed["cf2"]._qvel[0] = -2.0
    landed.run(0.5)
    assert landed["cf1"].true_position[0] < -5e-3


def test_flying_drone_pushes_a_held_one_away(landed):
    landed.wait_until_ready()
    landed["cf2"].high_level_commander.takeoff(0.03, 1.0)
    landed.run(1.5)
    landed["cf2"].high_level_commander.go_to(-0.3, 0.0, 0.03, 0.0, 2.0)
    landed.run(2.5)
    assert landed["cf1"].true_position[0] < -0.02


MOVING_FLOOR = """
<mujoco>
  <option timestep="0.001"/>
  <worldbody>
    <geom type="plane" size="5 5 0.1"/>
    <body name="table" pos="0 0 0.3" {mocap}>{joint}<geom type="box" size="0.5 0.5 0.05" mass="5"/></body>
  </worldbody>
</mujoco>
"""


def test_drone_on_a_mocap_table_is_not_held(tmp_path):
    scene = tmp_path / "scene.xml"
    scene.write_text(MOVING_FLOOR.format(mocap='mocap="true"', joint=""))
    world = World([DroneConfig("cf1", (0.0, 0.0, 0.365))], scene=scene, visuals=False)
    world.run(1.5)
    assert not is_held(world["cf1"])
    world.data.mocap_pos[0, 2] = 0.1
    world.run(1.0)
    assert world["cf1"].true_position[2] == pytest.approx(0.1645, abs=2e-3)


def test_table_that_slides_under_a_held_drone_takes_it_along(tmp_path):
    """The table stands still on its spring; a drone on it must not be held, for it may move at any time."""
    scene = tmp_path / "scene.xml"
    joint = '<joint name="slide" type="slide" axis="1 0 0" damping="50"/>'
    scene.write_text(MOVING_FLOOR.format(mocap="", joint=joint))
    world = World([DroneConfig("cf1", (0.0, 0.0, 0.365))], scene=scene, visuals=False)
    world.run(1.5)
    assert not is_held(world["cf1"])
    world.data.qfrc_applied[world.model.joint("slide").dofadr[0]] = 10.0
    world.run(1.0)
    assert world["cf1"].true_position[0] > 0.05


def test_heap_comes_to_rest():
    world = heap()
    world.run(8.0)
    assert sum(is_held(drone) for drone in world.drones) >= 11
    assert np.all(world.positions()[:, 2] > 0.005)


def test_heap_falls_when_its_support_flies_away():
    """A drone that lies on another one does not hang in the air when that one leaves."""
    world = World([DroneConfig("cf1"), DroneConfig("cf2", (0.0, 0.03, 0.06))], visuals=False)
    world.run(3.0)
    assert all(is_held(drone) for drone in world.drones)
    height = world["cf2"].true_position[2]
    assert height > 0.03
    world["cf1"].place((1.0, 0.0, 0.0145))
    world.run(1.0)
    assert world["cf2"].true_position[2] < 0.02


def test_nothing_hangs_in_the_air_when_a_heap_is_robbed():
    """Let go all at once, no drone of the heap falls: 50 mm it would be, were there nothing below it."""
    world = heap(16)
    world.run(5.0)
    lowest = np.argsort(world.positions()[:, 2])[:4]
    for k, i in enumerate(lowest):
        world.drones[i].place((1.0 + 0.3 * k, 0.0, 0.0145))
    world.run(4.0)
    assert sum(is_held(drone) for drone in world.drones) >= 15
    before = world.positions()[:, 2]
    for drone in world.drones:
        drone.struct.rest.is_held = False
        drone.struct.rest.still_time = drone.struct.rest.placed_time = 0.0
    world.run(0.1)
    assert np.all(world.positions()[:, 2] > before - 8e-3)


def test_blow_sets_a_part_of_a_heap_free():
    """It used to be all of it, so that large heaps never came to rest."""
    world = World([DroneConfig(f"cf{i}", (0.12 * i, 0.0)) for i in range(12)] + [DroneConfig("ball", (-0.6, 0.0))])
    world.run(1.6)
    assert all(is_held(drone) for drone in world.drones)
    world["ball"].place((-0.2, 0.0, 0.02))
    world["ball"]._qvel[0] = 1.0
    freed = set()
    for _ in range(400):
        world.step(1)
        freed |= {drone.id for drone in world.drones if not is_held(drone)}
    assert "cf0" in freed
    assert "cf11" not in freed


def test_drone_that_turns_slowly_is_held_where_it_is(landed):
    """What is stopped in the middle of a turn was once turned on for half a step, and was let go for it."""
    drone = landed["cf1"]
    drone.place((0.1, 0.0, 0.0145))
    landed.step(1)
    while not is_held(drone):
        drone._qvel[5] = 0.15
        landed.step(1)
    for _ in range(20):
        landed.step(1)
        assert is_held(drone)


@pytest.mark.parametrize(("count", "solver"), [(100, mujoco.mjtSolver.mjSOL_NEWTON), (101, mujoco.mjtSolver.mjSOL_CG)])
def test_large_swarms_have_a_solver_for_large_heaps(count, solver):
    world = World([DroneConfig(f"cf{i}", (0.3 * i, 0.0)) for i in range(count)], visuals=False)
    assert world.model.opt.solver == solver


@pytest.fixture(scope="module")
def reference():
    """A heap after 3 s with one thread."""
    world = heap()
    set_threads(1)
    world.run(3.0)
    return world


@pytest.mark.parametrize("threads", [1, 2])
def test_heap_is_the_same_to_the_last_bit(reference, threads):
    twin = heap()
    set_threads(threads)
    try:
        twin.run(1.3)
        for _ in range(170):  # outside of long runs nothing overlaps
            mujoco.mj_step(twin.model, twin.data, nstep=10)
    finally:
        set_threads(1)
    assert twin.data.qpos.tobytes() == reference.data.qpos.tobytes()
    assert twin.data.plugin_state.tobytes() == reference.data.plugin_state.tobytes()


@pytest.mark.parametrize("at", [0.4, 0.9, 1.5, 4.0])
def test_heap_goes_on_the_same_after_a_restored_snapshot(at):
    world = heap()
    world.run(at)
    state = world.snapshot()
    world.run(1.5)
    expected = world.data.qpos.tobytes(), world.data.plugin_state.tobytes()
    other = heap()
    other.restore(state)
    other.run(1.5)
    assert (other.data.qpos.tobytes(), other.data.plugin_state.tobytes()) == expected
    world.restore(state)
    world.run(1.5)
    assert (world.data.qpos.tobytes(), world.data.plugin_state.tobytes()) == expected


def test_models_without_drones_collide_as_ever():
    """The contact filter serves the whole process, and asks MuJoCo's bits itself."""
    model = mujoco.MjModel.from_xml_string("""
      <mujoco><worldbody>
        <geom type="plane" size="1 1 1" contype="2" conaffinity="0"/>
        <body pos="0 0 0.05"><freejoint/><geom size="0.1" mass="1" contype="0" conaffinity="2"/></body>
        <body pos="1 0 0.05"><freejoint/><geom size="0.1" mass="1" contype="2" conaffinity="1"/></body>
      </worldbody></mujoco>
    """)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ncon == 1


def test_reboot_does_not_wake(landed):
    landed["cf1"].reboot()
    landed.run(0.1)
    assert is_held(landed["cf1"])
    assert lib.cf_state_bytes(0) == landed["cf1"].memory.nbytes
