"""The scripts over recorded flights: what they write, and what they say of folders without flights."""

import json
import subprocess
import sys
from pathlib import Path

from crazychoir_fw.onboard import vehicles

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


def run(name, *arguments):
    return subprocess.run([sys.executable, BENCHMARKS / name, *arguments], capture_output=True, text=True, timeout=120)


def test_table_json_and_plots(synthetic_path, tmp_path):
    result = run(
        "real_flights.py", "--data", synthetic_path.parent, "--json", tmp_path / "a.json", "--plots", tmp_path / "plots"
    )
    assert result.returncode == 0, result.stderr
    (row,) = json.loads((tmp_path / "a.json").read_text())["flights"]
    assert row["name"] == "synthetic"
    assert row["problems"] == []
    assert {"path_rms_m", "lag_s", "tracking_percent", "plant_position_cm"} <= set(row)
    assert (tmp_path / "plots" / "synthetic.png").stat().st_size > 10_000


def test_flight_that_is_none_does_not_stop_the_others(tmp_path):
    (tmp_path / "bad.csv").write_text("t,px\n0,1\n")
    result = run("real_flights.py", "--data", tmp_path, "--json", tmp_path / "a.json")
    assert result.returncode == 0, result.stderr
    (row,) = json.loads((tmp_path / "a.json").read_text())["flights"]
    assert "are missing" in row["problems"][0]


def test_empty_folder_is_one_sentence(tmp_path):
    result = run("real_flights.py", "--data", tmp_path)
    assert result.returncode == 1
    assert result.stderr.startswith("no flights")
    assert "Traceback" not in result.stderr


def test_identified_vehicle_can_be_flown(synthetic_path, tmp_path):
    out = tmp_path / "vehicle.yaml"
    options = ("--data", synthetic_path.parent, "--time-constants", "0.07", "--no-refining", "--out", out)
    result = run("identify_vehicle.py", *options)
    assert result.returncode == 0, result.stderr
    assert vehicles.overrides(out)["mass"] == 0.04085
