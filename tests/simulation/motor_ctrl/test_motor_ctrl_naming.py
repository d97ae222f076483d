"""From the words of a file to a class."""

import textwrap

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.errors import CrazychoirError, RangeError, UnknownNameError
from crazychoir_fw.simulation import DroneConfig, MotorCtrlFPQR, MotorCtrlXYZ, World
from crazychoir_fw.simulation.motor_ctrl.pilots import find_class
from crazychoir_fw.simulation.motor_ctrl_words import class_name, parse_properties, properties_text

MODEL = """
<mujoco>
  <option timestep="0.001"/>
  <extension>
    <plugin plugin="crazychoir.crazyflie"><instance name="named">{first}</instance></plugin>
  </extension>
  <worldbody>
    <geom type="plane" size="5 5 0.1"/>
    <body name="bird" pos="0 0 0.0145">
      <freejoint/>
      <inertial pos="0 0 0" mass="0.029" diaginertia="16.57e-6 16.66e-6 29.26e-6"/>
      <geom type="box" size="0.055 0.055 0.0145"/>
      <plugin plugin="crazychoir.crazyflie" instance="named"/>
    </body>
    <body {second_name} pos="1 0 0.0145" euler="0 0 90">
      <freejoint/>
      <inertial pos="0 0 0" mass="0.033" diaginertia="16.57e-6 16.66e-6 29.26e-6"/>
      <geom type="box" size="0.055 0.055 0.0145"/>
      <plugin plugin="crazychoir.crazyflie">
        <config key="platform" value="cf21bl"/><config key="seed" value="4"/><config key="battery" value="0.5"/>
      </plugin>
    </body>
  </worldbody>
</mujoco>
"""

RISE = """
from dataclasses import dataclass
from crazychoir_fw.simulation import MotorCtrlVel

@dataclass
class Gain:
    value: float = 1.0

class Rise(MotorCtrlVel):
    def init(self, drone, properties):
        self.height = float(properties["height"])

    def step(self):
        self.command(0, 0, Gain().value * (self.height - self.position[2]))
"""


def write(folder, first="", second_name='name="plane"'):
    path = folder / "model.xml"
    path.write_text(MODEL.format(first=first, second_name=second_name))
    return path


def config(**keys):
    return "".join(f'<config key="{key}" value="{value}"/>' for key, value in keys.items())


def test_a_body_names_the_class_that_flies_it(tmp_path, monkeypatch):
    (tmp_path / "rise.py").write_text(RISE)
    path = write(tmp_path, config(motor_ctrl="rise.py:Rise", motor_ctrl_properties="height=0.4"))
    monkeypatch.chdir("/")
    world = World.from_mjcf(path, seed=7)
    world.wait_until_ready()
    world.run(3.0)
    bird, plane = world.drones
    assert (bird.id, plane.id) == ("bird", "plane")
    assert type(bird.motor_ctrl).__name__ == "Rise"
    assert bird.true_position[2] == pytest.approx(0.4, abs=0.05)
    assert plane.motor_ctrl is None
    assert (plane.config.platform, plane.config.battery, plane.config.attributes) == ("cf21bl", 0.5, {"seed": "4"})
    assert plane.config.yaw_deg == pytest.approx(90.0)
    assert [drone.struct.config.seed for drone in world.drones] == [7, 4]
    assert plane.mass == pytest.approx(0.033)


def test_drones_of_a_scene_come_after_those_of_the_world(tmp_path):
    world = World([DroneConfig("cf1", (-1.0, 0.0))], scene=write(tmp_path), seed=3)
    assert [drone.id for drone in world.drones] == ["cf1", "bird", "plane"]
    # no two drones share noise or radio address
    assert [drone.struct.config.id for drone in world.drones] == [2, 0, 1]


def test_the_model_remembers_the_class(tmp_path):
    config = DroneConfig("cf1", motor_ctrl=MotorCtrlXYZ, motor_ctrl_properties={"a": "b c", "d": 1.5})
    world = World([config])
    from crazychoir_fw.simulation.model_drones import drones_in

    (found,) = drones_in(world.model, (), tmp_path)
    assert found.motor_ctrl == "MotorCtrlXYZ"
    assert found.motor_ctrl_properties == {"a": "b c", "d": "1.5"}


def test_a_drone_without_a_name_is_refused(tmp_path):
    with pytest.raises(RangeError, match="body 2 carries a Crazyflie and has no name"):
        World.from_mjcf(write(tmp_path, second_name=""))


