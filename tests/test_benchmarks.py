"""Benchmarks run, on the smallest of workloads; what they measure is not looked at."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
SMALLEST = {
    "flight_matrix.py": ["--platforms", "cf2", "--controllers", "pid", "--positioning", "mocap"],
    "plant_cost.py": ["--drones", "2", "--repeats", "1", "--ticks", "5"],
    "provider_cost.py": ["--drones", "1", "--repeats", "1"],
    "swarm_scale.py": ["--drones", "1", "2", "--threads", "1", "--seconds", "0.02", "--repeats", "1"],
    "tick_cost.py": ["--drones", "1", "--repeats", "1"],
    "vehicle_validation.py": [],
}


def test_every_benchmark_is_tried():
    assert {path.name for path in BENCHMARKS.glob("*.py")} == set(SMALLEST)


@pytest.mark.parametrize("name", SMALLEST)
def test_benchmark_runs(name, tmp_path, monkeypatch, lasting_cache, miniature):
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(miniature))
    result = tmp_path / "result.json"
    command = [sys.executable, BENCHMARKS / name, *SMALLEST[name], "--json", result]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    assert json.loads(result.read_text())
