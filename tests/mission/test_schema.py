"""A bad mission file ends in one sentence that names file, key, value and what is allowed."""

import copy

import pytest
import yaml
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.errors import CrazychoirError, MissionError
from crazychoir_fw.flight.backends import build_world
from crazychoir_fw.mission import Mission, load_mission, parse_mission

NAN = float("nan")
INF = float("inf")


def put(mission, keys, value):
    """Return a copy of *mission* with one value replaced; the last key may be new."""
    mission = copy.deepcopy(mission)
    place = mission
    for key in keys[:-1]:
        place = place[key]
    place[keys[-1]] = value
    return mission


def complaint(data):
    """Return the one sentence about a bad mission, after checking that it is one."""
    with pytest.raises(MissionError) as caught:
        parse_mission(data, source="hop.yaml")
    text = str(caught.value)
    assert text.startswith("hop.yaml")
    assert "\n" not in text
    return text


# key path, bad value, what the sentence must say besides the file
BAD_VALUES = [
    (["seed"], -1, ["seed is -1", "whole number in [0, 4294967295]"]),
    (["seed"], 1.5, ["seed is 1.5", "whole number"]),
    (["seed"], True, ["seed is True", "whole number"]),
    (["name"], "a/../b", ["name is 'a/../b'", "letters"]),
    (["name"], "..", ["name is '..'", "letters"]),
    (["name"], 7, ["name is 7", "letters"]),
    (["description"], 7, ["description is 7", "text"]),
    (["backend"], "hardwear", ["backend is 'hardwear'", "must be sim"]),
    (["scene"], "aren", ["scene is 'aren'", "did you mean 'arena'?", "flight_lab"]),
    (["scene"], "a" * 5000 + ".xml", ["scene is 'aaa", "existing .xml or .yaml file"]),
    (["scene"], "a\0b.xml", ["scene is", "existing .xml or .yaml file"]),
    (["scene"], "gone.xml", ["scene is 'gone.xml'", "existing .xml or .yaml file"]),
    (["drones"], [], ["drones is []", "at least 1"]),
    (["drones"], "cf1", ["drones is 'cf1'", "a list"]),
    (["drones"], {"count": 0}, ["drones.count is 0", "[1, 10000]"]),
    (["drones"], {"count": 3, "spacing": 0.1}, ["drones.spacing is 0.1", "[0.15, 100] m"]),
    (["drones"], {"count": 3, "layout": "gird"}, ["drones.layout is 'gird'", "did you mean 'grid'?"]),
    (["drones"], {"layout": "grid"}, ["drones.count is missing"]),
    (["drones", 0], 3, ["drones[0] is 3", "a mapping"]),
    (["drones", 0, "id"], "cf 1", ["drones[0].id is 'cf 1'", "such as cf1"]),
    (["drones", 1, "id"], "cf1", ["drones[1].id is 'cf1'", "unique", "drones[0]"]),
    (["drones", 1, "position"], [0.05, 0], ["drones[1].position is [0.05, 0.0]", "0.15 m from cf1", "0.05 m"]),
    (["drones", 1, "position"], [NAN, 0], ["drones[1].position is [nan, 0]", "[-1000, 1000] m"]),
    (["drones", 1, "position"], [0], ["drones[1].position is [0]", "[x, y, [z]]"]),
    (["drones", 1, "position"], [0, 0, -1], ["drones[1].position", "z >= 0"]),
    (["drones", 1, "position"], "xy", ["drones[1].position is 'xy'", "[x, y, [z]]"]),
    (["drones", 1, "yaw_deg"], "north", ["drones[1].yaw_deg is 'north'", "[-360, 360] deg"]),
    (["drones", 1, "platform"], "cf21b", ["drones[1].platform is 'cf21b'", "did you mean 'cf21bl'?", "cf2, cf21bl"]),
    (["drones", 1, "mass"], -0.03, ["drones[1].mass is -0.03", "[0.005, 0.5] kg"]),
    (["drones", 1, "controller"], "pd", ["drones[1].controller is 'pd'", "did you mean 'pid'?"]),
    (["drones", 1, "positoning"], "mocap", ["drones[1] has no key 'positoning'", "did you mean 'positioning'?"]),
    (["defaults"], {"battery": 0}, ["defaults.battery is 0", "[0.01, 1]"]),
    (["defaults"], {"noise": NAN}, ["defaults.noise is nan", "[0, 100]"]),
    (["defaults"], {"provider": "my own"}, ["defaults.provider is 'my own'", "the name of a provider", "builtin"]),
    (["defaults"], {"id": "cf1"}, ["defaults has no key 'id'", "platform"]),
    (["defaults"], {"parameters": 1}, ["defaults.parameters is 1", "a mapping from onboard parameters to numbers"]),
    (
        ["defaults"],
        {"parameters": {"colAv.enable_": 1}},
        ["defaults.parameters is {'colAv.enable_': 1}", "did you mean 'colAv.enable'?"],
    ),
    (["defaults"], {"parameters": {1: 1}}, ["defaults.parameters is {1: 1}", "a mapping from onboard parameters"]),
    (["defaults"], {"parameters": {"colAv.enable": 256}}, ["a whole number in [0, 255] for colAv.enable"]),
    (["defaults"], {"parameters": {"colAv.enable": 0.5}}, ["a whole number in [0, 255] for colAv.enable"]),
    (["defaults"], {"parameters": {"colAv.enable": True}}, ["a whole number in [0, 255] for colAv.enable"]),
    (["drones", 1, "parameters"], {"colAv.horizon": NAN}, ["drones[1].parameters", "a number in", "for colAv.horizon"]),
    (["drones", 1, "parameters"], {"colAv.horizon": 1e39}, ["drones[1].parameters", "[-3.40282e+38, 3.40282e+38]"]),
    (["tolerance"], {"endpoint": 0}, ["tolerance.endpoint is 0", "[0.001, 10] m"]),
    (["fligth"], [], ["a mission has no key 'fligth'", "did you mean 'flight'?"]),
    (["flight"], [], ["flight is []", "at least 1"]),
    (["flight"], {"takeoff": {}}, ["flight is {'takeoff': {}}", "a list"]),
    (["flight", 0], "takeof", ["flight[0] is 'takeof'", "a mapping"]),
    (["flight", 0], {}, ["flight[0] is {}", "exactly one of takeoff"]),
    (["flight", 0], {"takeoff": {}, "land": {}}, ["flight[0]", "exactly one of takeoff"]),
    (["flight", 0], {"takeof": {}}, ["flight[0] has no key 'takeof'", "did you mean 'takeoff'?"]),
    (["flight", 0, "takeoff", "hieght"], 1, ["flight[0].takeoff has no key 'hieght'", "did you mean 'height'?"]),
    (["flight", 0, "takeoff", "height"], "1 m", ["flight[0].takeoff.height is '1 m'", "[0.05, 100] m"]),
    (["flight", 0, "takeoff", "height"], INF, ["flight[0].takeoff.height is inf", "[0.05, 100] m"]),
    (["flight", 0, "takeoff", "duration"], 0, ["flight[0].takeoff.duration is 0", "[0.1, 3600] s"]),
    (["flight", 0, "takeoff", "drones"], ["cf9"], ["flight[0].takeoff.drones names 'cf9'", "did you mean"]),
    (["flight", 0, "takeoff", "drones"], "cf1", ["flight[0].takeoff.drones is 'cf1'", "a list"]),
    (["flight", 0, "takeoff", "drones"], ["cf1"], ["flight[2].land: cf2 is on the floor there"]),
    (["flight", 1], {"hover": {}}, ["flight[1].hover.duration is missing"]),
    (["flight", 1], "takeoff", ["flight[1].takeoff: cf1 flies already"]),
    (["flight", 1], {"go_to": {"duration": 1}}, ["flight[1].go_to", "either position or offset"]),
    (
        ["flight", 1],
        {"go_to": {"duration": 1, "position": [0, 0, 1], "offset": [0, 0, 0]}},
        ["flight[1].go_to", "either position or offset"],
    ),
    (
        ["flight", 1],
        {"go_to": {"duration": 1, "position": [0, 0, 1]}},
        ["flight[1].go_to.position sends 2 drones to one point", "drones: [id]"],
    ),
    (
        ["flight", 1],
        {"go_to": {"duration": 1, "offset": [0, 0, -2]}},
        ["flight[1].go_to sends cf1 to z = -1 m", "below the floor"],
    ),
    (
        ["flight", 1],
        {"go_to": {"duration": 1, "offset": [0, 0, 0], "linear": "perhaps"}},
        ["flight[1].go_to.linear is 'perhaps'", "true or false"],
    ),
    (
        ["flight", 1],
        {"route": {"points": [[0, 0, 1], [0, 1]], "leg_duration": 1}},
        ["flight[1].route.points[1] is [0, 1]", "[x, y, z]"],
    ),
    (
        ["flight", 1],
        {"route": {"points": [], "leg_duration": 1}},
        ["flight[1].route.points is []", "at least 1"],
    ),
    (["flight", 1], {"trajectory": {}}, ["flight[1].trajectory", "either file or pieces"]),
    (["flight", 1], {"trajectory": {"file": "gone.csv"}}, ["flight[1].trajectory", "gone.csv cannot be read"]),
    (["flight", 1], {"trajectory": {"file": "a\0b"}}, ["flight[1].trajectory: a\\x00b is no file name"]),
    (
        ["flight", 1],
        {"trajectory": {"pieces": [{"duration": 1, "x": [0, NAN]}]}},
        ["flight[1].trajectory.pieces[0].x[1] is nan", "[-1e+06, 1e+06]"],
    ),
    (
        ["flight", 1],
        {"trajectory": {"pieces": [{"duration": 1, "x": [0.0] * 9}]}},
        ["flight[1].trajectory.pieces[0].x is [0.0", "at most 8"],
    ),
    (
        ["flight", 1],
        {"trajectory": {"pieces": [{"duration": 1, "x": [0]}] * 32}},
        ["flight[1].trajectory.pieces", "at most 31"],
    ),
    (
        ["flight", 1],
        {"together": [{"hover": {"duration": 1}}, {"go_to": {"duration": 1, "offset": [0, 0, 0], "drones": ["cf2"]}}]},
        ["flight[1].together gives cf2 two orders at once", "[0]", "[1]"],
    ),
]


