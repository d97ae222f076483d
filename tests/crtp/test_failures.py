"""Clients and servers that die, freeze, come again or come twice: the real cflib in processes of its own.

Everything happens at once; what the drones did is what the log of the simulation says.
"""

import json
import signal
import socket
import sys
import time
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from serving import Outcome, end_of, serving, start

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.simulation import DroneConfig, World
from crazychoir_fw.simulation.replay import build

pytest.importorskip("cflib")
if sys.platform != "linux":
    pytest.skip("other systems say later, or not at all, that somebody has gone", allow_module_level=True)

SCRIPTS = Path(__file__).parent / "failure_scripts"
FREEZE_S = 3.0


@dataclass(frozen=True)
class Happened:
    """The outcome of all scripts and drones."""

    scripts: dict[str, Outcome]
    log: FlightLog


def wait_for(script, word) -> None:
    for line in script.stdout:
        if line.startswith(word):
            return
    raise AssertionError(f"it never said '{word}': {script.stderr.read()}")


@pytest.fixture(scope="module")
def happened(tmp_path_factory):
    out, cache = tmp_path_factory.mktemp("served"), str(tmp_path_factory.mktemp("cache"))
    with serving(SCRIPTS / "served.yaml", "--out", out) as (_, uris), serving("--count", "1") as (other, its):
        running = {name: start(SCRIPTS / f"{name}.py", uris[name], cache) for name in uris}
        frozen = start(SCRIPTS / "frozen.py", its["cf1"], cache)
        wait_for(frozen, "logging")
        other.send_signal(signal.SIGSTOP)
        time.sleep(FREEZE_S)
        other.send_signal(signal.SIGCONT)
        wait_for(running["abandoned"], "flying")
        running["abandoned"].kill()
        time.sleep(1.5)
        other.kill()
        outcomes = {name: end_of(script) for name, script in running.items()}
        outcomes["frozen"] = end_of(frozen)
    return Happened(outcomes, FlightLog.load(out / "log.npz"))


@pytest.mark.parametrize("name", ["reconnected", "scanned", "shared", "measured", "frozen"])
def test_it_ends_well(happened, name):
    outcome = happened.scripts[name]
    assert outcome.exit_code == 0, outcome.output + outcome.errors


# ---------------------------------------------------------------- the client dies


@dataclass(frozen=True)
class Abandoned:
    """The flight of the drone whose client was killed, flown again from the journal and looked at every tick."""

    last: int
    """Tick of the last set-point."""
    states: list[str]
    """Of the supervisor, since then."""
    turning: np.ndarray
    """Whether any motor had a command above zero."""
    roll_and_pitch: np.ndarray
    """What was asked of the controller (deg)."""


@pytest.fixture(scope="module")
def abandoned(happened):
    journal = happened.log.journal
    world = build(journal)
    number = happened.log.drone_ids.index("abandoned")
    drone = world.drones[number]

    def deliver(request):
        with suppress(CrazychoirError):  # refused then as well
            world.drones[request.drone].uplink.dispatch(request.verb, *request.arguments)

    last = 0
    for request in journal:
        world.agenda.at(request.tick, partial(deliver, request))
        if request.drone == number and request.verb == "packet" and request.arguments[0] == SETPOINTS:
            last = request.tick
    world.step(last)
    states, turning, asked = [], [], []
    for _ in range(3000):
        states.append(drone.supervisor_state)
        onboard = drone.log
        turning.append(any(onboard[f"motor.m{k}"] > 0 for k in (1, 2, 3, 4)))
        asked.append((onboard["ctrltarget.roll"], onboard["ctrltarget.pitch"]))
        world.step(1)
    return Abandoned(last, states, np.array(turning), np.array(asked))


SETPOINTS = 7
"""Port."""
UPDATE = 40
"""Ticks between two looks of the supervisor."""


def test_a_drone_without_client_levels_out_after_half_a_second(abandoned):
    begin = abandoned.states.index("Warning, level out")
    assert 500 < begin <= 500 + UPDATE + 1
    assert set(abandoned.states[:begin]) == {"Flying"}


