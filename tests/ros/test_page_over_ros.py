"""The page of a flight over ROS 2: beside processes of its own, joined to those of others, and what it refuses."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import uuid
from pathlib import Path

import httpx
import numpy as np
import pytest
from nav_msgs.msg import Odometry
from ros_domains import reserve_domain
from ros_flights import all_gone
from std_msgs.msg import Empty, String

from crazychoir_fw.common.errors import CrazychoirError, RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.flight.access.ros import FEW_PLOTS, NO_ARM, NO_PARAMETERS, NO_TIME
from crazychoir_fw.flight.agent import DronePhase
from crazychoir_fw.gui import requests as asked
from crazychoir_fw.gui.commands import Commands
from crazychoir_fw.gui.opening import open_mission
from crazychoir_fw.gui.session import Session
from crazychoir_fw.ros.conversions import pose_to_odometry
from crazychoir_fw.ros.drone_states import EVENTS, STATES, STATES_QOS, read_event, read_states
from crazychoir_fw.ros.joined_flight import JoinedFlight, join
from crazychoir_fw.ros.topic_experiment import TopicExperiment

pytest.importorskip("nicegui")

PATIENCE = 240.0  # [s], of the wall clock, for what must come
EXAMPLES = Path(__file__).parents[2] / "examples"
CHROMIUM_OPTIONS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


class Served:
    """`crazychoir gui --ros`, and a session that has joined the same flight."""

    def __init__(self, folder):
        self.domain = reserve_domain()
        # long timeouts: no process counts as lost because the machine is busy
        code = (
            "from functools import partial; from crazychoir_fw.cli import app; from crazychoir_fw.ros import manager; "
            f"manager.RosOptions = partial(manager.RosOptions, deadline={PATIENCE}, patience=60.0); app()"
        )
        options = ["--ros", "--processes", "one", "--backend", "integrator", "--speed", "30"]
        where = ["--no-browser", "--port", "0", "--domain", str(self.domain)]
        command = [sys.executable, "-c", code, "gui", str(EXAMPLES / "draw.yaml"), *options, *where]
        self.log = folder / "log.txt"
        self.out = folder / "out" / "draw"
        with self.log.open("w") as log:
            self.process = subprocess.Popen(command, stdout=log, stderr=log, cwd=folder)
        self.address = None
        self.until(self._find_address, "the page is there")
        mission = open_mission(EXAMPLES / "draw.yaml", backend="integrator")
        self.onlooker = Session(mission, make=lambda m: join(m, self.domain, PATIENCE)).open()
        self.onlooker.wait_until_ready(PATIENCE)

    def _find_address(self):
        found = re.search(r"http://127\.0\.0\.1:\d+", self.log.read_text())
        self.address = None if found is None else found[0]
        return found

    def until(self, condition, what):
        deadline = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < deadline, f"{what}: not within {PATIENCE} s\n{self.log.read_text()[-3000:]}"
            assert self.process.poll() is None, f"{what}: the flight has ended\n{self.log.read_text()[-3000:]}"
            time.sleep(0.02)

    def command(self, **command):
        body = {"id": uuid.uuid4().hex, "command": command}
        return httpx.post(f"{self.address}/api/command", json=body, timeout=PATIENCE).json()

    def get(self, path):
        return httpx.get(self.address + path, timeout=PATIENCE)

    @property
    def phases(self):
        return [agent.phase for agent in self.onlooker.experiment.agents]

    @property
    def places(self):
        return self.onlooker.experiment.backend.poses().position

    def close(self):
        self.onlooker.close()
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            try:
                self.process.wait(60.0)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    flight = None
    try:
        flight = Served(tmp_path_factory.mktemp("page"))
        yield flight
    finally:
        if flight is not None:
            flight.close()


def on_the_floor(served):
    served.command(name="stop")
    served.until(lambda: all(phase is not DronePhase.FLYING for phase in served.phases), "all motors are off")


def test_takeoff_goto_land_stop(served):
    assert served.command(name="takeoff")["text"] == "TAKE-OFF: all 4 drones"
    served.until(lambda: served.phases == [DronePhase.FLYING] * 4, "all fly")
    served.until(lambda: np.abs(served.places[:, 2] - 1.0).max() < 0.05, "all are up")
    answer = served.command(name="goto", x=0.0, y=0.5, z=1.3, drones=["agent_1"])
    assert answer["ok"], answer["text"]
    served.until(lambda: np.linalg.norm(served.places[1] - (0.0, 0.5, 1.3)) < 0.05, "one goes where it was sent")
    # the other drones did not get the command
    assert np.linalg.norm(served.places[[0, 2, 3], :2] - [(-1.5, -1.5), (0.5, -1.5), (1.5, -1.5)], axis=1).max() < 0.05
    agent = served.onlooker.experiment.agents[1]
    served.until(lambda: np.allclose(agent.reference.position, (0.0, 0.5, 1.3)), "the reference is shown")
    assert served.command(name="stop", drones=["agent_3"])["text"] == "STOP: agent_3"
    served.until(lambda: served.phases[3] is DronePhase.STOPPED, "one has stopped")
    assert served.phases[:3] == [DronePhase.FLYING] * 3
    assert served.command(name="land")["ok"]
    served.until(lambda: served.phases == [DronePhase.LANDED] * 3 + [DronePhase.STOPPED], "the others have landed")
    # states and events have topics of their own
    events = served.onlooker.experiment.events
    served.until(lambda: {"takeoff", "land", "landed", "stop"} <= {event.kind for event in list(events)}, "all is told")


def test_a_drawn_curve_is_flown(served):
    on_the_floor(served)
    points = [[-1.5 + 0.05 * k, -1.0 + 0.02 * k, 0.1 * k] for k in range(20)]
    change = {"action": "add", "points": points, "height": 0.8}
    body = {"id": uuid.uuid4().hex, "change": change}
    assert httpx.post(f"{served.address}/api/drawings", json=body, timeout=PATIENCE).json()["ok"]
    preview = httpx.post(f"{served.address}/api/preview", json={}, timeout=PATIENCE).json()
    assert served.command(name="fly", preview=preview["key"])["text"].startswith("FLY ")
    end = (*points[-1][:2], 0.8)
    served.until(lambda: np.linalg.norm(served.places[0] - end) < 0.05, "the end of the curve is reached")
    on_the_floor(served)


@pytest.mark.parametrize(
    ("command", "sentence"),
    [
        ({"name": "rewind", "branch": 0, "time": 1.0}, NO_TIME),
        ({"name": "speed", "factor": 2.0}, NO_TIME),
        ({"name": "arm"}, NO_ARM),
        ({"name": "reboot"}, NO_ARM),
        ({"name": "set_parameter", "parameter": "posCtlPid.xKp", "value": 2.0}, NO_PARAMETERS),
        ({"name": "goto", "x": 0, "y": 0, "z": 1}, "press TAKE-OFF"),
    ],
)
def test_what_topics_do_not_carry_is_refused_in_a_sentence(served, command, sentence):
    on_the_floor(served)
    envelope = asked.read(asked.Envelope, {"id": uuid.uuid4().hex, "command": command})
    with pytest.raises(CrazychoirError, match=re.escape(sentence)):
        Commands(served.onlooker, None).send(envelope).result(PATIENCE)


def test_a_joined_page_knows_what_it_lacks(served):
    access = served.onlooker.access
    assert access.missing() == {"arm": NO_ARM, "parameters": NO_PARAMETERS, "plots": FEW_PLOTS}
    assert "position.z" in access.log_names()
    with pytest.raises(CrazychoirError, match=re.escape(NO_PARAMETERS)):
        access.parameters(0)
    assert served.onlooker.no_rewind == NO_TIME


def test_the_page_of_the_host_pauses_and_does_not_rewind(served):
    assert served.command(name="speed", factor=0.0)["text"] == "PAUSE"
    answer = served.command(name="rewind", branch=0, time=1.0)
    assert (answer["ok"], answer["text"]) == (False, TopicExperiment.no_rewind)
    assert served.command(name="speed", factor=30.0)["ok"]


def test_in_a_browser_drones_move_and_a_sentence_stands_for_what_is_missing(served):
    playwright = pytest.importorskip("playwright.sync_api")
    path = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
    if path is None:
        pytest.skip("Chromium is not installed (Debian: apt install chromium), and CHROMIUM names none")
    on_the_floor(served)
    with playwright.sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=path, args=CHROMIUM_OPTIONS)
        page = chromium.new_page(viewport={"width": 1200, "height": 800})
        page.set_default_timeout(90_000)
        errors = []
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(served.address)
        page.wait_for_function("window.cc && cc.frame && cc.setting && cc.words.cards")
        page.get_by_text("TAKE-OFF", exact=True).click()
        page.wait_for_function("cc.frame.drones.every((d) => d.phase === 'flying' && d.position[2] > 0.8)")
        assert page.evaluate("cc.words.no_rewind") == TopicExperiment.no_rewind
        page.keyboard.press("Escape")
        served.until(lambda: DronePhase.FLYING not in served.phases, "Esc is STOP")
        assert errors == []
        chromium.close()


def test_a_joined_page_leaves_the_flight_going_and_the_one_that_began_it_ends_it(served):
    on_the_floor(served)
    numbers = json.loads((served.out / "processes.json").read_text())
    assert set(numbers) == {"host"}
    served.onlooker.close()
    # it goes on without it
    assert served.command(name="takeoff")["ok"]
    assert served.process.poll() is None
    served.process.send_signal(signal.SIGINT)
    served.process.wait(PATIENCE)
    assert "Traceback" not in served.log.read_text()
    assert all_gone(numbers.values())


# ---------------------------------------------------------------- without a flight


def test_a_flight_that_is_not_there_is_not_joined():
    mission = open_mission(EXAMPLES / "draw.yaml")
    domain = reserve_domain()
    with pytest.raises(CrazychoirError, match=f"no drones of it are heard on ROS domain {domain} within 0.2 s; start"):
        join(mission, domain, 0.2)


def test_a_flight_of_another_mission_is_not_joined(bench):
    told = {"mission": "other", "backend": "sim", "time": 0.0, "drones": {}}
    states = bench.user.create_publisher(String, STATES, STATES_QOS)
    flight = JoinedFlight(open_mission(EXAMPLES / "draw.yaml"), int(os.environ["ROS_DOMAIN_ID"]))
    try:
        bench.until(lambda: states.get_subscription_count())
        states.publish(String(data=json.dumps(told)))
        with pytest.raises(CrazychoirError, match="has a flight of 'other' with 0 drones, and not of"):
            flight.wait_until_found(PATIENCE)
    finally:
        flight.close()


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--ros", "--ros-join"], "give one of them"),
        (["--ros", "--processes", "none"], "--processes is none, allowed: per-node"),
    ],
)
def test_options_that_make_no_sense(options, sentence, capfd):
    from typer.testing import CliRunner

    from crazychoir_fw.cli import app

    run = CliRunner().invoke(app, ["gui", str(EXAMPLES / "draw.yaml"), "--no-browser", "--port", "0", *options])
    assert run.exit_code == 2
    assert sentence in run.output + capfd.readouterr().err


def test_phases_are_guessed_where_no_host_tells_them(bench, monkeypatch):
    """A third-party simulation has buttons and odometry, and no more."""
    monkeypatch.setattr("crazychoir_fw.ros.joined_flight._TOLD_S", 0.3)
    flight = JoinedFlight(open_mission(EXAMPLES / "draw.yaml"), int(os.environ["ROS_DOMAIN_ID"]))
    try:
        odom = bench.user.create_publisher(Odometry, "/agent_0/odom", 10)
        pressed = bench.hear(Empty, "/takeoff")
        single = bench.hear(Empty, "/agent_0/stop")
        now = 0.0

        def until(condition, height):
            nonlocal now
            end = time.monotonic() + PATIENCE
            while not condition():
                assert time.monotonic() < end, "it never came about"
                now += 0.01
                here = Pose(np.array([-1.5, -1.5, height]), np.array([0.0, 0, 0, 1]), np.zeros(3), np.zeros(3), now)
                odom.publish(pose_to_odometry(here))
                bench.drain()
                flight.step()

        agent = flight.agents[0]
        until(lambda: flight._watches_topics and flight.time > 0.0, 0.0)
        assert agent.phase is DronePhase.GROUND
        until(lambda: flight._buttons["takeoff", None].get_subscription_count() > 1, 0.0)
        flight.takeoff()
        until(lambda: pressed and agent.phase is DronePhase.FLYING, 0.0)
        with pytest.raises(CrazychoirError, match="nobody listens to /land on ROS domain"):
            flight.land()
        land = bench.user.create_publisher(Empty, "/land", 10)
        until(lambda: land.get_subscription_count() > 0, 0.8)
        land.publish(Empty())
        until(lambda: agent.phase is DronePhase.LANDING, 0.8)
        assert "LAND was pressed elsewhere" in [happening.details for happening in flight.events]
        until(lambda: agent.phase is DronePhase.LANDED, 0.01)
        until(lambda: flight._buttons["stop", 0].get_subscription_count() > 0, 0.01)
        flight.stop(["agent_0"])
        until(lambda: single, 0.01)
    finally:
        flight.close()


# ---------------------------------------------------------------- what hosts say


@pytest.mark.parametrize(
    "text",
    ["", "3", "{}", '{"mission": 1, "backend": 2, "time": "x", "drones": {}}', '{"drones": {"a": 1}}'],
)
def test_states_that_are_none_are_refused(text):
    with pytest.raises(RangeError, match="says nothing of drones"):
        read_states(text)


@pytest.mark.parametrize("text", ["", "[]", '{"time": 1, "kind": "a", "drone": 3, "details": {}}', '{"time": null}'])
def test_events_that_are_none_are_refused(text):
    with pytest.raises(RangeError, match=f"{EVENTS}: .* is no event"):
        read_event(text)
