"""`crazychoir serve` and scripts of clients, each in a process of its own."""

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

PATIENCE_S = 150.0
"""So long a script may take (s) on a machine that is busy; most of them need 5 to 20."""


@dataclass(frozen=True)
class Outcome:
    """What a script did."""

    exit_code: int
    output: str
    errors: str


@contextmanager
def serving(*words) -> Iterator[tuple[subprocess.Popen, dict[str, str]]]:
    """Run `crazychoir serve`. Yields the process and where the drones are."""
    crazychoir = [sys.executable, "-c", "from crazychoir_fw.cli import app; app()", "serve", "--port", "0"]
    environment = {**os.environ, "COLUMNS": "120"}
    command = [*crazychoir, *map(str, words)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as server:
        try:
            yield server, _uris_of(server)
        finally:
            server.send_signal(signal.SIGINT)
            server.communicate(timeout=PATIENCE_S)


def _uris_of(server) -> dict[str, str]:
    text = ""
    for line in server.stdout:
        text += line
        if line.startswith("Serving"):
            return dict(re.findall(r"(\w+) +(udp://[\d.:]+)", text))
    raise AssertionError(f"does not serve: {text}")


def start(script, *words) -> subprocess.Popen:
    """Start a script with words for it."""
    command = [sys.executable, script, *words]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def end_of(script) -> Outcome:
    """Wait for a script, or end it when it takes too long."""
    try:
        output, errors = script.communicate(timeout=PATIENCE_S)
    except subprocess.TimeoutExpired:
        script.kill()
        output, errors = script.communicate()
    return Outcome(script.returncode, output, errors)
