"""A disk that is full at random writes: verdict and exit code as ever, one sentence, no file that lies.

`ATTACK_DISKS=20` tries so many writes of each command.
"""

import json
import os
import random
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from crazychoir_fw.recording.flight_log import FlightLog

COUNT = int(os.environ.get("ATTACK_DISKS", "1"))
SEED = int(os.environ.get("ATTACK_SEED", "1"))
MISSION = """
name: short
seed: 5
drones: {count: 2, spacing: 0.4}
flight: [{takeoff: {height: 0.4, duration: 0.8}}, {land: {duration: 0.8}}]
"""
COMMANDS = {
    "fly": ["fly", "short.yaml", "--out", "out"],
    "serve": ["serve", "--count", "1", "--port", "0", "--seconds", "2", "--speed", "0", "--out", "out"],
}


@pytest.fixture(scope="module")
def shim(tmp_path_factory):
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None or not sys.platform.startswith("linux"):
        pytest.skip("needs a C compiler and Linux")
    library = tmp_path_factory.mktemp("shim") / "full_disk.so"
    source = Path(__file__).parent / "full_disk.c"
    subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", library, source, "-ldl"], check=True)
    return library


def run(shim, folder, command, **settings):
    code = "from crazychoir_fw.cli import app\napp()"
    environment = {**os.environ, "LD_PRELOAD": str(shim), "FULL_DISK_FOLDER": str(folder / "out"), **settings}
    return subprocess.run(
        [sys.executable, "-c", code, *COMMANDS[command]], cwd=folder, env=environment, capture_output=True, text=True
    )


@pytest.mark.timeout(300 + 120 * COUNT)
@pytest.mark.parametrize("command", COMMANDS)
def test_a_disk_full_at_a_random_write_costs_no_verdict(shim, tmp_path, command):
    (tmp_path / "short.yaml").write_text(MISSION)
    good = run(shim, tmp_path, command, FULL_DISK_COUNT=str(tmp_path / "count"))
    assert good.returncode == 0, good.stderr
    total, out = int((tmp_path / "count").read_text()), tmp_path / "out"
    assert total > 5
    dice = random.Random(f"{SEED} {command}")
    for after in sorted(dice.sample(range(total), min(COUNT, total))):
        shutil.rmtree(out)
        ended = run(shim, tmp_path, command, FULL_DISK_AFTER=str(after))
        what = f"{command}, full after {after} of {total} writes: code {ended.returncode}\n{ended.stdout}{ended.stderr}"
        said = ended.stderr
        assert "Traceback" not in said + ended.stdout, what
        if after == 0:  # nothing is flown whose record cannot even begin
            assert ended.returncode == 2, what
        else:
            assert ended.returncode == 0, what
            assert "success: " in ended.stdout or command == "serve", what
        assert said.count("No space left on device") == 1, what
        left = sorted(path.name for path in out.iterdir())
        assert not [name for name in left if name.startswith(".")], what
        if "summary.json" in left:
            json.loads((out / "summary.json").read_text())
            assert "log.npz" in left, what
        for name in ("log.npz", "log.stream"):
            if name in left and (out / name).stat().st_size > 1000:
                FlightLog.load(out / name)
