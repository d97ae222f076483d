"""Users' own MJCF files are flown in as they are."""

import mujoco
import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.flight.engine import fly
from crazychoir_fw.mission import load_mission
from crazychoir_fw.simulation import DroneConfig, World

WEDGE = """v -0.5 -0.5 0
v 0.5 -0.5 0
v -0.5 0.5 0
v 0.5 0.5 0
v 0.5 -0.5 0.4
v 0.5 0.5 0.4
f 1 3 4
f 1 4 2
f 2 4 6
f 2 6 5
f 1 5 6
f 1 6 3
f 1 2 5
f 3 6 4
"""

# everything that a scene may bring, and that could reach into the drones
LAB = """<mujoco model="lab">
  <compiler angle="radian" meshdir="parts/meshes" inertiafromgeom="true" autolimits="true"/>
  <option timestep="0.002" integrator="implicitfast" cone="elliptic"><flag energy="enable"/></option>
  <default>
    <joint damping="0.3" armature="0.01" frictionloss="0.01"/>
    <geom friction="1 0.01 0.001" condim="4" margin="0.001" solref="0.1 1"/>
  </default>
  <include file="parts/wedge.xml"/>
  <asset><hfield name="hill" nrow="3" ncol="3" size="1 1 0.3 0.1" elevation="0 0 0 0 1 0 0 0 0"/></asset>
  <worldbody>
    <light pos="0 0 3"/>
    <camera name="mine" pos="0 -4 2" xyaxes="1 0 0 0 0.4 1"/>
    <geom name="ground" type="plane" size="5 5 0.1"/>
    <geom name="wedge" type="mesh" mesh="wedge" pos="3 0 0"/>
    <geom name="hill" type="hfield" hfield="hill" pos="-3 0 0"/>
    <body name="door" pos="0 2 0.7">
      <joint name="hinge" axis="0 0 1" range="-1 1"/>
      <geom type="box" size="0.4 0.02 0.5"/>
    </body>
    <body name="crate" pos="0 -2 0.2"><freejoint/><geom type="box" size="0.2 0.2 0.2" mass="1"/></body>
    <body name="ball_a" pos="2 2 0.1"><freejoint/><geom type="sphere" size="0.1"/></body>
    <body name="ball_b" pos="2.3 2 0.1"><freejoint/><geom type="sphere" size="0.1"/></body>
    <body name="target" mocap="true" pos="0 0 2"><geom type="box" size="0.1 0.1 0.1"/></body>
  </worldbody>
  <equality><connect body1="ball_a" body2="ball_b" anchor="0.15 0 0"/></equality>
  <actuator><motor name="push" joint="hinge" gear="1"/></actuator>
  <sensor><jointpos name="angle" joint="hinge"/></sensor>
  <keyframe><key name="open" qpos="0.5 0 -2 0.2 1 0 0 0 2 2 0.1 1 0 0 0 2.3 2 0.1 1 0 0 0"/></keyframe>
</mujoco>
"""


@pytest.fixture
def lab(tmp_path):
    (tmp_path / "parts" / "meshes").mkdir(parents=True)
    (tmp_path / "parts" / "wedge.xml").write_text(
        '<mujoco><asset><mesh name="wedge" file="wedge.obj"/></asset></mujoco>'
    )
    (tmp_path / "parts" / "meshes" / "wedge.obj").write_text(WEDGE)
    path = tmp_path / "lab.xml"
    path.write_text(LAB)
    return path


def test_drones_are_themselves_in_any_scene(lab):
    theirs = World([DroneConfig("cf1")], scene=lab).model
    ours = World([DroneConfig("cf1")]).model
    for model in (theirs, ours):
        assert model.joint("cf1/root").type[0] == mujoco.mjtJoint.mjJNT_FREE
    for name in ("mass", "inertia", "ipos", "iquat"):
        np.testing.assert_array_equal(getattr(theirs.body("cf1"), name), getattr(ours.body("cf1"), name))
    for name in ("damping", "armature", "frictionloss"):
        assert not getattr(theirs.joint("cf1/root"), name).any()
    for name in ("friction", "condim", "margin", "gap", "solref", "solimp", "priority", "contype", "conaffinity"):
        np.testing.assert_array_equal(getattr(theirs.geom("cf1/hull"), name), getattr(ours.geom("cf1/hull"), name))


def test_the_scene_stays_what_it_was(lab):
    alone = mujoco.MjModel.from_xml_path(str(lab))
    model = World([DroneConfig("cf1"), DroneConfig("cf2", (1, 0))], scene=lab).model
    assert (model.nu, model.neq, model.nsensor, model.ncam) == (1, 1, 1, 1)
    assert (model.opt.timestep, model.opt.integrator, model.opt.cone) == (0.002, alone.opt.integrator, alone.opt.cone)
    assert model.opt.enableflags == alone.opt.enableflags
    assert (model.body("ball_a").mass, model.joint("hinge").damping) == (alone.body("ball_a").mass, [0.3])
    kept = model.key_qpos[0][: alone.nq]
    np.testing.assert_array_equal(kept, alone.key_qpos[0])


