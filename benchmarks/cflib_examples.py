"""Runs all examples that come with cflib against `crazychoir serve`.

    python benchmarks/cflib_examples.py

All fly at once, each a drone of its own; the table says how they ended and where the drones really were, and which
were left out, and why. They run as they are; what users must replace in a source, the addresses of a swarm and the
path of a geometry, is replaced in a copy.
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
from importlib.metadata import files
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from cflib.crazyflie.mem import LighthouseBsGeometry
from cflib.localization import LighthouseConfigFileManager

from crazychoir_fw.recording.flight_log import FlightLog

FIRST = "autonomy/autonomous_sequence.py"  # it flies around the origin
NEEDS_FLOW = {"step-by-step/sbs_motion_commander.py"}
SWARMS = {"step-by-step/sbs_swarm.py": [(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)]}
"""Examples whose source holds the addresses of several drones, and where these stand (m)."""
LEFT_OUT = {
    "lighthouse/multi_bs_geometry_estimation.py": "a person carries a drone with a lighthouse deck through the room",
}
GEOMETRY = "/path/to/your/geo.yaml"
"""A file of the user's that an example reads: here one base station."""
SPACING = 6.0
LONGEST_S = 240.0


def drones_of(example: str) -> list[str]:
    """Return the ids of the drones that an example flies."""
    stem = Path(example).stem
    return [f"{stem}_{k}" for k in range(len(SWARMS[example]))] if example in SWARMS else [stem]


def found(folder: Path) -> list[str]:
    """Return the examples of a folder but those that are left out."""
    names = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*.py"))
    return sorted((name for name in names if name not in LEFT_OUT), key=lambda name: name != FIRST)


def write_mission(folder: Path, examples: list[str]) -> Path:
    """Write a mission with drones for each example."""
    drones: list[dict[str, Any]] = []
    for number, example in enumerate(examples):
        for name, (x, y) in zip(drones_of(example), SWARMS.get(example, [(0.0, 0.0)]), strict=True):
            drone = {"id": name, "position": [SPACING * (number % 3) + x, SPACING * (number // 3) + y]}
            drones.append({**drone, **({"positioning": "flow"} if example in NEEDS_FLOW else {})})
    mission = {"name": "examples", "drones": drones, "flight": [{"hover": {"duration": 1.0}}]}
    path = folder / "examples.yaml"
    path.write_text(yaml.safe_dump(mission))
    return path


def installed() -> Path:
    """Return the folder of examples that the installed cflib brings."""
    (example,) = [path for path in files("cflib") or [] if path.as_posix().endswith(FIRST)]
    return Path(str(example.locate())).parents[1]


def unpack(sdist: Path, folder: Path) -> Path:
    """Unpack a source distribution. Returns its folder of examples."""
    with tarfile.open(sdist) as archive:
        archive.extractall(folder, filter="data")
    (examples,) = folder.glob("*/examples")
    return examples


def run(sdist: Path | None, shown: bool) -> list[dict[str, Any]]:
    """Run all. Returns a row for each drone of each example."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        examples = unpack(sdist, folder) if sdist else installed()
        chosen = found(examples)
        crazychoir = [sys.executable, "-c", "from crazychoir_fw.cli import app; app()"]
        words = [*crazychoir, "serve", str(write_mission(folder, chosen)), "--port", "0", "--out", str(folder / "out")]
        environment = {**os.environ, "COLUMNS": "120"}
        with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=environment) as server:
            text = ""
            for line in server.stdout:
                text += line
                if line.startswith("Serving"):
                    break
            uris = dict(re.findall(r"(\w+) +(udp://[\d.:]+)", text))
            rows = run_all(examples, chosen, folder, uris, shown)
            server.send_signal(signal.SIGINT)
            print(server.communicate()[0])
        log = FlightLog.load(folder / "out" / "log.npz")
    return [{**row, **_flown(log, drone)} for row in rows for drone in drones_of(row["example"])]


def _flown(log: FlightLog, drone: str) -> dict[str, Any]:
    """Return where a drone of the simulation really was."""
    path = log.stack("sim.x", "sim.y", "sim.z")[:, log.drone_ids.index(drone)]
    moved = path - path[0]
    return {
        "drone": drone,
        "highest_m": float(path[:, 2].max()),
        "farthest_m": float(np.linalg.norm(moved[:, :2], axis=1).max()),
        "end_m": [round(float(value), 3) for value in moved[-1]],
    }


def _script(example: Path, home: Path, uris: list[str]) -> Path:
    """Return the script to run: the example, or a copy with the addresses of a swarm and the path of a geometry."""
    text, left = example.read_text(), iter(uris)
    if GEOMETRY in text:
        geometry = LighthouseBsGeometry()
        geometry.valid = True
        LighthouseConfigFileManager.write(str(home / "geo.yaml"), geos={0: geometry})
    elif len(uris) == 1:
        return example
    text = re.sub(r"radio://\w+(/\w+)*", lambda _: next(left), text)
    copy = home / example.name
    copy.write_text(text.replace(GEOMETRY, str(home / "geo.yaml")))
    return copy


def run_all(examples: Path, chosen: list[str], folder: Path, uris: dict[str, str], shown: bool) -> list[dict[str, Any]]:
    running = []
    for example in chosen:
        home = folder / Path(example).stem
        home.mkdir()
        own = [uris[drone] for drone in drones_of(example)]
        environment = {**os.environ, "CFLIB_URI": own[0]}
        with (home / "output").open("w") as output:
            process = subprocess.Popen(
                [sys.executable, _script(examples / example, home, own)],
                cwd=home,
                env=environment,
                stdout=output,
                stderr=output,
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
                said = (folder / Path(example).stem / "output").read_text()
                rows[example] = {
                    "example": example,
                    "exit_code": process.returncode,
                    "seconds": seconds,
                    "traceback": "Traceback" in said,
                }
                if shown or process.returncode or "Traceback" in said:
                    print(f"---- {example}\n{said[-2000:]}")
        time.sleep(0.05)
    return [rows[example] for example in chosen]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sdist", type=Path, help="source distribution of cflib (.tar.gz); else those installed")
    parser.add_argument("--output", action="store_true", help="show what the examples print")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    rows = run(options.sdist, options.output)
    print(f"{'example, drone':46} {'exit':>4} {'s':>6} {'highest (m)':>12} {'farthest (m)':>13}  end from start (m)")
    for row in rows:
        end = ", ".join(f"{value:.2f}" for value in row["end_m"])
        figures = f"{row['seconds']:6.1f} {row['highest_m']:12.2f} {row['farthest_m']:13.2f}"
        print(f"{Path(row['example']).with_name(row['drone']).as_posix():46} {row['exit_code']:4} {figures}  {end}")
    for example, why in LEFT_OUT.items():
        print(f"{example}: left out, {why}")
    if options.json:
        options.json.write_text(json.dumps(rows, indent=2) + "\n")
    if any(row["exit_code"] or row["traceback"] for row in rows):
        sys.exit(1)


if __name__ == "__main__":
    main()