@pytest.mark.parametrize("text", ["<mujoco/>", "no model"])
def test_a_model_without_drones_is_refused(tmp_path, text):
    path = tmp_path / "empty.xml"
    path.write_text(text)
    with pytest.raises(RangeError, match=r"empty\.xml"):
        World.from_mjcf(path)


def test_properties_without_a_class_are_refused(tmp_path):
    sentence = r": motor_ctrl_properties \(height\) are for a motor control, but motor_ctrl names none"
    with pytest.raises(RangeError, match="bird" + sentence):
        World.from_mjcf(write(tmp_path, config(motor_ctrl_properties="height=0.4")))
    with pytest.raises(RangeError, match="cf1" + sentence):
        World([DroneConfig("cf1", motor_ctrl_properties={"height": 0.4})])


def test_bad_properties_are_refused(tmp_path):
    with pytest.raises(RangeError, match="bird: motor_ctrl_properties has the word 'high', allowed: key=value"):
        World.from_mjcf(write(tmp_path, config(motor_ctrl="MotorCtrlFPQR", motor_ctrl_properties="low=1 high")))


@settings(max_examples=25)
@given(st.dictionaries(st.from_regex(r"\A[a-z_]+\Z"), st.text(st.characters(exclude_categories=["C"]))))
def test_properties_survive_their_text(properties):
    assert parse_properties(properties_text(properties), "cf1") == properties


@pytest.mark.parametrize(
    ("name", "error", "sentence"),
    [
        ("MotorCtrlFPQ", UnknownNameError, r"did you mean MotorCtrlFPQR\?"),
        ("no_such_package.control:Mine", UnknownNameError, "there is no module no_such_package"),
        ("json.nothing:Mine", UnknownNameError, "there is no module json.nothing"),
        ("json:Mine", UnknownNameError, "no such class, only no motor control at all"),
        ("json:JSONDecoder", RangeError, "is no motor control, allowed: a subclass of MotorCtrl"),
        ("nothing.py:Mine", UnknownNameError, r"there is no file .*nothing\.py"),
        ("broken.py:Mine", CrazychoirError, r"cannot be imported: SyntaxError: .* \(broken\.py:2\)"),
        ("raises.py:Mine", CrazychoirError, r"cannot be imported: RuntimeError: on import \(raises\.py:3\)"),
        ("rise.py:Fall", UnknownNameError, "there is no such class, only Rise"),
    ],
)
def test_what_is_no_class_is_refused_with_a_sentence(tmp_path, monkeypatch, name, error, sentence):
    (tmp_path / "broken.py").write_text("import json\nclass Mine(:\n")
    (tmp_path / "raises.py").write_text("import json\n\nraise RuntimeError('on import')\n")
    (tmp_path / "rise.py").write_text(RISE)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(error, match=f"cf1: motor_ctrl .*{sentence}"):
        World([DroneConfig("cf1", motor_ctrl=name)])


def test_a_class_by_import_path_and_one_that_is_given(tmp_path, monkeypatch):
    (tmp_path / "my_controls.py").write_text(textwrap.dedent(RISE))
    monkeypatch.syspath_prepend(tmp_path)
    assert find_class("my_controls:Rise", "cf1").__name__ == "Rise"
    assert find_class(class_name(MotorCtrlFPQR), "cf1") is MotorCtrlFPQR
    assert class_name(find_class("my_controls:Rise", "cf1")) == "my_controls:Rise"
    with pytest.raises(RangeError, match="cf1: motor_ctrl: <class 'int'> is no motor control"):
        World([DroneConfig("cf1", motor_ctrl=int)])


def test_what_was_saved_flies(tmp_path):
    path = tmp_path / "rise.py"
    path.write_text(RISE)
    first = find_class(f"{path}:Rise", "cf1")
    path.write_text(RISE + "\n    rate_hz = 50\n")
    assert first.rate_hz == 100
    assert find_class(f"{path}:Rise", "cf1").rate_hz == 50


def test_the_engine_plugin_ignores_what_is_for_the_world(tmp_path):
    model = mujoco.MjModel.from_xml_path(str(write(tmp_path, config(motor_ctrl="nowhere.py:Nothing"))))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=10)
    assert data.time == pytest.approx(10 * model.opt.timestep) and np.isfinite(data.qpos).all()
