"""Every mission with layers in examples/ flies and meets its criteria; long ones are cut short."""

import json
import shutil
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.mission.documents import chain_of, together
from crazychoir_fw.simulation.replay import replay

EXAMPLES = Path(__file__).parents[2] / "examples"
MISSIONS = [path for path in sorted(EXAMPLES.glob("*.yaml")) if "\nlayers:" in path.read_text()]

# seconds of `start` here, and criteria that a shorter flight cannot meet
SHORTER = {
    "aggregative": (8.0, {"surveillance_error_m": 0.15, "position_error_m": 0.1}),
    "aggregative_lighthouse": (8.0, {"surveillance_error_m": 0.2, "position_error_m": 0.2}),
    "aggregative_moving_intruders": (18.0, {"surveillance_rms_m": 0.3}),
    "containment": (14.0, {"position_error_m": 0.3}),
    "containment_time_varying": (14.0, {"position_error_m": 0.3}),
    "distance_formation": (10.0, {}),
    "mpc": (8.0, {"position_error_m": 3.0}),
    "bearing_formation": (25.0, {}),
    "formation_rviz": (40.0, {}),
    "grid_30": (8.0, {"bearing_error_deg": 6.0}),
    "letter_s": (16.0, {"bearing_error_deg": 3.0, "position_error_m": 0.5}),
}
GOALS = [8.0, 10.0]  # seconds of the two long legs of goto
SWAPS = {"collision": (3.0, 12.0, 30.0), "collision_vel": (3.0, 12.0, 34.0), "swap_ten": (3.0, 8.0, 26.0)}
"""Seconds of take-off, swap and all of `start`."""


def whole(path):
    """Return what a mission and those that it extends say."""
    data = yaml.safe_load(path.read_text())
    name = data.get("name", path.stem)
    return {**together(chain_of(data, str(path), path.parent)), "name": name}


def shortened(path, folder):
    data = whole(path)
    seconds, criteria = SHORTER.get(path.stem, (None, {}))
    for phase in data["flight"]:
        if "start" in phase and seconds is not None:
            phase["start"]["duration"] = seconds
    if path.stem == "goto":
        for goals in data["layers"]["guidance"]["goals"].values():
            for goal, duration in zip(goals[1:], GOALS, strict=True):
                goal[0] = duration
        data["flight"][0]["start"]["duration"] = 5.0 + sum(GOALS) + 3.0
        criteria = {"tracking_rms_m": 0.3}
    if path.stem == "aggregative_moving_intruders":
        for goals in data["layers"]["guidance"][1]["goals"].values():
            for goal in goals:
                goal[0] = 6.0
    if path.stem in SWAPS:
        *durations, seconds = SWAPS[path.stem]
        for goals in data["layers"]["guidance"]["goals"].values():
            for goal, duration in zip(goals, durations, strict=True):
                goal[0] = duration
        data["flight"][0]["start"]["duration"] = seconds
        data["layers"]["rate"] = 50
    data["criteria"] |= criteria
    data["log_rate"] = 25
    for file in EXAMPLES.glob("*.csv"):
        shutil.copy(file, folder)
    (folder / path.name).write_text(yaml.safe_dump(data))
    return folder / path.name


def fly(mission, out, *options):
    return CliRunner().invoke(app, ["fly", str(mission), "--no-video", "--out", str(out), *options])


@pytest.fixture(scope="module", params=MISSIONS, ids=lambda path: path.stem)
def flown(request, tmp_path_factory):
    """One mission, the folder that its flight wrote, and what it printed."""
    folder = tmp_path_factory.mktemp(request.param.stem)
    result = fly(shortened(request.param, folder), folder / "out")
    assert result.exit_code == 0, result.output
    return request.param.stem, folder / "out", result.output


def test_criteria_are_met(flown):
    name, out, output = flown
    summary = json.loads((out / "summary.json").read_text())
    assert summary["mission"] == name
    assert summary["success"]
    assert summary["criteria"]
    assert all(entry["passed"] for entry in summary["criteria"])
    assert summary["collisions"] == [] or all(hit["what"] == "floor" for hit in summary["collisions"])
    assert "passed" in output
    assert "success" in output


def test_picture_shows_something(flown):
    _, out, _ = flown
    picture = matplotlib.image.imread(out / "flight.png")
    assert min(picture.shape[:2]) > 300
    assert picture[..., :3].std() > 0.01


def test_a_replay_proves_what_was_simulated(flown):
    name, out, _ = flown
    if name not in ("tracking", "bearing_formation"):
        pytest.skip("one with leaders and one without are enough")
    assert replay(out).deviation is None


def test_formation_is_the_same_on_both_backends(tmp_path):
    places = {}
    mission = shortened(EXAMPLES / "bearing_formation.yaml", tmp_path)
    for backend in ("sim", "integrator"):
        assert fly(mission, tmp_path / backend, "--backend", backend).exit_code == 0
        with np.load(tmp_path / backend / "log.npz", allow_pickle=False) as log:
            windows = json.loads(str(log["metadata"]))["windows"]
            last = np.searchsorted(log["time"], windows[1][2]) - 1
            places[backend] = np.stack([log[f"signal/sim.{axis}"][last] for axis in "xyz"], axis=-1)
    np.testing.assert_allclose(places["sim"], places["integrator"], atol=0.05)


def test_a_criterion_that_is_not_met_is_exit_code_1(tmp_path):
    mission = shortened(EXAMPLES / "formation_rviz.yaml", tmp_path)
    data = yaml.safe_load(mission.read_text())
    data["flight"][0]["start"]["duration"] = 2.0
    mission.write_text(yaml.safe_dump(data))
    result = fly(mission, tmp_path / "out")
    assert result.exit_code == 1
    assert "the mean bearing error is" in result.stderr
    assert not json.loads((tmp_path / "out" / "summary.json").read_text())["success"]


def test_hardware_without_uris_is_refused_in_one_sentence(tmp_path):
    result = fly(EXAMPLES / "bearing_formation.yaml", tmp_path, "--backend", "hardware")
    assert result.exit_code == 2
    assert "drones[0].uri is missing" in result.stderr
    assert "--uri-base" in result.stderr
