"""Every mission in examples/ flies, succeeds, and writes what it promises."""

import json
import re
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app

EXAMPLES = Path(__file__).parents[2] / "examples"
# those with layers, and what extends them, are flown beside this file
MISSIONS = [
    path for path in sorted(EXAMPLES.glob("*.yaml")) if not re.search("^(layers|extends):", path.read_text(), re.M)
]

# largest tracking error (m) that the stock PID may show on the path of the mission: half a second times its speed,
# and as much again where collision avoidance moves the setpoint about
LARGEST_ERROR = {"hello_swarm": 0.6, "figure8": 0.7, "swap_places": 0.9, "mixed_swarm": 0.8}
LARGEST_ERROR |= {"faults": 1.2, "gates": 1.1}
# and (m) of the end point and the estimate, where something else than motion capture tells the drones where they are
# or where a fault takes motion capture away; a drone that crashes lies near its start, because it falls from there
LARGEST_END_ERROR = {"mixed_swarm": 0.3, "faults": 0.3}
LARGEST_ESTIMATE_ERROR = {"mixed_swarm": 0.2, "faults": 0.25}


def fly(mission, out, *options):
    return CliRunner().invoke(app, ["fly", str(mission), "--no-video", "--out", str(out), *options])


@pytest.fixture(scope="module", params=MISSIONS, ids=lambda path: path.stem)
def flown(request, tmp_path_factory):
    """One mission with the folder that its flight wrote and what it printed."""
    out = tmp_path_factory.mktemp(request.param.stem)
    result = fly(request.param, out)
    assert result.exit_code == 0, result.output
    return request.param, out, result.output


def test_flight_succeeds_with_small_errors(flown):
    mission, out, _ = flown
    summary = json.loads((out / "summary.json").read_text())
    assert summary["success"]
    assert summary["failures"] == []
    assert summary["mission"] == mission.stem
    for drone in summary["drones"]:
        assert drone["max_error_m"] < LARGEST_ERROR[mission.stem]
        assert drone["endpoint_error_m"] < LARGEST_END_ERROR.get(mission.stem, 0.05)
        assert drone["estimator_rms_m"] < LARGEST_ESTIMATE_ERROR.get(mission.stem, 0.03)
        # docs/reference/vehicle.md#14.1: 59 % in theory, battery and integrators differ; none for those in newtons
        if not drone["id"].startswith(("lee", "brescianini")):
            assert 50 < drone["hover_thrust_percent"] < 70
        assert 3.3 < drone["battery_V"] < 4.2


def test_log_covers_the_flight_at_100_hz(flown):
    _, out, _ = flown
    with np.load(out / "log.npz", allow_pickle=False) as log:
        time = log["time"]
    np.testing.assert_allclose(np.diff(time), 0.01, atol=1e-6)
    assert time[-1] - time[0] > 10.0


def test_picture_shows_something(flown):
    _, out, _ = flown
    picture = matplotlib.image.imread(out / "flight.png")
    assert min(picture.shape[:2]) > 300
    assert picture[..., :3].std() > 0.01


def test_output_tells_how_it_went(flown):
    mission, out, output = flown
    assert "success" in output
    assert "crazychoir film" in output
    assert mission.stem in output
    assert not (out / "flight.mp4").exists()


def test_same_seed_gives_the_same_log_and_another_seed_does_not(tmp_path):
    logs = []
    for name, seed in (("a", "3"), ("b", "3"), ("c", "4")):
        assert fly(EXAMPLES / "figure8.yaml", tmp_path / name, "--seed", seed).exit_code == 0
        with np.load(tmp_path / name / "log.npz", allow_pickle=False) as log:
            logs.append({key: log[key] for key in log.files})
    numbers = [key for key, value in logs[0].items() if value.dtype.kind in "fiu"]
    assert len(numbers) > 20
    assert all(np.array_equal(logs[0][key], logs[1][key], equal_nan=True) for key in numbers)
    assert not all(np.array_equal(logs[0][key], logs[2][key], equal_nan=True) for key in numbers)


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
def test_both_platforms_fly_twice_in_one_mission(tmp_path, platform):
    mission = tmp_path / "twice.yaml"
    mission.write_text(
        f"defaults: {{platform: {platform}}}\n"
        "drones: {count: 2, layout: line}\n"
        "flight: [takeoff, hover: {duration: 2}, land, hover: {duration: 5}, takeoff, hover: {duration: 2}, land]\n"
    )
    result = fly(mission, tmp_path / "out")
    assert result.exit_code == 0, result.output


def test_flight_that_misses_its_target_exits_with_1_and_says_so(tmp_path):
    mission = tmp_path / "too_far.yaml"
    mission.write_text(
        "drones: {count: 1}\nflight: [takeoff, go_to: {offset: [30, 0, 0], duration: 2}]\n"  # no Crazyflie flies 15 m/s
    )
    result = fly(mission, tmp_path / "out")
    assert result.exit_code == 1
    assert "cf1: " in result.stderr
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert not summary["success"]
    assert summary["failures"]


def test_mission_with_a_program_of_the_user(tmp_path):
    result = fly(EXAMPLES / "motor_ctrl" / "mission.yaml", tmp_path)
    assert result.exit_code == 0, result.output
    assert json.loads((tmp_path / "summary.json").read_text())["success"]
