"""Options without effect, because another one is missing or present, are refused: none is silently ignored."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize("option", ["--restart", "--domain 3", "--processes one"])
@pytest.mark.parametrize("command", ["fly", "gui"])
def test_some_count_with_ros_only(command, option):
    result = CliRunner().invoke(app, [command, "mission.yaml", *option.split()])
    assert result.exit_code == 2
    assert f"{option.split()[0]}: counts with --ros only" in result.stderr


def test_a_pace_counts_with_ros_only():
    result = CliRunner().invoke(app, ["fly", "mission.yaml", "--pace", "1"])
    assert "--pace: counts with --ros only" in result.stderr


def test_a_page_that_joins_starts_nothing_again():
    result = CliRunner().invoke(app, ["gui", "mission.yaml", "--ros-join", "--restart"])
    assert "--restart: counts with --ros only" in result.stderr


def test_flights_over_ros_are_not_flown_again_on_save():
    result = CliRunner().invoke(app, ["fly", "mission.yaml", "--ros", "--watch"])
    assert result.exit_code == 2
    assert "--watch: does not go with --ros" in result.stderr


def test_places_of_real_drones_need_real_drones(tmp_path):
    mission = str(EXAMPLES / "bearing_formation.yaml")
    result = CliRunner().invoke(app, ["fly", mission, "--out", str(tmp_path), "--uri-base", "udp://127.0.0.1:1"])
    assert result.exit_code == 2
    assert "--uri-base is for real drones, but the backend is sim: add --backend hardware" in result.stderr