@pytest.mark.parametrize(("keys", "value", "says"), BAD_VALUES, ids=lambda v: str(v)[:50])
def test_bad_value_is_refused_with_key_value_and_range(hop, keys, value, says):
    text = complaint(put(hop, keys, value))
    for part in says:
        assert part in text


@pytest.mark.parametrize("key", ["drones", "flight", "name"])
def test_missing_key_is_named(hop, key):
    del hop[key]
    assert complaint(hop) == f"hop.yaml: {key} is missing"


def test_typo_is_reported_rather_than_the_key_it_leaves_missing(hop):
    hop["drone"] = hop.pop("drones")
    assert "has no key 'drone' (did you mean 'drones'?)" in complaint(hop)


def test_whole_mission_is_a_mission(hop):
    mission = parse_mission(hop)
    assert [drone.id for drone in mission.fleet] == ["cf1", "cf2"]
    assert [phase.name for phase in mission.flight] == ["takeoff", "hover", "land"]


def test_phase_without_settings_may_be_a_word(hop):
    hop["flight"] = ["takeoff", {"land": None}]
    mission = parse_mission(hop)
    assert mission.flight[0].takeoff.height == 0.5
    assert mission.flight[1].land.duration == 2.0


def test_own_settings_beat_defaults_and_defaults_beat_the_package(hop):
    hop["defaults"] = {"platform": "cf21bl", "noise": 0.5}
    hop["drones"][0]["noise"] = 2.0
    first, second = parse_mission(hop).fleet
    assert (first.platform, first.noise, first.positioning) == ("cf21bl", 2.0, "mocap")
    assert (second.platform, second.noise) == ("cf21bl", 0.5)


