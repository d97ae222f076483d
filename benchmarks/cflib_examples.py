"""Runs the examples that come with cflib, as they are, against `crazychoir serve`.

    pip download cflib==0.1.34 --no-binary :all: --no-deps
    python benchmarks/cflib_examples.py --sdist cflib-0.1.34.tar.gz

All fly at once, each a drone of its own; the table says how they ended and where the drones really were.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import signal
import subprocess
import sys
import tarfile
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from crazychoir_fw.recording.flight_log import FlightLog

EXAMPLES = (
    "autonomy/autonomous_sequence.py",  # the first, because it flies around the origin
    "autonomy/autonomous_sequence_high_level.py",
    "autonomy/motion_commander_demo.py",
    "logging/basiclog.py",
    "logging/basiclog_sync.py",
    "parameters/basicparam.py",
    "parameters/persistent_params.py",
    "step-by-step/sbs_connect_log_param.py",
    "step-by-step/sbs_motion_commander.py",
)
NEEDS_FLOW = {"step-by-step/sbs_motion_commander.py"}
SPACING = 6.0
LONGEST_S = 240.0


def drone_of(example: str) -> str:
    return Path(example).stem


def write_mission(folder: Path) -> Path:
    """Write a mission with a drone for each example."""
    drones: list[dict[str, Any]] = []
    for number, example in enumerate(EXAMPLES):
        drone = {"id": drone_of(example), "position": [SPACING * (number % 3), SPACING * (number // 3)]}
        drones.append({**drone, **({"positioning": "flow"} if example in NEEDS_FLOW else {})})
    mission = {"name": "examples", "drones": drones, "flight": [{"hover": {"duration": 1.0}}]}
    path = folder / "examples.yaml"
    path.write_text(yaml.safe_dump(mission))
    return path


def unpack(sdist: Path, folder: Path) -> Path:
    """Unpack a source distribution. Returns its folder of examples."""
    with tarfile.open(sdist) as archive:
        archive.extractall(folder, filter="data")
    (examples,) = folder.glob("*/examples")
    return examples


def run(sdist: Path, shown: bool) -> list[dict[str, Any]]:
    """Run all. Returns a row for each."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        examples = unpack(sdist, folder)
        crazychoir = [sys.executable, "-c", "from crazychoir_fw.cli import app; app()"]
        words = [*crazychoir, "serve", str(write_mission(folder)), "--port", "0", "--out", str(folder / "out")]
        environment = {**os.environ, "COLUMNS": "120"}
        with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=environment) as server:
            text = ""
            for line in server.stdout:
                text += line
                if line.startswith("Serving"):
                    break
            uris = dict(re.findall(r"(\w+) +(udp://[\d.:]+)", text))
            rows = run_all(examples, folder, uris, shown)
            server.send_signal(signal.SIGINT)
            print(server.communicate()[0])
        log = FlightLog.load(folder / "out" / "log.npz")
    for row in rows:
        path = log.stack("sim.x", "sim.y", "sim.z")[:, log.drone_ids.index(drone_of(row["example"]))]
        moved = path - path[0]
        row["highest_m"] = float(path[:, 2].max())
        row["farthest_m"] = float(np.linalg.norm(moved[:, :2], axis=1).max())
        row["end_m"] = [round(float(value), 3) for value in moved[-1]]
    return rows


def run_all(examples: Path, folder: Path, uris: dict[str, str], shown: bool) -> list[dict[str, Any]]:
    running = []
    for example in EXAMPLES:
        home = folder / drone_of(example)
        home.mkdir()
        environment = {**os.environ, "CFLIB_URI": uris[drone_of(example)]}
        with (home / "output").open("w") as output:
            process = subprocess.Popen(
                [sys.executable, examples / example], cwd=home, env=environment, stdout=output, stderr=output
            )
        running.append((example, process, time.perf_counter()))
    rows: dict[str, dict[str, Any]] = {}
    while len(rows) < len(running):
        for example, process, began in running:
            seconds = time.perf_counter() - began
            if example in rows:
                continue
            if seconds > LONGEST_S:
                process.kill()
                process.wait()
            if process.poll() is not None:
                said = (folder / drone_of(example) / "output").read_text()
                rows[example] = {
                    "example": example,
                    "exit_code": process.returncode,
                    "seconds": seconds,
                    "traceback": "Traceback" in said,
                }
                if shown or process.returncode or "Traceback" in said:
                    print(f"---- {example}\n{said[-2000:]}")
        time.sleep(0.05)
    return [rows[example] for example in EXAMPLES]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sdist", type=Path, required=True, help="source distribution of cflib (.tar.gz)")
    parser.add_argument("--output", action="store_true", help="show what the examples print")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    rows = run(options.sdist, options.output)
    print(f"{'example':46} {'exit':>4} {'s':>6} {'highest (m)':>12} {'farthest (m)':>13}  end from start (m)")
    for row in rows:
        end = ", ".join(f"{value:.2f}" for value in row["end_m"])
        figures = f"{row['seconds']:6.1f} {row['highest_m']:12.2f} {row['farthest_m']:13.2f}"
        print(f"{row['example']:46} {row['exit_code']:4} {figures}  {end}")
    if options.json:
        options.json.write_text(json.dumps(rows, indent=2) + "\n")
    if any(row["exit_code"] for row in rows):
        sys.exit(1)


if __name__ == "__main__":
    main()
