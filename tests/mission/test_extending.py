"""Missions that extend others, and single values that the command line changes."""

import copy

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.flight.agents import formation_of, graph_of
from crazychoir_fw.mission import load_mission, parse_mission
from crazychoir_fw.mission.documents import apply, files_of, merged, read_change

BASE = """
name: base
seed: 3
defaults: {platform: cf2, noise: 0.5}
drones:
  - {id: a, position: [0, 0]}
  - {id: b, position: [1, 0]}
flight:
  - takeoff: {height: 1.0, duration: 2.0}
  - hover: {duration: 3.0}
  - land: {duration: 2.0}
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "base.yaml").write_text(BASE)
    return tmp_path


def write(folder, name, text):
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)
    return path


def complaint(path, **overrides):
    with pytest.raises(MissionError) as caught:
        load_mission(path, **overrides)
    text = str(caught.value)
    assert "\n" not in text
    return text


# ---------------------------------------------------------------- extends


def test_mappings_are_merged_and_lists_replaced(folder):
    path = write(folder, "mine.yaml", "extends: base.yaml\ndefaults: {noise: 0}\ndrones: [{id: c, position: [2, 2]}]\n")
    mission = load_mission(path)
    assert (mission.seed, mission.defaults.platform, mission.defaults.noise) == (3, "cf2", 0.0)
    assert [drone.id for drone in mission.fleet] == ["c"]
    assert [phase.name for phase in mission.flight] == ["takeoff", "hover", "land"]


def test_a_name_is_not_inherited(folder):
    assert load_mission(write(folder, "mine.yaml", "extends: base.yaml\n")).name == "mine"
    assert load_mission(write(folder, "other.yaml", "extends: base.yaml\nname: ours\n")).name == "ours"


def test_layout_replaces_a_list_and_is_merged_with_a_layout(folder):
    write(folder, "six.yaml", "extends: base.yaml\ndrones: {count: 6, layout: circle, spacing: 1.0}\n")
    mission = load_mission(write(folder, "eight.yaml", "extends: six.yaml\ndrones: {count: 8}\n"))
    assert len(mission.fleet) == 8
    np.testing.assert_allclose(np.diff([np.hypot(*drone.position) for drone in mission.fleet]), 0.0, atol=1e-9)


def test_files_are_found_beside_the_mission_that_names_them_and_a_nearer_one_wins(folder):
    write(folder, "bird.csv", "0,0,0,1\n1,1,0,1\n")
    text = BASE.replace("  - hover", "  - trajectory: {file: bird.csv}\n  - hover")
    write(folder, "base.yaml", text.replace("{height: 1.0, duration", "{duration") + LAYERS)
    below = write(folder, "below/mine.yaml", "extends: ../base.yaml\n")
    assert load_mission(below).flight[1].maneuver.rows[1] == (1.0, 1.0, 0.0, 1.0)
    write(folder, "below/bird.csv", "0,0,0,1\n7,1,0,1\n")
    assert load_mission(below).flight[1].maneuver.duration == 7.0


LAYERS = """
layers:
  guidance: {class: SimpleGuidance}
  planning: {class: Spline}
  control: {gains: mujoco}
