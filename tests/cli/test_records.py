"""What a flight leaves in its folder when it is cut off, when the disk is full, and after a killed one."""

import errno
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.common import replacing as replacing_module
from crazychoir_fw.recording.flight_log import FlightLog

MISSION = """
name: short
seed: 5
drones: {count: 2, spacing: 0.4}
flight:
- takeoff: {height: 0.4, duration: 0.8}
- land: {duration: 0.8}
"""


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "short.yaml").write_text(MISSION)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "summary.json").write_text("old")
    (tmp_path / "out" / "log.npz").write_text("old")
    return tmp_path


@pytest.mark.parametrize("writer", ["save", "plot", "move"])
def test_a_full_disk_costs_neither_verdict_nor_the_old_files(folder, monkeypatch, writer):
    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    target = {
        "save": "crazychoir_fw.recording.flight_log.FlightLog.save",
        "plot": "crazychoir_fw.recording.plot.plot_flight",
        "move": "crazychoir_fw.common.replacing.Path.mkdir",
    }[writer]
    if writer == "move":
        original = replacing_module.Path.mkdir
        monkeypatch.setattr(target, lambda path, *a, **k: full() if path.name[0] == "." else original(path, *a, **k))
    else:
        monkeypatch.setattr(target, full)
    result = run("fly", folder / "short.yaml", "--out", folder / "out")
    assert result.exit_code == 0, result.output
    assert "success: " in result.stdout and "cf1" in result.stdout
    assert result.stderr.count("No space left on device") == 1 and "out cannot be written" in result.stderr
    assert sorted(path.name for path in (folder / "out").iterdir()) == ["log.npz", "log.stream", "summary.json"]
    assert (folder / "out" / "summary.json").read_text() == (folder / "out" / "log.npz").read_text() == "old"
    monkeypatch.undo()
    assert run("replay", folder / "out", "--check").exit_code == 0  # what was flown is in the stream


def test_a_disk_that_fills_while_it_flies_costs_nothing_else(folder, monkeypatch):
    calls, write = 0, os.pwrite

    def full(file, data, offset):
        nonlocal calls
        calls += 1
        if calls > 9:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(file, data, offset)

    monkeypatch.setattr(os, "pwrite", full)
    result = run("fly", folder / "short.yaml", "--out", folder / "out")
    assert result.exit_code == 0, result.output
    assert sorted(path.name for path in (folder / "out").iterdir()) == ["flight.png", "log.npz", "summary.json"]
    assert run("replay", folder / "out", "--check").exit_code == 0


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_a_served_flight_that_is_ended_is_on_disk(tmp_path, number):
    out, command = tmp_path / "out", "from crazychoir_fw.cli import app; app()"
    arguments = ["serve", "--count", "1", "--port", "0", "--out", str(out)]
    served = subprocess.Popen([sys.executable, "-c", command, *arguments], stdout=subprocess.DEVNULL)
    try:
        stream, end = out / "log.stream", time.monotonic() + 60
        while not (stream.exists() and stream.stat().st_size > 100_000) and time.monotonic() < end:
            time.sleep(0.02)
        served.send_signal(number)
        served.wait(60)
    finally:
        served.kill()
        served.wait()
    name = "log.stream" if number == signal.SIGKILL else "log.npz"
    assert sorted(path.name for path in out.iterdir() if path.name.startswith((".", "log"))) == [name]
    log = FlightLog.load(out / name)
    assert np.allclose(np.diff(log.time), 0.01) and len(log.time) > 10
    assert run("replay", out, "--check").exit_code == 0


def test_temporary_files_of_killed_processes_are_removed_and_those_of_others_stay(tmp_path):
    process = subprocess.Popen([sys.executable, "-c", "pass"])
    process.wait()
    machine = replacing_module._machine()
    dead, alive = f".log.{machine}-{process.pid}-00ff00.npz", f".log.{machine}-{os.getppid()}-00ff00.npz"
    elsewhere, hidden = f".log.{int(machine, 16) ^ 1:08x}-{process.pid}-00ff00.npz", ".hidden.npz"
    for name in (dead, alive, elsewhere, hidden):
        (tmp_path / name).touch()
    (tmp_path / f".new.{machine}-{process.pid}-00ff00").mkdir()
    with replacing_module.replacing(tmp_path / "a.txt") as temporary:
        temporary.write_text("new")
    assert {path.name for path in tmp_path.iterdir()} == {alive, elsewhere, hidden, "a.txt"}
