"""Drones of a mission that fly themselves."""

import pytest

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.flight.engine import fly
from crazychoir_fw.mission.loader import load_mission, parse_mission
from crazychoir_fw.mission.plan import plan_flight

CLIMB = """
from crazychoir_fw.simulation import MotorCtrlVel

class Climb(MotorCtrlVel):
    def init(self, drone, properties):
        self.height = float(properties["height"])
        self.end = float(properties.get("end", 1000))

    def step(self):
        if self.time > self.end:
            raise RuntimeError("no more")
        self.command(0, 0, self.height - self.position[2])
"""

MISSION = """
name: own
drones:
  - {id: mine, position: [0, 0], motor_ctrl: "climb.py:Climb", motor_ctrl_properties: {height: 0.4, end: %s}}
  - {id: cf1, position: [0.6, 0]}
flight:
  - takeoff: {height: 0.5, duration: 1.5}
  - hover: {duration: 1.0}
  - land: {duration: 1.5}
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "climb.py").write_text(CLIMB)
    return tmp_path


def flown(folder, end):
    (folder / "own.yaml").write_text(MISSION % end)
    return fly(load_mission(folder / "own.yaml"), visuals=False)


def test_it_flies_itself_beside_those_that_follow_the_phases(folder):
    result = flown(folder, 1000)
    assert result.failures == []
    mine, other = result.world.drones
    assert mine.true_position[2] == pytest.approx(0.4, abs=0.05)
    assert other.supervisor_state == "Landed"
    assert result.summary["drones"][0]["endpoint_error_m"] is None
    assert result.summary["drones"][1]["endpoint_error_m"] < 0.05


def test_its_failure_is_reported_and_the_others_fly_on(folder):
    result = flown(folder, 2.5)
    assert len(result.failures) == 1
    assert "mine: its motor control failed: Climb: RuntimeError: no more (climb.py:11)" in result.failures[0]
    assert result.world.drones[1].supervisor_state == "Landed"


def plan(data, folder):
    return plan_flight(parse_mission(data, folder=folder, name="m"))


DRONES = [{"id": "a", "position": [0, 0], "motor_ctrl": "MotorCtrlXYZ"}, {"id": "b", "position": [1, 0]}]


def test_phases_command_it_by_name_only(folder):
    everybody = plan({"drones": DRONES, "flight": [{"takeoff": {}}]}, folder)
    assert {command.drone for command in everybody.commands} == {1}
    by_name = plan({"drones": DRONES, "flight": [{"takeoff": {"drones": ["a"]}}]}, folder)
    assert {command.drone for command in by_name.commands} == {0}


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"motor_ctrl": "no.py:Mine"}, r"motor_ctrl is 'no.py:Mine', but must be .*'no.py' is no existing file"),
        ({"motor_ctrl": 3}, "motor_ctrl is 3, but must be the class of a motor control"),
        ({"motor_ctrl": "a b"}, "motor_ctrl is 'a b', but must be the class of a motor control"),
        ({"motor_ctrl_properties": {"height": [1]}}, "motor_ctrl_properties is .*, but must be a mapping from words"),
        ({"motor_ctrl_properties": "height"}, "motor_ctrl_properties is 'height', but must be a mapping from words"),
    ],
)
def test_what_is_no_class_or_property_is_refused(folder, settings, sentence):
    drones = [{"id": "a", "position": [0, 0], **settings}]
    with pytest.raises(MissionError, match=sentence):
        plan({"drones": drones, "flight": [{"takeoff": {}}]}, folder)


def test_a_scene_may_bring_drones_of_its_own(folder):
    model = """
      <mujoco>
        <option timestep="0.001"/>
        <worldbody>
          <geom type="plane" size="5 5 0.1"/>
          <body name="other" pos="0 1 0.0145">
            <freejoint/>
            <inertial pos="0 0 0" mass="0.029" diaginertia="16.57e-6 16.66e-6 29.26e-6"/>
            <geom type="box" size="0.055 0.055 0.0145"/>
            <plugin plugin="crazychoir.crazyflie">
              <config key="motor_ctrl" value="climb.py:Climb"/>
              <config key="motor_ctrl_properties" value="height=0.3"/>
            </plugin>
          </body>
        </worldbody>
      </mujoco>
    """
    (folder / "scene.xml").write_text(model)
    flight = [{"takeoff": {"duration": 1.0}}, {"land": {"duration": 1.0}}]
    data = {"scene": "scene.xml", "drones": [{"id": "cf1", "position": [0, 0]}], "flight": flight}
    result = fly(parse_mission(data, folder=folder, name="m"), visuals=False)
    assert result.failures == []
    assert [drone["id"] for drone in result.summary["drones"]] == ["cf1"]
    assert result.world["other"].true_position[2] == pytest.approx(0.3, abs=0.05)


@pytest.mark.parametrize("where", ["drones", "defaults"])
def test_properties_that_nobody_would_be_told_are_refused(where):
    told = {"motor_ctrl_properties": {"height": 0.4}}
    drones = [{"id": "a", "position": [0, 0], **(told if where == "drones" else {})}]
    mission = {
        "name": "m",
        "drones": drones,
        "defaults": told if where == "defaults" else {},
        "flight": [{"takeoff": {}}],
    }
    who = {"drones": "a", "defaults": "defaults"}[where]
    with pytest.raises(MissionError, match=f"{who}: motor_ctrl_properties are for a motor control, but"):
        parse_mission(mission)


def test_default_properties_reach_those_that_have_a_class():
    mission = {
        "name": "m",
        "drones": DRONES,
        "defaults": {"motor_ctrl_properties": {"k": "v"}},
        "flight": [{"takeoff": {}}],
    }
    assert [dict(drone.motor_ctrl_properties) for drone in parse_mission(mission).fleet] == [{"k": "v"}, {}]