def test_own_parameters_add_to_those_of_all(hop):
    hop["defaults"] = {"parameters": {"colAv.enable": 1, "colAv.horizon": 2}}
    hop["drones"][0]["parameters"] = {"colAv.horizon": 0.5}
    mission = parse_mission(hop)
    first, second = mission.fleet
    assert first.parameters == {"colAv.enable": 1, "colAv.horizon": 0.5}
    assert second.parameters == {"colAv.enable": 1, "colAv.horizon": 2}
    world = build_world(mission, visuals=False)
    assert [drone.param["colAv.horizon"] for drone in world.drones] == [0.5, 2.0]


def test_parameters_of_a_layout_are_those_of_all_its_drones(hop):
    hop["drones"] = {"count": 2, "parameters": {"colAv.enable": 1}}
    assert [drone.parameters for drone in parse_mission(hop).fleet] == [{"colAv.enable": 1}] * 2


@pytest.mark.parametrize("layout", ["grid", "line", "circle"])
@pytest.mark.parametrize("count", [1, 2, 7, 100])
def test_layout_places_all_drones_apart_around_its_center(hop, layout, count):
    hop["drones"] = {"count": count, "layout": layout, "spacing": 0.15, "center": [2, 3], "platform": "cf21bl"}
    fleet = parse_mission(hop).fleet
    assert [drone.id for drone in fleet] == [f"cf{i}" for i in range(1, count + 1)]
    assert {drone.platform for drone in fleet} == {"cf21bl"}
    if layout != "grid" or count in (1, 100):
        assert sum(drone.position[0] for drone in fleet) / count == pytest.approx(2.0)
        assert sum(drone.position[1] for drone in fleet) / count == pytest.approx(3.0)


