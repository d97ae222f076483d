"""`crazychoir serve` as a user runs it: in a process of its own, ended by a signal."""

import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
from contextlib import contextmanager, suppress

import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app

MISSION = """
name: two
drones: {count: 2, layout: line, spacing: 1.0}
flight: [{hover: {duration: 1.0}}]
faults: [{kick: {at: 0.2, drones: [cf1], impulse: [0.001, 0, 0]}}]
"""


def serve(*words):
    return CliRunner().invoke(app, ["serve", *map(str, words)])


@contextmanager
def process(*words):
    """Serve in a process of its own; yields it with the URIs of its drones."""
    command = [sys.executable, "-c", "from crazychoir_fw.cli import app; app()", "serve", *map(str, words)]
    environment = {**os.environ, "PYTHONUNBUFFERED": "1", "COLUMNS": "120"}
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment
    ) as served:
        uris = {}
        try:
            for line in served.stdout:
                if found := re.search(r"(\w+) +(udp://\S+)", line):
                    uris[found[1]] = found[2]
                if line.startswith("Serving"):
                    break
            yield served, uris
        finally:
            served.kill()


@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGTERM])
def test_a_client_is_served_until_a_signal_comes(tmp_path, end):
    (tmp_path / "two.yaml").write_text(MISSION)
    writes = end == signal.SIGINT
    with process(tmp_path / "two.yaml", "--port", 0, *(["--out", tmp_path / "out"] if writes else [])) as (
        served,
        uris,
    ):
        assert list(uris) == ["cf1", "cf2"]
        host, port = uris["cf2"].removeprefix("udp://").split(":")
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
            client.settimeout(20.0)
            client.connect((host, int(port)))
            client.send(b"\xfd\0")
            assert client.recv(100).startswith(b"\xfdBitcraze Crazyflie")
        served.send_signal(end)
        rest, _ = served.communicate(timeout=60)
    assert served.returncode == 0, rest
    assert "1 sessions, 1 packets taken, 1 replies" in rest
    if writes:
        figures = json.loads((tmp_path / "out" / "statistics.json").read_text())
        assert figures["drones"]["cf2"]["sessions"] == 1
        assert (tmp_path / "out" / "flight.png").exists()
        result = CliRunner().invoke(app, ["replay", str(tmp_path / "out"), "--check"])
        assert result.exit_code == 0, result.output
        assert "Same to the last bit" in result.output


def test_a_number_of_drones_is_enough():
    result = serve("--count", 3, "--port", 0, "--seconds", 0.05)
    assert result.exit_code == 0, result.output
    assert "served: 3 drones" in result.output
    assert len(re.findall(r"udp://127\.0\.0\.1:\d+", result.output)) == 3
    assert "Serving, 1 x real time; for 0.05 s" in result.output
    assert "network" not in result.output


def test_without_a_journal_there_is_no_replay(tmp_path):
    words = ("--count", 1, "--port", 0, "--seconds", 0.05, "--speed", 0, "--out", tmp_path, "--no-journal")
    result = serve(*words)
    assert result.exit_code == 0, result.output
    assert "it cannot be replayed" in result.output
    result = CliRunner().invoke(app, ["replay", str(tmp_path), "--check"])
    assert result.exit_code == 2
    assert "the journal has a gap: the drones were served with --no-journal" in result.output


def test_time_stands_still_until_there_are_clients():
    with process("--count", 2, "--port", 0, "--seconds", 0.1, "--wait-for", 2) as (served, uris):
        clients = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in uris]
        for client, uri in zip(clients, uris.values(), strict=True):
            # with one of two clients the server waits forever
            assert served.poll() is None
            host, port = uri.removeprefix("udp://").split(":")
            client.settimeout(20.0)
            client.connect((host, int(port)))
            client.send(b"\xfd\0")
            assert client.recv(100).startswith(b"\xfdBitcraze Crazyflie")
        while served.poll() is None:  # clients are there as long as they ping
            for client in clients:
                with suppress(OSError):
                    client.send(b"\xfcping")
            time.sleep(0.05)
        rest = served.stdout.read()
        for client in clients:
            client.close()
    assert served.returncode == 0, rest
    assert "Time stands still until 2 drones have a client" in rest
    assert "0.1 s served" in rest


def test_a_crowd_is_not_listed_whole():
    result = serve("--count", 40, "--port", 0, "--seconds", 0.01, "--speed", 0)
    assert result.exit_code == 0, result.output
    assert len(re.findall(r"udp://127\.0\.0\.1:\d+", result.output)) == 33
    assert "up to cf40 at udp://" in result.output
    assert "as fast as possible" in result.output


def test_it_says_so_when_others_can_fly():
    result = serve("--count", 1, "--port", 0, "--seconds", 0.01, "--host", "0.0.0.0")
    assert result.exit_code == 0, result.output
    assert "whoever reaches 0.0.0.0 over the network can fly these drones" in result.output


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ([], "name a mission file, or a number of drones with --count"),
        (["mission.yaml", "--count", "2"], "name a mission file, or a number of drones with --count"),
        (["missing.yaml"], "missing.yaml cannot be read"),
        (["--count", "2", "--port", "65535"], "port 65535 for 2 drones, allowed: 0 (any free ones) or 1 to 65534"),
        (["--count", "2", "--port", "0", "--host", "192.0.2.1"], "host '192.0.2.1' cannot be served from"),
        (["--count", "1", "--view=paper"], "--view is 'paper'"),
        (["--count", "2", "--wait-for", "3"], "--wait-for is 3, allowed: 0 to 2, the number of drones"),
    ],
)
def test_what_cannot_be_served_is_said_in_one_sentence(words, sentence):
    result = serve(*words)
    assert result.exit_code == 2
    assert sentence in result.output


def test_a_taken_port_is_named():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        port = other.getsockname()[1]
        result = serve("--count", 1, "--port", port)
    assert result.exit_code == 2
    assert f"port {port} of 127.0.0.1 is taken" in result.output


def test_a_fault_that_cannot_befall_is_refused(tmp_path):
    (tmp_path / "two.yaml").write_text(
        MISSION.replace("kick: {at: 0.2, drones: [cf1], impulse: [0.001, 0, 0]}", "payload_drop: {at: 0.1}")
    )
    result = serve(tmp_path / "two.yaml", "--port", 0, "--seconds", 0.05)
    assert result.exit_code == 2
    assert "faults[0]" in result.output


def test_it_can_be_watched(monkeypatch):
    seen = []

    class View:
        def __enter__(self):
            return lambda world, progress: seen.append(progress.sim_seconds)

        def __exit__(self, *_):
            pass

    monkeypatch.setattr("crazychoir_fw.cli.view.open_view", lambda way, say: View())
    result = serve("--count", 1, "--port", 0, "--seconds", 0.2, "--view", "web")
    assert result.exit_code == 0, result.output
    assert len(seen) > 2
    assert seen[0] == 0.0
    assert seen == sorted(seen)
