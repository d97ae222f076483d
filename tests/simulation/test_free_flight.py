"""Drones that nothing touches move by the plugin's own integrator: the same bits on every path and in every company."""

import mujoco
import numpy as np
import pytest

from crazychoir_fw.onboard.core import PLUGIN
from crazychoir_fw.simulation import DroneConfig, World, set_threads

TICKS = 3600
COLUMNS = 11


@pytest.fixture(autouse=True)
def one_thread():
    yield
    set_threads(1)


def eventful_world(count, height=None):
    """The first may start in the air; the others stand a meter apart, but for a pile of the fourth to sixth."""
    places = [(float(i % COLUMNS), float(i // COLUMNS)) for i in range(count)]
    drones = [DroneConfig(f"cf{i + 1}", place) for i, place in enumerate(places)]
    drones[0] = DroneConfig("cf1", (0.0, 0.0) if height is None else (0.0, 0.0, height))
    for i in range(3, min(6, count)):
        drones[i] = DroneConfig(f"cf{i + 1}", (3.02, 0.01 * i, 0.2 * i))
    return World(drones, seed=3, visuals=False)


def command(world, tick):
    """Take-off, a collision in the air, an emergency stop, landing, and drones that are put elsewhere."""
    drones = world.drones
    if tick == 1700:
        for drone in (*drones[:2], *drones[6::2]):
            drone.high_level_commander.takeoff(0.6, 1.0)
    if tick == 2450 and len(drones) > 7:
        drones[7].high_level_commander.takeoff(0.4, 1.0)  # wakes while others fly
    if tick == 2750 and len(drones) > 3:
        drones[2].place((1.0, 0.03, 0.55))  # falls upon one that climbs
        drones[3].place((3.0, 0.5, 0.5))
    if tick == 2900:
        drones[0].emergency_stop()
    if tick == 3000 and len(drones) > 1:
        drones[1].high_level_commander.land(0.0, 0.5)


def state_of(world):
    """Everything that decides what comes next, and the accelerations."""
    state = np.empty(mujoco.mj_stateSize(world.model, mujoco.mjtState.mjSTATE_INTEGRATION))
    mujoco.mj_getState(world.model, world.data, state, mujoco.mjtState.mjSTATE_INTEGRATION)
    return state.tobytes() + world.data.qacc.tobytes()


def state_of_one(world, i):
    data = world.data
    return (
        data.qpos[7 * i : 7 * i + 7].tobytes()
        + data.qvel[6 * i : 6 * i + 6].tobytes()
        + world.drones[i].memory.tobytes()
    )


def raw_steps(world, ticks):
    mujoco.mj_step(world.model, world.data, nstep=ticks)


def by_turns(world, ticks):
    """Raw steps and those of a world, of all lengths."""
    cut = ticks // 3
    raw_steps(world, cut)
    world.step(1)
    world.step(ticks - cut - 1)


def fly(world, advance=World.step, observe=lambda world: None):
    seen = []
    for tick in range(0, TICKS, 50):
        command(world, tick)
        advance(world, 50)
        seen.append(observe(world))
    return seen


@pytest.fixture(scope="module")
def reference():
    world = eventful_world(8)
    states = fly(world, observe=state_of)
    # the flight is as eventful as it should be
    assert any({event.drone, event.details["other"]} == {"cf2", "cf3"} for event in world.events)
    assert sum(drone.struct.rest.is_held for drone in world.drones) >= 2
    return states


@pytest.mark.parametrize("advance", [raw_steps, by_turns])
@pytest.mark.parametrize("threads", [1, 2])
def test_every_way_of_stepping_gives_the_same_bits(reference, advance, threads):
    set_threads(threads)
    assert fly(eventful_world(8), advance, state_of) == reference


def test_threads_give_the_same_bits(reference):
    set_threads(2)
    assert fly(eventful_world(8), observe=state_of) == reference


@pytest.fixture(scope="module")
def alone():
    return fly(eventful_world(1), observe=lambda world: state_of_one(world, 0))


@pytest.mark.parametrize("count", [4, 20])
def test_a_drone_does_not_notice_its_company_on_the_floor_either(alone, count):
    """It stands, takes off, is stopped, falls and comes to rest, while others lie in piles and run into each other."""
    assert fly(eventful_world(count), observe=lambda world: state_of_one(world, 0)) == alone


def test_a_drone_does_not_notice_a_large_swarm_while_it_is_in_the_air():
    """From a hundred drones on another solver looks after the floor, which moves the last bits there and only there."""
    seen = []
    for count in (1, 120):
        world = eventful_world(count, height=60.0)
        world.step(10)
        assert (world.data.ncon > 0) == (count > 1)
        world.step(1990)
        seen.append(state_of_one(world, 0))
    assert seen[0] == seen[1]


# ----------------------------------------------------------------------------------------------- as MuJoCo integrates


def pair(**options):
    """Return twice the same world; in the second an armature of no weight leaves the drones to MuJoCo."""
    worlds = [World([DroneConfig("cf1", (0.0, 0.0, 50.0))], seed=3, visuals=False) for _ in range(2)]
    worlds[1].model.dof_armature[:] = 1e-300
    return worlds[0], worlds[1].fork()[0]


def test_motion_is_that_of_mujoco():
    ours, theirs = pair()
    for world in (ours, theirs):
        world.step(1700)
        world.drones[0].high_level_commander.go_to(0.2, 0.0, 36.0, 0.0, 1.0)
        world.step(2000)
    assert ours.drones[0].is_flying
    assert (
        ours.data.qpos.tobytes() != theirs.data.qpos.tobytes()
    )  # or the comparison would be one of MuJoCo with itself
    np.testing.assert_allclose(ours.data.qpos, theirs.data.qpos, atol=1e-13, rtol=0)


@pytest.mark.parametrize("rates", [(0.1, 0.2, -0.3), (40.0, -5.0, 60.0), (200.0, 300.0, 0.0)])
def test_forces_of_users_and_fast_turns_act_as_in_mujoco(rates):
    ours, theirs = pair()
    for world in (ours, theirs):
        world.data.qvel[3:6] = rates
        world.data.xfrc_applied[2] = (0.1, -0.2, 0.05, 1e-4, -2e-4, 3e-4)
        world.data.qfrc_applied[:] = (0.02, 0.0, -0.1, 3e-5, 0.0, 1e-4)
        world.step(20)
    assert ours.data.xfrc_applied[ours.model.body("cf1").id].any()
    np.testing.assert_allclose(ours.data.qpos, theirs.data.qpos, atol=1e-13, rtol=0)
    np.testing.assert_allclose(ours.data.qvel, theirs.data.qvel, atol=1e-10, rtol=0)


def test_no_gravity_is_no_gravity():
    world, _ = pair()
    world.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_GRAVITY
    before = world.data.qpos[:3].copy()
    world.step(100)
    np.testing.assert_allclose(world.data.qpos[:3], before, atol=1e-6)


def test_changed_mass_and_inertia_are_heeded():
    world, _ = pair()
    body = world.model.body("cf1").id
    world.data.qfrc_applied[:] = (0.1, 0.0, 0.0, 0.0, 0.0, 1e-4)
    world.step(1)
    world.model.body_mass[body] *= 2
    world.model.body_inertia[body] *= 4
    before = world.data.qacc.copy()
    world.step(1)
    assert world.data.qacc[0] == pytest.approx(before[0] / 2, rel=1e-2)
    assert world.data.qacc[5] == pytest.approx(before[5] / 4, rel=1e-2)


TIED = f"""
<mujoco><option timestep="0.001"/><extension><plugin plugin="{PLUGIN}"/></extension>
<worldbody>
  <site name="hook" pos="0 0 1.5"/>
  <body name="cf1" pos="0 0 1">
    <freejoint/><inertial pos="0 0 0" mass="0.03" diaginertia="2e-5 2e-5 3e-5"/>
    <geom type="sphere" size="0.03"/><site name="top"/><plugin plugin="{PLUGIN}"/>
  </body>
</worldbody>
%s
</mujoco>"""


@pytest.mark.parametrize(
    "tie",
    [
        '<equality><weld body1="cf1"/></equality>',
        '<equality><connect site1="top" site2="hook"/></equality>',
        '<tendon><spatial limited="true" range="0 0.5"><site site="hook"/><site site="top"/></spatial></tendon>',
    ],
)
def test_a_drone_that_is_tied_is_left_to_mujoco(tie):
    model = mujoco.MjModel.from_xml_string(TIED % tie)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=500)
    assert data.qpos[2] > 0.9
