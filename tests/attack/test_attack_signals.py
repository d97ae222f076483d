"""Signals at random moments of every command: an orderly end, and nothing left behind.

`ATTACK_SIGNALS=20` sends every signal at so many moments of each command.
"""

import os
import random
import signal
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from sessions import of_session

from crazychoir_fw.simulation import DroneConfig, World
from crazychoir_fw.simulation.recorder import FlightRecorder

SCRIPT = "import sys\nfrom crazychoir_fw.cli import app\nif __name__ == '__main__':\n    sys.exit(app())\n"
COUNT = int(os.environ.get("ATTACK_SIGNALS", "0"))
SEED = int(os.environ.get("ATTACK_SEED", "1"))
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
LONGEST_END = 40.0
"""Until a command must be gone (s); a busy machine takes its time."""
LAYERED = """
drones: [{id: agent_0, position: [0, 0]}, {id: agent_1, position: [1, 0]}]
flight: [{takeoff: {duration: 3}}, {start: {duration: 20}}, {land: {duration: 3}}]
layers: {guidance: {class: SimpleGuidance}, planning: {class: Spline}, control: {gains: mujoco}}
"""
PLAIN = """
drones: {count: 20}
flight: [{takeoff: {}}, {hover: {duration: 60}}, {land: {}}]
"""
SHORT = """
drones: {count: 2}
flight: [{takeoff: {}}, {hover: {duration: 2}}, {land: {}}]
"""
COMMANDS = {
    "fly": ["fly", "plain.yaml", "--no-video", "--out", "out"],
    "fly layers": ["fly", "layered.yaml", "--no-video", "--out", "out"],
    "fly integrator": ["fly", "layered.yaml", "--backend", "integrator", "--no-video", "--out", "out"],
    "fly --ros": ["fly", "layered.yaml", "--ros", "--no-video", "--out", "out"],
    "serve": ["serve", "--count", "2", "--port", "0", "--out", "out"],
    "gui": ["gui", "layered.yaml", "--port", "0", "--no-browser"],
    "run": ["run", "drones.xml", "--seconds", "300"],
    "replay": ["replay", "log.npz", "--out", "again.npz"],
    "gui --ros": ["gui", "layered.yaml", "--ros", "--port", "0", "--no-browser"],
    "campaign": ["campaign", "short.yaml", "--flights", "500", "--out", "campaign"],
    "film": ["film", "log.npz", "--out", "film.mp4"],
    "export": ["export", "log.npz", "--mcap", "log.mcap"],
    "info": ["info"],
    "vehicle": ["vehicle"],
    "variables": ["variables"],
}
IN_THE_GATE = ("fly", "serve", "campaign")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with what the commands read."""
    path = tmp_path_factory.mktemp("signals")
    (path / "crazychoir").write_text(SCRIPT)  # as pip makes it
    (path / "plain.yaml").write_text(PLAIN)
    (path / "layered.yaml").write_text(LAYERED)
    (path / "short.yaml").write_text(SHORT)
    examples = Path(__file__).resolve().parents[2] / "examples" / "motor_ctrl"
    for name in ("drones.xml", "bounce.py"):
        (path / name).write_text((examples / name).read_text())
    if COUNT:
        world = World([DroneConfig(f"cf{i}", (float(i), 0.0)) for i in range(5)], visuals=False)
        recorder = FlightRecorder(world)
        for _ in range(1000):
            world.step(100)
            recorder.sample()
        recorder.finish().save(path / "log.npz")
    return path


def end(folder, command, number, delay):
    """Start a command, send it a signal after a time, and return what is wrong about its end."""
    with (folder / "said.txt").open("wb") as said:
        process = subprocess.Popen(
            [sys.executable, "crazychoir", *COMMANDS[command]],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(map(os.path.abspath, sys.path))},
            stdout=said,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            start_new_session=True,
        )
    try:
        time.sleep(delay)
        process.send_signal(number)
        process.wait(LONGEST_END)
        deadline = time.monotonic() + 5.0
        while (orphans := of_session(process.pid)) and time.monotonic() < deadline:
            time.sleep(0.1)
    except subprocess.TimeoutExpired:
        return "it goes on"
    finally:
        for entry in of_session(process.pid):
            os.kill(entry, signal.SIGKILL)
        process.wait()
    text = (folder / "said.txt").read_text(errors="replace")
    if "Usage:" in text:
        return text
    if orphans:
        return f"it left {orphans}"
    # in its first tenths of a second, before our code runs, Python itself answers Ctrl-C
    is_early = number == signal.SIGINT and "crazychoir_fw" not in text
    if "Traceback" in text and not is_early:
        return text[-1500:]
    left = [path.name for path in (*folder.glob(".*.npz"), *(folder / "out").glob(".*"))]
    for path in (*folder.glob(".*.npz"), *(folder / "out").glob(".*")):
        path.unlink()
    if left:
        return f"it left files: {left}"
    for log in folder.glob("out/*.npz"):
        with np.load(log, allow_pickle=False) as file:
            assert file.files
    return None


def cases():
    for command in COMMANDS if COUNT else IN_THE_GATE:
        marks = [pytest.mark.skipif(find_spec("rclpy") is None, reason="no rclpy")] if "ros" in command else []
        for number in SIGNALS if COUNT else (signal.SIGTERM,):
            yield pytest.param(command, number, marks=marks, id=f"{command}-{number.name}")


@pytest.mark.timeout(120 + 60 * COUNT)
@pytest.mark.parametrize(("command", "number"), list(cases()))
def test_a_signal_ends_a_command_in_order(folder, command, number):
    dice = random.Random(f"{SEED} {command} {number}")
    for _ in range(COUNT or 1):
        delay = dice.uniform(0.05, 6.0) if COUNT else 2.0
        wrong = end(folder, command, number, delay)
        assert wrong is None, f"{command}, {number.name} after {delay:.2f} s: {wrong}"