"""


def test_complaints_name_the_file_in_which_the_key_stands(folder):
    write(folder, "middle.yaml", "extends: base.yaml\ndefaults: {noise: -1}\n")
    path = write(folder, "mine.yaml", "extends: middle.yaml\nseed: 4\n")
    assert complaint(path).startswith(
        f"{folder / 'middle.yaml'} (extended by {path}): defaults.noise is -1, but must be a number"
    )
    write(folder, "middle.yaml", "extends: base.yaml\ndefaults: {nose: 1}\n")
    assert complaint(path).startswith(f"{folder / 'middle.yaml'} (extended by {path}): defaults has no key 'nose'")
    path = write(folder, "mine.yaml", "extends: base.yaml\nflight: [{hover: {duration: -1}}]\n")
    assert complaint(path).startswith(f"{path}: flight[0].hover.duration is -1")
    write(folder, "base.yaml", BASE.replace("id: b", "id: a"))
    path = write(folder, "mine.yaml", "extends: base.yaml\n")
    assert complaint(path).startswith(f"{folder / 'base.yaml'} (extended by {path}): drones[1].id is 'a'")


def test_circles_are_refused(folder):
    one = write(folder, "one.yaml", "extends: two.yaml\n")
    two = write(folder, "two.yaml", "extends: one.yaml\n")
    assert complaint(one).startswith(f"{two}: extends is 'one.yaml', but that file extends this one")
    itself = write(folder, "itself.yaml", "extends: ./itself.yaml\n")
    assert "but that file extends this one" in complaint(itself)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("extends: bass.yaml", "(did you mean 'base.yaml'?)"),
        ("extends: [base.yaml]", "but must be a mission file such as"),
        ("extends: ''", "but must be a mission file such as"),
        ('extends: "a\\0b.yaml"', "but must be an existing mission file"),
        ("extends: .", "but must be an existing mission file"),
        ("extend: base.yaml", "a mission has no key 'extend' (did you mean 'extends'?)"),
    ],
)
def test_what_cannot_be_extended_is_refused(folder, content, says):
    assert says in complaint(write(folder, "mine.yaml", content + "\n"))


def test_a_base_that_is_no_mapping_or_no_yaml_is_named(folder):
    path = write(folder, "mine.yaml", "extends: base.yaml\n")
    for content in ("- 1\n", "a: [\n", ""):
        base = write(folder, "base.yaml", content)
        assert complaint(path).startswith(str(base))


def test_mappings_that_contain_themselves_are_refused(folder):
    write(folder, "base.yaml", "drones: &a {x: *a}\n")
    path = write(folder, "mine.yaml", "extends: base.yaml\ndrones: &a {x: *a}\n")
    assert "line 2, column 16: the alias *a stands inside of what it stands for" in complaint(path)


def test_watching_looks_at_all_files(folder):
    path = write(folder, "mine.yaml", "extends: base.yaml\n")
    assert files_of(path) == [path, folder / "base.yaml"]
    assert files_of(folder / "gone.yaml") == [folder / "gone.yaml"]


TREES = st.recursive(
    st.integers() | st.lists(st.integers(), max_size=2),
    lambda inner: st.dictionaries(st.sampled_from("abc"), inner, max_size=3),
    max_leaves=8,
)


@given(a=TREES, b=TREES, c=TREES)
def test_merging_is_idempotent_and_leaves_its_arguments_alone(a, b, c):
    before = copy.deepcopy((a, b))
    once = merged(a, b)
    assert (a, b) == before
    assert merged(once, b) == once
    if all(isinstance(tree, dict) for tree in (a, b, c)):
        assert set(merged(a, b)) == set(a) | set(b)


# ---------------------------------------------------------------- --set


def hop():
    return yaml.safe_load(BASE)


def changed(*texts):
    return parse_mission(hop(), "hop.yaml", changes=texts)


def test_values_are_yaml_at_key_paths():
    mission = changed(
        "seed=9",
        "drones[1].position=[2, 3]",
        "drones.a.yaw_deg=30",
        "flight.takeoff.height=0.7",
        "flight.1.hover.duration=4",
        "defaults={noise: 0.1}",
        "defaults.parameters.colAv.enable=1",
        "description=a: b"[:13],
    )
    assert mission.seed == 9
    assert mission.fleet[1].position == (2.0, 3.0)
    assert mission.fleet[0].yaw_deg == 30.0
    assert mission.flight[0].takeoff.height == 0.7
    assert mission.flight[1].hover.duration == 4.0
    assert (mission.defaults.noise, mission.defaults.platform) == (0.1, "cf2")
    assert mission.fleet[0].parameters == {"colAv.enable": 1.0}


def test_later_changes_and_named_arguments_are_stronger():
    mission = parse_mission(hop(), "hop.yaml", seed=5, changes=["seed=1", "drones={count: 3}", "drones.count=4"])
    assert mission.seed == 5
    assert len(mission.fleet) == 4


def test_a_phase_that_is_a_word_gets_keys():
    data = hop() | {"flight": ["takeoff", "land"]}
    assert parse_mission(data, changes=["flight.takeoff.height=0.7"]).flight[0].takeoff.height == 0.7


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("seed", "--set is 'seed', but must be a key and a value"),
        ("=3", "but must be a key and a value"),
        ("seed=-1", "--set seed=-1: seed is -1, but must be a whole number"),
        ("sed=1", "--set sed=1: a mission has no key 'sed' (did you mean 'seed'?)"),
        ("defaults.nose=1", "--set defaults.nose=1: defaults has no key 'nose' (did you mean 'noise'?)"),
        ("defaultz.noise=1", "--set defaultz.noise=1: a mission has no key 'defaultz' (did you mean 'defaults'?)"),
        ("drones.aa.position=[0, 0]", "drones has no entry 'aa' (did you mean 'a'?)"),
        ("drones[7].position=[0, 0]", "drones has no entry 7, but 2, from 0 on"),
        ("flight.hover.height=1", "--set flight.hover.height=1: flight[1].hover has no key 'height'"),
        ("seed.x=1", "--set seed.x=1: seed is 3, with no keys such as x"),
        ("seed[0]=1", "--set seed[0]=1: seed is 3, with no entry 0"),
        ("drones[0=1", "is no key"),
        ("..=1", "is no key"),
        ("seed=[", "--set seed=[, line 1"),
        ("extends=base.yaml", "stands in its file only"),
        ("drones[1].position=[0, 0.05]", "--set drones[1].position=[0, 0.05]: drones[1].position is"),
    ],
)
def test_what_cannot_be_changed_is_refused(text, says):
    with pytest.raises(MissionError) as caught:
        changed(text)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_one_of_several_phases_must_be_named():
    data = hop() | {"flight": ["takeoff", {"hover": {"duration": 1}}, {"hover": {"duration": 2}}, "land"]}
    with pytest.raises(MissionError, match=r"flight has 2 entries 'hover', name one: flight\[1\], flight\[2\]"):
        parse_mission(data, changes=["flight.hover.duration=3"])


def test_complaints_about_the_rest_name_the_file():
    data = hop() | {"seed": -3}
    with pytest.raises(MissionError, match=r"^hop.yaml: seed is -3"):
        parse_mission(data, "hop.yaml", changes=["defaults.noise=1"])


def test_shared_parts_of_a_file_are_changed_in_one_place_only():
    shared = {"duration": 1.0}
    data, _ = apply({"flight": [{"hover": shared}, {"hover": shared}]}, [read_change("flight[0].hover.duration=2")])
    assert [phase["hover"]["duration"] for phase in data["flight"]] == [2, 1.0]
    assert shared == {"duration": 1.0}


@given(path=st.text(max_size=12), value=st.text(max_size=12))
def test_any_text_is_a_change_or_refused_in_one_sentence(path, value):
    try:
        parse_mission(hop(), changes=[f"{path}={value}"])
    except MissionError as error:
        assert "\n" not in str(error)


def test_fly_takes_changes(folder):
    path = write(folder, "mine.yaml", "extends: base.yaml\n")
    options = ["--set", "drones={count: 1}", "--set", "flight.hover.duration=0.5", "--no-video", "--out", str(folder)]
    result = CliRunner().invoke(app, ["fly", str(path), *options])
    assert result.exit_code == 0, result.output
    with np.load(folder / "log.npz", allow_pickle=False) as log:
        assert log["signal/sim.x"].shape[1] == 1
    refused = CliRunner().invoke(app, ["fly", str(path), "--set", "flight.hovr.duration=0.5"])
    assert refused.exit_code == 2
    assert "did you mean 'hover'?" in refused.stderr


def test_formation_and_graph_by_rule_fit_any_number_of_drones():
    data = {
        "name": "round",
        "drones": {"count": 4, "layout": "circle"},
        "layers": {
            "communication": {"graph": "ring"},
            "guidance": {
                "class": "BearingFormation",
                "leaders": ["cf1", "cf2", "cf3"],
                "formation": {"layout": "circle", "spacing": 1.5},
                "height": 0.8,
            },
            "planning": {"class": "Spline"},
            "control": {},
        },
        "flight": ["takeoff", {"start": {"duration": 1}}],
    }
    mission = parse_mission(data, changes=["drones.count=5", "layers.guidance.leaders=[cf1, cf2, cf3, cf4]"])
    places = formation_of(mission)
    np.testing.assert_allclose(np.linalg.norm(places - np.roll(places, 1, axis=0), axis=1), 1.5)
    np.testing.assert_allclose(places[:, 2], 0.8)
    assert graph_of(mission).pairs == ((0, 1), (0, 4), (1, 2), (2, 3), (3, 4))
    assert graph_of(mission).names[4] == "cf5"


def test_a_directed_path_is_heard_one_way():
    data = hop() | {
        "layers": {"communication": {"graph": "path", "directed": True}, "guidance": {"class": "SimpleGuidance"}}
    }
    data["flight"] = ["takeoff"]
    assert graph_of(parse_mission(data)).edges == ((0, 1),)