def test_seed_override_beats_the_file(hop):
    assert parse_mission(hop, seed=7).seed == 7
    with pytest.raises(MissionError, match=r"seed is -7, but must be a whole number in \[0"):
        parse_mission(hop, seed=-7)


def test_provider_override_is_checked(hop):
    assert {drone.provider for drone in parse_mission(hop, provider="builtin").fleet} == {"builtin"}
    assert {drone.provider for drone in parse_mission(hop, provider="bitcraze").fleet} == {"bitcraze"}
    with pytest.raises(MissionError, match="provider is '', but must be the name of a provider"):
        parse_mission(hop, provider="")


def test_parameters_of_software_that_is_loaded_later_are_left_to_the_flight(hop):
    hop["defaults"] = {"parameters": {"myOwn.gain": 2.0}}
    assert parse_mission(hop, provider="builtin+my_own").fleet[0].parameters == {"myOwn.gain": 2.0}
    hop["defaults"]["provider"] = "bitcraze"
    assert parse_mission(hop).fleet[0].parameters == {"myOwn.gain": 2.0}
    for spoilt in ({"parameters": {"myOwn.gain": float("nan")}}, {"parameters": {"gain": 1.0}}):
        with pytest.raises(MissionError, match="a mapping from onboard parameters to numbers"):
            parse_mission({**hop, "defaults": {**hop["defaults"], **spoilt}})
    with pytest.raises(MissionError, match=r"defaults.parameters is \{'myOwn.gain': 2.0\}"):
        parse_mission(hop, provider="builtin")


# -- files ---------------------------------------------------------------------------------------------------------

BAD_FILES = [
    (b"", "is empty, but must be a mapping"),
    (b"# only a comment\n", "is empty, but must be a mapping"),
    (b"- a\n- b\n", "is ['a', 'b'], but must be a mapping"),
    (b"just words", "is 'just words', but must be a mapping"),
    (b"\xff\xfe\x00\x01", "is not a text file"),
    (b"name: a\nseed: \x00", "line 2: the character"),
    (b"name: a\nflight: [takeoff\n", "line 2: did not find expected"),
    (b"name: a\n\tseed: 1\n", "line 2"),
    (b"name: a\nseed: 1\nname: b\n", "line 3, column 1: the key 'name' stands here a second time"),
    (b"flight:\n- takeoff: {height: 1, height: 2}\n", "the key 'height' stands here a second time"),
    (b"name: !!python/object/apply:os.system ['true']\n", "could not determine a constructor"),
    (b"seed: " + b"9" * 5000, "a value that YAML cannot read"),
    (b"seed: 2020-13-45\n", "a value that YAML cannot read"),
    (b"[" * 100_000, "nested deeper than 64 levels"),
    (b"seed: &a [*a]\n", "column 11: the alias *a stands inside of what it stands for"),
    (b"drones: &a [*a]\n", "column 13: the alias *a"),
    (b"seed: 0x" + b"f" * 9000, "seed is a huge number"),
    (b"&a a: &b {*b : 1}\n", "bad.yaml"),
    (b"? [a, b]\n: 1\n", "bad.yaml"),
]


@pytest.mark.parametrize(("content", "says"), BAD_FILES, ids=lambda v: str(v)[:40])
def test_bad_file_is_refused_in_one_sentence(tmp_path, content, says):
    path = tmp_path / "bad.yaml"
    path.write_bytes(content)
    with pytest.raises(MissionError) as caught:
        load_mission(path)
    assert str(caught.value).startswith(str(path))
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 600


def test_missing_file_folder_and_impossible_name_are_refused(tmp_path):
    with pytest.raises(MissionError, match="cannot be read: No such file"):
        load_mission(tmp_path / "gone.yaml")
    with pytest.raises(MissionError, match="it is a folder, but must be a regular file"):
        load_mission(tmp_path)
    with pytest.raises(MissionError, match="is no file name"):
        load_mission("a\0b.yaml")


