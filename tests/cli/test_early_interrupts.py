"""Ctrl-C in the first seconds of a command: a clean end, no traceback, nothing left behind."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from sessions import of_session

SCRIPT = "import sys\nfrom crazychoir_fw.cli import app\nif __name__ == '__main__':\n    sys.exit(app())\n"
MISSION = """
drones: [{id: agent_0, position: [0, 0]}]
flight: [{takeoff: {duration: 3}}, {hover: {duration: 3000}}, {land: {duration: 3}}]
layers: {guidance: {class: SimpleGuidance}, planning: {class: Spline}, control: {gains: mujoco}}
"""
COMMANDS = {
    "fly": ["fly", "mission.yaml", "--no-video", "--out", "out"],
    "serve": ["serve", "--count", "1", "--port", "0", "--out", "out"],
    "gui": ["gui", "mission.yaml", "--port", "0", "--no-browser"],
    "campaign": ["campaign", "mission.yaml", "--flights", "2000", "--out", "campaign"],
}
MOMENTS = (0.0, 0.1, 0.3, 0.7, 1.5)
"""After Python itself has started (s)."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("early")
    (path / "crazychoir").write_text(SCRIPT)  # as pip makes it
    (path / "mission.yaml").write_text(MISSION)
    return path


def handles_interrupts(number):
    """Return whether a process has a handler of Ctrl-C, as Python makes one when it starts."""
    for line in Path(f"/proc/{number}/status").read_text().splitlines():
        if line.startswith("SigCgt:"):
            return bool(int(line.split()[1], 16) >> (signal.SIGINT - 1) & 1)
    return False


def wait_for(condition, process):
    deadline = time.monotonic() + 60.0
    while not condition() and process.poll() is None:
        assert time.monotonic() < deadline
        time.sleep(0.002)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs /proc")
@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("command", COMMANDS)
def test_it_ends_cleanly(folder, command, moment):
    with (folder / "said.txt").open("wb") as said:
        process = subprocess.Popen(
            [sys.executable, "crazychoir", *COMMANDS[command]],
            cwd=folder,
            stdout=said,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(map(os.path.abspath, sys.path))},
        )
    try:
        wait_for(lambda: handles_interrupts(process.pid), process)
        wait_for(lambda: not handles_interrupts(process.pid), process)
        time.sleep(moment)
        process.send_signal(signal.SIGINT)
        code = process.wait(60.0)
        deadline = time.monotonic() + 5.0
        while (left := of_session(process.pid)) and time.monotonic() < deadline:
            time.sleep(0.05)
    finally:
        for number in of_session(process.pid):
            os.kill(number, signal.SIGKILL)
    text = (folder / "said.txt").read_text(errors="replace")
    assert "Traceback" not in text and "Error" not in text, text[-2000:]
    assert code in (-signal.SIGINT, 0, 1, 130), (code, text[-2000:])
    assert not left


def test_a_program_that_imports_the_package_keeps_its_signals():
    code = (
        "import signal; before = signal.getsignal(signal.SIGINT); import crazychoir_fw.cli; "
        "assert signal.getsignal(signal.SIGINT) is before is signal.default_int_handler"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
