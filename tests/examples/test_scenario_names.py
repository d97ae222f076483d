"""The sixteen scenarios of the original are there under their names, and each can be flown."""

from pathlib import Path

import pytest

from crazychoir_fw.mission import load_mission
from crazychoir_fw.mission.schema import LayeredMission

FOLDER = Path(__file__).parents[2] / "examples" / "crazychoir"

# drones of each, docs/reference/crazychoir.md#16
SCENARIOS = {
    "formation_rviz": 4,
    "formation_webots": 4,
    "formation_vicon": 4,
    "letter_formation_webots": 11,
    "huge_formation_webots": 30,
    "tracking_webots": 1,
    "tracking_vicon": 1,
    "task_assignment_webots": 6,
    "task_assignment_vicon": 6,
    "goto_webots": 4,
    "collision_webots": 2,
    "collision_webots_vel": 2,
    "aggregative_webots": 3,
    "aggregative_moving_intruders_webots": 6,
    "aggregative_lighthouse": 3,
    "aggregative_moving_intruders_mixed": 6,
}


def test_all_names_are_there():
    assert {path.stem for path in FOLDER.glob("*.yaml")} == set(SCENARIOS)


@pytest.mark.parametrize("name", SCENARIOS)
def test_scenario_is_a_mission_of_so_many_drones(name):
    mission = load_mission(FOLDER / f"{name}.yaml", seed=7)
    assert isinstance(mission, LayeredMission)
    assert mission.name == name
    assert (len(mission.fleet), mission.seed) == (SCENARIOS[name], 7)
    if name.endswith("_vicon"):
        uris = [drone.uri for drone in mission.fleet]
        assert mission.backend == "hardware"
        assert all(uri.startswith("radio://") for uri in uris)
        assert len(set(uris)) == len(uris)
    text = (FOLDER / f"{name}.yaml").read_text()
    assert f"crazychoir fly examples/crazychoir/{name}.yaml" in text
