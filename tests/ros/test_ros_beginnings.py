"""Flights over ROS that cannot begin: one sentence, at once, and no process is left."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from ros_domains import reserve_domain

EXAMPLES = Path(__file__).parents[2] / "examples"
DIES = """
import os
from crazychoir_fw.guidance import BearingFormation

class Dies(BearingFormation):
    def __init__(self, *arguments, **options):
        os._exit(3)
"""
REFUSES = """
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance import BearingFormation

class Refuses(BearingFormation):
    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        raise RangeError(f"agent {self.agent_id} will not fly, allowed: those that do")
"""


def fly(mission, folder, *options):
    command = [sys.executable, "-c", "from crazychoir_fw.cli import app; app()", "fly", EXAMPLES / mission, "--ros"]
    command += ["--no-video", "--domain", str(reserve_domain()), "--out", folder, *options]
    # shorter than 180 s, the timeout until all processes must have found each other
    return subprocess.run(command, capture_output=True, text=True, timeout=150.0)


@pytest.mark.parametrize("restart", [(), ("--restart",)], ids=["once", "restarted"])
@pytest.mark.parametrize("processes", ["per-node", "one"])
def test_what_cannot_be_made_is_said_in_a_sentence(restart, processes, tmp_path):
    (tmp_path / "refuses.py").write_text(REFUSES)
    law = f"layers.guidance.class={tmp_path / 'refuses.py'}:Refuses"
    flown = fly("bearing_formation.yaml", tmp_path, "--set", law, "--processes", processes, *restart)
    text = flown.stdout + flown.stderr
    assert flown.returncode == 2, text
    assert "Traceback" not in text
    assert re.search(r"layers\.guidance: agent \d will not fly, allowed: ", text), text
    # the host says it itself
    assert processes == "one" or flown.stderr.splitlines()[-1].endswith(" cannot be made, see what it said")


def test_a_process_that_ends_before_the_flight_is_not_waited_for(tmp_path):
    (tmp_path / "dies.py").write_text(DIES)
    flown = fly("bearing_formation.yaml", tmp_path, "--set", f"layers.guidance.class={tmp_path / 'dies.py'}:Dies")
    assert flown.returncode == 2, flown.stdout
    assert "/guidance ended with code 3" in flown.stdout
    assert flown.stderr.splitlines()[-1].endswith("/guidance has ended before the flight began, see what it said")