def test_huge_file_is_refused_before_it_is_parsed(tmp_path):
    path = tmp_path / "huge.yaml"
    path.write_bytes(b"#" * 4_000_001)
    with pytest.raises(MissionError, match="is larger than 4000000 bytes"):
        load_mission(path)


def test_aliases_that_multiply_are_refused_quickly(tmp_path):
    path = tmp_path / "bomb.yaml"
    levels = "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 12))
    path.write_text("a0: &a0 x\n" + levels + "drones: *a11\nflight: *a11\n")
    with pytest.raises(MissionError, match="line 7, column 30: more than 300000 keys and values"):
        load_mission(path)
    path.write_text(levels.replace("*a0", "x").replace("a11:", "drones:"))
    with pytest.raises(MissionError, match="more than 300000 keys and values"):
        load_mission(path)


def test_mission_without_a_name_is_called_after_its_file(tmp_path, hop):
    del hop["name"]
    path = tmp_path / "evening_show.yaml"
    path.write_text(yaml.safe_dump(hop))
    assert load_mission(path).name == "evening_show"


def test_scene_and_trajectory_are_found_beside_the_mission_file(tmp_path, hop):
    (tmp_path / "hall.xml").write_text("<mujoco/>")
    (tmp_path / "line.csv").write_text("duration,…\n2.0,0,0.5" + ",0" * 30 + "\n")
    hop["scene"] = "hall.xml"
    hop["flight"][1] = {"trajectory": {"file": "line.csv"}}
    path = tmp_path / "hop.yaml"
    path.write_text(yaml.safe_dump(hop))
    mission = load_mission(path)
    assert mission.scene == str(tmp_path / "hall.xml")
    assert mission.flight[1].trajectory.rows.shape == (1, 33)


# -- anything at all -----------------------------------------------------------------------------------------------

scalars = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.integers(min_value=10**400, max_value=10**5000)
    | st.floats()
    | st.text(max_size=20)
    | st.sampled_from(["arena", "grid", "cf1", "takeoff", "land", "pid", "cf2", "figure8.csv"])
)
KEYS = [
    *Mission.model_fields,
    *("takeoff", "land", "hover", "go_to", "route", "trajectory", "together", "height", "duration", "offset"),
    *("position", "points", "pieces", "x", "count", "layout", "id", "stagger"),
]
values = st.recursive(
    scalars,
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(KEYS) | st.text(max_size=8), inner, max_size=4)
    ),
    max_leaves=12,
)
places = st.sampled_from(
    [
        *([key] for key in Mission.model_fields),
        ["drones", 0],
        ["drones", 0, "position"],
        ["drones", 1, "id"],
        ["flight", 0],
        ["flight", 1],
        ["flight", 0, "takeoff"],
        ["flight", 0, "takeoff", "height"],
        ["flight", 0, "takeoff", "drones"],
        ["flight", 1, "hover", "duration"],
    ]
)


def accepted_or_refused(function, *arguments):
    """Return whether *function* accepts; a refusal must be a MissionError of one line."""
    try:
        function(*arguments)
    except MissionError as error:
        assert "\n" not in str(error)
        assert isinstance(error, CrazychoirError)
        return False
    return True


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(place=places, value=values)
def test_any_value_anywhere_is_accepted_or_refused_in_one_sentence(hop, place, value):
    accepted_or_refused(parse_mission, put(hop, place, value))


@settings(max_examples=100, deadline=None)
@given(data=values)
def test_anything_as_a_mission_is_refused_in_one_sentence(data):
    assert not accepted_or_refused(parse_mission, data)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    content=st.binary(max_size=200) | st.text(alphabet="[]{}:,-&*!|>'\"?#%@ \n\tab01.~=<", max_size=60).map(str.encode)
)
@example(b"=")
@example(b"? !!int\n")
@example(b"!!float x")
@example(b"!!timestamp x")
@example(b"!!bool x")
@example(b"1:b")
@example(b"<<: 1")
@example(b"a: {<<: [1]}")
@example(b"!!set [a]")
@example(b"!!omap {a: 1}")
@example(b"!!binary x")
def test_any_bytes_are_refused_in_one_sentence(tmp_path, content):
    path = tmp_path / "noise.yaml"
    path.write_bytes(content)
    assert not accepted_or_refused(load_mission, path)
