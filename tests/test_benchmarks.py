"""Benchmarks run, on the smallest of workloads; what they measure is not looked at."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
SMALLEST = {
    "campaign_speed.py": ["--flights", "2", "--workers", "1"],
    "endurance.py": ["--hours", "0.02"],
    "estimator_consistency.py": ["--systems", "mocap", "--seeds", "2", "--nis-seeds", "1"],
    "flight_matrix.py": ["--platforms", "cf2", "--controllers", "pid", "--positioning", "mocap"],
    "control_gains.py": ["--sets", "mujoco", "--flights", "hover"],
    # every seed throws the same, and whatever must hold is looked at: exceptions, replies, memory, the other client
    "fuzz_server.py": ["--datagrams", "30000", "--flood", "10000", "--seed", "3"],
    "learning_speed.py": ["--flights", "2", "--threads", "1"],
    "layers_in_process.py": ["--seconds", "0.1", "--threads", "1"],
    "log_cost.py": ["--drones", "1", "--seconds", "0.05", "--repeats", "1"],
    "looking_cost.py": ["--drones", "1", "--repeats", "1"],
    "missions.py": ["hello_swarm", "--no-film"],
    "motor_ctrl_cost.py": ["--drones", "1", "--seconds", "0.02", "--repeats", "1"],
    "page_cost.py": ["--drones", "2", "--seconds", "0.3", "--repeats", "1", "--chromium", "none"],
    "plant_cost.py": ["--drones", "2", "--repeats", "1", "--ticks", "5"],
    "provider_cost.py": ["--drones", "1", "--repeats", "1"],
    "responses.py": ["--controllers", "pid", "--frequencies", "3"],
    "communicators.py": ["--agents", "4", "--ros-agents", "2", "--rounds", "5"],
    "ros_swarm.py": ["--drones", "2", "--processes", "one", "--backend", "integrator", "--seconds", "0.2"],
    "serve_swarm.py": ["--drones", "2", "--seconds", "0.5", "--repeats", "1"],
    "swarm_scale.py": [
        *("--drones", "1", "2", "--threads", "1", "--seconds", "0.02", "--repeats", "1"),
        *("--pile", "3", "2", "--start", "2"),
    ],
    "threads_under_load.py": ["--drones", "8", "--load", "0", "1", "--work", "0.1", "--pairs", "1"],
    "tick_cost.py": ["--drones", "1", "--repeats", "1"],
    "time_machine.py": ["--drones", "1", "--repeats", "1", "--futures", "2", "--seconds", "0.02"],
}
NEEDS_MORE = {
    "cflib_examples.py",  # a minute
    "endurance_served.py",  # minutes
    "profile_step.py",  # valgrind
}
TRIED_ELSEWHERE = {
    "innovations.py",  # what estimator_consistency.py adds up
    *("identify_vehicle.py", "real_flights.py"),  # tests/recorded/test_real_flights_script.py
    *("step_responses.py", "vehicle_validation.py"),  # tests/onboard/vehicles/test_validation_table.py
}


def test_every_benchmark_is_tried():
    assert {path.name for path in BENCHMARKS.glob("*.py")} == set(SMALLEST) | TRIED_ELSEWHERE | NEEDS_MORE


@pytest.mark.parametrize("name", SMALLEST)
def test_benchmark_runs(name, tmp_path, monkeypatch, lasting_cache, miniature):
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(miniature))
    result = tmp_path / "result.json"
    command = [sys.executable, BENCHMARKS / name, *SMALLEST[name], "--json", result]
    ended = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=120)
    assert ended.returncode == 0, ended.stdout
    assert json.loads(result.read_text())
