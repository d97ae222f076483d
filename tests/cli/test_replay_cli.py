"""`crazychoir replay` and `crazychoir export`, with their exit codes, in processes of their own."""

import json
import subprocess
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.recording.flight_log import FlightLog

MISSION = """
name: short
seed: 5
drones: {count: 4, spacing: 0.4}
flight:
- takeoff: {height: 0.4, duration: 0.8}
- land: {duration: 0.8}
"""


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    """The folder of a flown mission."""
    folder = tmp_path_factory.mktemp("replay")
    (folder / "short.yaml").write_text(MISSION)
    result = run("fly", folder / "short.yaml", "--no-video", "--mcap", "--out", folder / "out")
    assert result.exit_code == 0, result.output
    return folder / "out"


def test_a_mission_is_replayed_by_another_process_with_other_threads(flight):
    command = [
        sys.executable,
        "-c",
        "from crazychoir_fw.cli import app; app()",
        "replay",
        str(flight),
        "--check",
        "--threads",
        "2",
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("Same to the last bit: ")
    assert "signals of 4 drones" in done.stdout
    assert not (flight / "replay.npz").exists()


def test_without_check_the_new_log_is_kept(flight, tmp_path):
    result = run("replay", flight / "log.npz", "--out", tmp_path / "again.npz")
    assert result.exit_code == 0
    assert run("replay", tmp_path / "again.npz", "--check").exit_code == 0


def test_a_flight_that_differs_exits_with_1_and_names_where(flight, tmp_path):
    log = FlightLog.load(flight / "log.npz")
    log.signals["stateEstimate.x"].view(np.uint32)[20, 2] ^= 1
    log.metadata["version"] = "0.0.1"
    log.save(tmp_path / "log.npz")
    result = run("replay", tmp_path, "--check")
    assert result.exit_code == 1
    assert f"The replay differs: at tick {round(log.time[20] * 1000)} cf3 stateEstimate.x differ" in result.stderr
    assert "Note: recorded with version 0.0.1, this is " in result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize("spoil", ["gone", "text", "no journal"])
def test_what_cannot_be_replayed_exits_with_2(flight, tmp_path, spoil):
    if spoil == "text":
        (tmp_path / "log.npz").write_text("no log")
    if spoil == "no journal":
        log = FlightLog.load(flight / "log.npz")
        log.journal = None
        log.save(tmp_path / "log.npz")
    result = run("replay", tmp_path, "--check")
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert "Traceback" not in result.stderr


def test_fly_and_export_write_the_same_mcap_file(flight, tmp_path):
    result = run("export", flight, "--mcap", tmp_path / "flight.mcap")
    assert result.exit_code == 0, result.output
    assert (tmp_path / "flight.mcap").read_bytes() == (flight / "log.mcap").read_bytes()


def test_export_without_a_log_exits_with_2(tmp_path):
    result = run("export", tmp_path, "--mcap", tmp_path / "flight.mcap")
    assert result.exit_code == 2
    assert "log.npz cannot be read" in result.stderr
    assert not (tmp_path / "flight.mcap").exists()


def test_the_summary_is_what_it_was(flight):
    assert json.loads((flight / "summary.json").read_text())["success"]
