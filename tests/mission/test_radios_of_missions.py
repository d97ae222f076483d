"""Missions whose drones are commanded through simulated radios."""

import json
import subprocess
import sys

import pytest

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.crtp.link_model import RadioConfig, SimulatedRadios
from crazychoir_fw.flight.backends import simulated_radios
from crazychoir_fw.flight.engine import fly
from crazychoir_fw.mission import parse_mission
from crazychoir_fw.simulation.replay import replay


def refusal_of(mission):
    with pytest.raises(MissionError) as refused:
        parse_mission(mission)
    return str(refused.value).removeprefix("mission: ")


@pytest.mark.parametrize(
    ("radios", "sentence"),
    [
        ("cf1", "radios is 'cf1', but must be a list"),
        (["cf1"], "radios[0] is 'cf1', but must be a mapping such as {drones: [cf1, cf2], loss: 0.05}"),
        ([{"loss": 0.1}], "radios[0] is {'loss': 0.1}, but must be a mapping that names its drones"),
        ([{"drones": "cf1"}], "radios[0].drones is 'cf1', but must be a list of at least one id of a drone"),
        ([{"drones": ["cf1"], "los": 1}], "radios[0] has no key 'los' (did you mean 'loss'?), but only channel, "),
        ([{"drones": ["cf1"], "loss": 30}], "radios[0].loss is 30, but must be a number in [0, 1]"),
        (
            [{"drones": ["cf1"], "data_rate": "2m"}],
            "radios[0].data_rate is '2m', but must be one of 250K, 1M, 2M",
        ),
        ([{"drones": ["cf1"]}, {"drones": ["cf11"]}], "radios[1].drones names 'cf11', but there is no such drone (did"),
        ([{"drones": ["cf*"]}, {"drones": ["cf2"]}], "radios[1].drones names 'cf2', but radios[0] serves it already"),
        (
            [{"drones": ["cf1"], "name": "a"}, {"drones": ["cf2"], "name": "a"}],
            "radios[1].name is 'a', but another radio is called that",
        ),
    ],
)
def test_impossible_radios_are_refused_in_one_sentence(hop, radios, sentence):
    hop["radios"] = radios
    text = refusal_of(hop)
    assert text.startswith(sentence)
    assert "\n" not in text


def test_links_are_made_as_the_file_says(hop):
    assert simulated_radios(parse_mission(hop)) is None
    hop["radios"] = [{"drones": ["cf[12]"], "name": "left", "channel": 100, "data_rate": "250K", "loss": 0.1}]
    mission = parse_mission(hop)
    assert mission.radios == [
        RadioConfig(drones=("cf[12]",), name="left", channel=100, data_rate="250K", loss=0.1),
    ]
    link = simulated_radios(mission)
    assert isinstance(link, SimulatedRadios)
    figures = link.statistics()
    assert figures["radios"]["left"]["drones"] == ["cf1", "cf2"]
    assert figures["drones"]["cf2"]["radio"] == "left"


def test_radios_made_in_python_stand_beside_those_of_a_file(hop):
    hop["radios"] = [RadioConfig(drones=["cf1"]), {"drones": ["cf2"]}]
    assert len(simulated_radios(parse_mission(hop)).dongles) == 2


def flown(hop, loss, **values):
    hop["flight"] = [{"takeoff": {"height": 0.5, "duration": 1.5}}, {"hover": {"duration": 1.0}}, {"land": {}}]
    hop["radios"] = [{"drones": ["*"], "loss": loss, **values}]
    return fly(parse_mission(hop), visuals=False)


def test_a_good_radio_changes_nothing_that_matters(hop):
    result = flown(hop, 0.0)
    assert result.success
    assert json.loads(json.dumps(result.summary["link"])) == result.summary["link"]
    assert all(drone["up"]["lost"] == 0 for drone in result.summary["link"]["drones"].values())


def test_a_third_lost_is_seen_without_repetition_and_not_with_it(hop):
    assert flown(hop, 0.3).success
    # a plan that is sent once may never come
    result = flown(hop, 0.3, retries=0, reliable=False)
    lost = [drone["up"]["lost"] for drone in result.summary["link"]["drones"].values()]
    assert sum(lost) > 0
    assert not result.success


def test_at_total_loss_nobody_leaves_the_floor(hop):
    result = flown(hop, 1.0)
    assert not result.success
    assert result.failures[0].startswith("cf1: missed the target of flight[0].takeoff by 0.49 m")
    assert [drone["supervisor_state"] for drone in result.summary["drones"]] == ["Ready to fly"] * 2
    assert all(drone["lost_links"] >= 1 for drone in result.summary["link"]["drones"].values())


def test_flights_by_radio_are_flown_again_without_one(hop, tmp_path):
    result = flown(hop, 0.3, latency_ms=20.0)
    result.log.save(tmp_path / "log.npz")
    assert replay(tmp_path / "log.npz").deviation is None


def test_a_mission_without_radios_is_checked_without_the_simulation():
    code = (
        "import sys; from crazychoir_fw.mission import parse_mission; "
        "parse_mission({'name': 'a', 'drones': {'count': 1}, 'flight': ['takeoff', 'land'], 'radios': []}); "
        "print('crazychoir_fw.simulation' in sys.modules, 'crazychoir_fw.crtp' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]
