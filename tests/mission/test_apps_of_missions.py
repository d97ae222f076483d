"""The key `app`: files beside the mission, for all drones or for one, and what follows from it."""

import pytest

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.mission import load_mission, parse_mission


@pytest.fixture
def folder(tmp_path):
    for name in ("mine.c", "other.c"):
        (tmp_path / name).write_text("")
    return tmp_path


def test_files_are_seen_from_the_mission(hop, folder):
    hop["drones"][0]["app"] = "mine.c"
    hop["drones"][1]["app"] = ["mine.c", "other.c"]
    first, second = parse_mission(hop, folder=folder).fleet
    assert first.app == (str(folder / "mine.c"),)
    assert second.app == (str(folder / "mine.c"), str(folder / "other.c"))
    assert first.controller is None and first.provider == "builtin"


def test_app_of_all_may_be_left_out_by_one(hop, folder):
    hop["defaults"] = {"app": "mine.c"}
    hop["drones"][1]["app"] = []
    first, second = parse_mission(hop, folder=folder).fleet
    assert first.app and not second.app


def test_app_of_the_command_line_is_for_all_and_seen_from_where_it_runs(hop, folder, monkeypatch):
    monkeypatch.chdir(folder)
    hop["drones"][0]["app"] = "other.c"
    fleet = parse_mission(hop, folder=folder, app=["mine.c"]).fleet
    assert [drone.app for drone in fleet] == [("mine.c",)] * 2


@pytest.mark.parametrize(
    "app", ["gone.c", "mine.h", "", ".", 3, ["mine.c", 3], {"file": "mine.c"}, "a\0.c", "x" * 5000]
)
def test_what_is_no_c_file_is_refused(hop, folder, app):
    hop["drones"][1]["app"] = app
    with pytest.raises(MissionError, match=r"^mission: drones\[1\]\.app is .*, but must be a C file such as"):
        parse_mission(hop, folder=folder)


@pytest.mark.parametrize("key", ["controller", "estimator"])
def test_out_of_tree_needs_an_app(hop, folder, key):
    hop["drones"][1][key] = "out_of_tree"
    with pytest.raises(MissionError, match=f"cf2 has {key} 'out_of_tree', but no app: name .* app: my_{key}.c"):
        parse_mission(hop, folder=folder)
    hop["drones"][1]["app"] = "mine.c"
    assert getattr(parse_mission(hop, folder=folder).fleet[1], key) == "out_of_tree"


def test_parameters_that_an_app_may_bring_are_left_to_the_flight(hop, folder):
    hop["drones"][0]["parameters"] = {"mine.gain": 2.0}
    with pytest.raises(MissionError, match="drones.0..parameters"):
        parse_mission(hop, folder=folder)
    hop["drones"][0]["app"] = "mine.c"
    assert parse_mission(hop, folder=folder).fleet[0].parameters == {"mine.gain": 2.0}


def test_file_of_a_mission_finds_its_app(folder):
    path = folder / "hop.yaml"
    path.write_text("defaults: {app: mine.c}\ndrones: {count: 2}\nflight: [takeoff, land]\n")
    assert [drone.app for drone in load_mission(path).fleet] == [(str(folder / "mine.c"),)] * 2