def test_its_motors_stop_after_two_seconds(abandoned):
    assert abandoned.turning[:2000].all()
    stopped = int(np.argmin(abandoned.turning))
    assert 2000 < stopped <= 2000 + UPDATE + 1
    assert not abandoned.turning[stopped:].any()
    assert abandoned.states[stopped + 1] not in ("Flying", "Warning, level out")


def test_its_session_ends_because_its_client_is_gone(happened):
    ends = [
        event["details"]["reason"]
        for event in happened.log.events
        if event["drone"] == "abandoned" and event["details"].get("phase") == "end"
    ]
    # gone, if the server sent a packet, and the operating system reported that the port is closed
    assert ends[0] in ("gone", "silence")


# ---------------------------------------------------------------- the server freezes, and dies


def test_a_frozen_server_goes_on_without_a_burst(happened):
    heard = np.array(json.loads(happened.scripts["frozen"].output.splitlines()[-1])["heard"])
    arrivals, stamps = heard.T
    freeze = int(np.argmax(np.diff(arrivals)))
    assert arrivals[freeze + 1] - arrivals[freeze] > 0.9 * FREEZE_S
    assert len(arrivals) - freeze > 20, "the session has not survived"
    # it gives up the time that it was frozen: simulated time goes on where it was
    assert stamps[freeze + 1] - stamps[freeze] == 10
    at_once = np.searchsorted(arrivals, arrivals[freeze + 1] + 0.05) - (freeze + 1)
    assert at_once <= 100


@pytest.fixture
def served():
    """A server, and its client."""
    world = World([DroneConfig("cf1")], visuals=False)
    with world.serve(port=0) as server, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        host, port = server.uris["cf1"].removeprefix("udp://").split(":")
        client.settimeout(10.0)
        client.connect((host, int(port)))
        client.send(b"\xfd\x00")
        assert client.recv(64).startswith(b"\xfdBitcraze")
        yield server, client


@contextmanager
def stopped(server):
    """What happens while the process is stopped, until it goes on."""
    radio = server._radio
    with radio._lock:
        yield
        now = radio._clock() + FREEZE_S
        radio._clock = lambda: now
        radio._handle([])


def test_who_was_not_listened_to_has_not_been_silent(served):
    server, client = served
    with stopped(server):
        client.send(b"\xfcping")
    assert client.recv(64) == b"\xfcping"
    (counts,) = server.statistics().drones.values()
    assert counts.sessions == 1


def test_who_was_not_listened_to_gets_the_log_of_that_moment(served):
    server, client = served
    with stopped(server):
        (drone,) = server._radio._radios
        drone.station.context.send(5, 2, b"log", droppable=True)
    assert client.recv(64) == b"\x5elog"


def test_the_client_of_a_dead_server_loses_its_link(happened):
    told = json.loads(happened.scripts["frozen"].output.splitlines()[-1])
    assert told["is_lost"]
    assert "refused" in told["said"][0]


# ---------------------------------------------------------------- clients that come again, or look around


def test_one_object_connects_ten_times(happened):
    lines = happened.scripts["reconnected"].output.splitlines()
    assert [len(line.split()) for line in lines] == [5] * 10
    assert all(3.0 < float(voltage) < 4.3 for line in lines for voltage in line.split())


def test_scans_find_a_drone_and_leave_its_client_alone(happened):
    found, packets, longest = map(int, happened.scripts["scanned"].output.split())
    assert found == 40
    assert packets > 100
    assert longest == 10


def test_the_second_client_waits_for_the_first(happened):
    first, *then = happened.scripts["shared"].output.splitlines()
    assert first == "first logs 10 second is open False"
    assert then == ["second is open True", "second logs 10"]
    assert ("radio_refused", "shared") in {(event["kind"], event["drone"]) for event in happened.log.events}


def test_no_echo_is_lost_and_the_memory_holds_what_is_written(happened):
    lines = happened.scripts["measured"].output.splitlines()
    assert lines == [
        "echoes of 4 bytes 1000",
        "echoes of 28 bytes 1000",
        "read True True",
        "written True",
        "errors 0",
    ]