def test_a_drone_flies_sees_and_the_scene_moves(lab):
    config = DroneConfig("cf1", decks=["multiranger", "zranger"], attributes={"range_noise": 0.0})
    world = World([config], scene=lab, seed=1)
    world.wait_until_ready()
    drone = world.drones[0]
    drone.high_level_commander.takeoff(0.6, 1.5)
    world.run(3.0)
    assert drone.true_position == pytest.approx([0, 0, 0.6], abs=0.1)
    height = 1000 * drone.true_position[2]
    # of the mocap body above, the door to the left and the floor
    assert drone.log["range.up"] == pytest.approx(1900 - height, abs=20)
    assert drone.log["range.left"] == pytest.approx(1980, abs=20)
    assert drone.log["range.zrange"] == pytest.approx(height, abs=20)
    world.data.mocap_pos[0, 2] = 1.5
    world.data.ctrl[0] = 5.0
    world.run(0.2)
    assert drone.log["range.up"] == pytest.approx(1400 - height, abs=20)
    assert world.data.sensor("angle").data[0] > 0.01


def test_a_flight_in_it_is_restored_to_the_last_bit(lab):
    world = World([DroneConfig("cf1", (0, 0, 0.5), decks=["multiranger"])], scene=lab)
    world.data.ctrl[0] = 0.5
    world.run(0.3)
    start = world.snapshot()
    world.run(0.5)
    after = world.snapshot().tobytes()
    world.restore(start)
    world.run(0.5)
    assert world.snapshot().tobytes() == after


def test_meshes_and_height_fields_are_obstacles(lab):
    world = World([DroneConfig("slope", (3.2, 0, 1.0), decks=["zranger"], attributes={"range_noise": 0.0})], scene=lab)
    world.run(0.03)
    height = world.drones[0].true_position[2]
    assert world.drones[0].log["range.zrange"] == pytest.approx(1000 * (height - 0.28), abs=3)
    world = World([DroneConfig("hill", (-3, 0, 1.0), decks=["zranger"], attributes={"range_noise": 0.0})], scene=lab)
    world.run(0.03)
    height = world.drones[0].true_position[2]
    assert world.drones[0].log["range.zrange"] == pytest.approx(1000 * (height - 0.3), abs=3)


def test_a_mission_finds_the_scene_beside_its_file(lab):
    mission = lab.parent / "mission.yaml"
    mission.write_text(
        "scene: lab.xml\n"
        "drones: [{id: cf1, position: [0, 0], decks: [zranger]}]\n"
        "flight: [takeoff: {height: 0.5, duration: 1.5}, hover: {duration: 1}, land: {duration: 1.5}]\n"
    )
    assert fly(load_mission(mission)).failures == []


@pytest.mark.parametrize(
    ("integrator", "timestep"), [("Euler", 0.0005), ("RK4", 0.001), ("implicit", 0.004), ("implicitfast", 0.01)]
)
def test_other_options_fly_too(tmp_path, integrator, timestep):
    path = tmp_path / "scene.xml"
    path.write_text(
        f'<mujoco><option timestep="{timestep}" integrator="{integrator}"/>'
        '<worldbody><geom type="plane" size="1 1 1"/></worldbody></mujoco>'
    )
    world = World([DroneConfig("cf1", decks=["zranger"])], scene=path, seed=1)
    world.wait_until_ready()
    world.drones[0].high_level_commander.takeoff(0.5, 1.5)
    world.run(3.0)
    assert world.drones[0].true_position == pytest.approx([0, 0, 0.5], abs=0.08)


@pytest.mark.parametrize(
    ("scene", "sentence"),
    [
        ('<mujoco><worldbody><body name="cf1"/></worldbody></mujoco>', "repeated name 'cf1'"),
        ('<mujoco><option timestep="0.0003"/><worldbody/></mujoco>', "timestep is 0.0003 s"),
        ("<mujoco><worldbody><geom/></worldbody></mujoco>", "size"),
        ("<mujoco><worldbody>", "scene.xml"),
        ('<mujoco><include file="none.xml"/></mujoco>', "none.xml"),
    ],
)
def test_a_scene_that_cannot_be_flown_is_refused_with_one_sentence(tmp_path, scene, sentence):
    path = tmp_path / "scene.xml"
    path.write_text(scene)
    with pytest.raises(RangeError, match=sentence) as error:
        World([DroneConfig("cf1")], scene=path)
    assert "\n" not in str(error.value)
