"""The page over the radio: served drones, with the client library that flies real ones."""

import re
import sys
import threading
import uuid
from functools import partial
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cflib")
sys.path.append(str(Path(__file__).parents[1] / "flight"))
from ports import free_ports
from served_drones import Served

from crazychoir_fw.common.errors import StateError
from crazychoir_fw.flight.access.hardware import HardwareAccess
from crazychoir_fw.flight.agent import DronePhase
from crazychoir_fw.flight.engine import make_experiment
from crazychoir_fw.flight.roll_call import roll_call
from crazychoir_fw.gui.opening import open_mission
from crazychoir_fw.gui.preflight import preflight
from crazychoir_fw.gui.session import Session
from crazychoir_fw.mission.fleet import drone_settings
from crazychoir_fw.preflight.check import Check
from crazychoir_fw.simulation import DroneConfig, World

ONBOARD = """
name: two
seed: 3
drones:
  - {id: left, position: [-0.6, 0.0]}
  - {id: right, position: [0.6, 0.0]}
flight:
  - takeoff: {duration: 3.0}
layers:
  rate: 100
  odometry: estimate
  guidance: {class: SimpleGuidance, height: 0.8}
"""
STREAMED = (
    ONBOARD
    + """
  planning: {class: Spline}
  control: {class: HierarchicalController, sender: FPQRSender, gains: mujoco}
"""
)
CENTERS = [(-0.6, 0.3), (0.6, 0.3)]


def mission_file(tmp_path, text):
    path = tmp_path / "two.yaml"
    path.write_text(text)
    return path


@pytest.fixture
def lockstep(tmp_path):
    """Opens a flight over the radio whose world goes on only when the flight asks for it."""
    opened = []

    def open_one(text, kind, meant=None):
        standing = open_mission(mission_file(tmp_path, text))
        mission = standing if meant is None else open_mission(mission_file(tmp_path, meant))
        served = []

        def make(mission):
            served.append(Served(standing, tmp_path, kind))
            served[0].before_flight = partial(roll_call, mission, [([0, 1], served[0])])
            return make_experiment(mission, served[0])

        session = Session(mission, make=make).open()
        opened.append(session)
        session.wait_until_ready()
        return session, served[0].world_there

    yield open_one
    for session in opened:
        session.close()


def draw_two(client):
    """Draw four fifths of a circle for each drone."""
    angle = np.linspace(0.0, 1.6 * np.pi, 20)
    for name, (x, y) in zip(("left", "right"), CENTERS, strict=True):
        points = [[x + 0.3 * np.cos(a), y + 0.3 * np.sin(a), 0.15 * k] for k, a in enumerate(angle)]
        key = client.draw(action="add", points=points, height=0.8)["drawings"][-1]["key"]
        client.draw(action="change", drawing=key, drone=name)
    return client.post("/api/preview", {"time_scale": 2.5}).json()["key"]


def rms_of(curve, times, flown, delay):
    """Return how far a drone was from a curve that began so much later (m)."""
    wanted = curve.position(np.clip(times - delay, 0.0, curve.duration))[:, :3]
    return np.sqrt(((flown - wanted) ** 2).sum(axis=1).mean())


@pytest.mark.parametrize(("text", "kind"), [(ONBOARD, "xyz"), (STREAMED, "fpqr")], ids=["uploaded", "streamed"])
def test_a_drawn_curve_is_flown(lockstep, api, until, tmp_path, text, kind):
    session, world = lockstep(text, kind)
    client = api(session, tmp_path / "drawings")
    preview = draw_two(client)
    paths = []

    def follow(frame_time):
        paths.append((frame_time, world.positions()))

    answer = client.command(name="fly", preview=preview)
    assert answer["ok"], answer
    assert ("uploaded to the trajectory memory" in answer["text"]) is (kind == "xyz")
    flying = session.flying
    legs = list(flying.legs)
    step = session.experiment.step
    session.experiment.step = lambda: (step(), follow(session.experiment.time))
    until(lambda: session.flying is None)
    assert [leg.drone for leg in flying.legs] == [0, 1], list(session.lines)
    rows = list(paths)  # the flight goes on
    times = np.array([time for time, _ in rows])
    on_curve = (times >= flying.started) & (times <= flying.started + flying.duration)
    times, flown = times[on_curve] - flying.started, np.array([positions for _, positions in rows])[on_curve]
    for leg in legs:
        # on board no velocity is fed forward, so that a drone is late; aligned in time it is where it should be
        late = min(np.arange(0.0, 0.81, 0.02), key=lambda delay: rms_of(leg.curve, times, flown[:, leg.drone], delay))
        assert rms_of(leg.curve, times, flown[:, leg.drone], late) < 0.1
        assert late < (0.8 if kind == "xyz" else 0.2)
        # and against what the hand has drawn
        angle = np.linspace(0.0, 1.6 * np.pi, 200)
        circle = np.stack([np.cos(angle), np.sin(angle)], axis=1) * 0.3 + CENTERS[leg.drone]
        beside = np.linalg.norm(flown[:, leg.drone, None, :2] - circle, axis=2).min(axis=1)
        assert np.sqrt((beside**2).mean()) < 0.1
    assert client.command(name="land")["ok"]
    until(lambda: all(agent.phase is DronePhase.LANDED for agent in session.experiment.agents))
    assert world.positions()[:, 2].max() < 0.1


def test_nothing_flies_that_the_roll_call_of_fly_refuses(lockstep, api, until, tmp_path):
    session, world = lockstep(ONBOARD, "xyz", meant=ONBOARD.replace("[0.6, 0.0]", "[0.6, 1.5]"))
    client = api(session, tmp_path / "drawings")
    reason = r"right stands at \(0\.\d\d, -?0\.\d\d\), 1\.\d\d m from its start \(0\.60, 1\.50\)"
    for command in ({"name": "takeoff"}, {"name": "takeoff", "drones": ["right"]}, {"name": "mission"}):
        answer = client.command(**command)
        assert not answer["ok"]
        assert re.match(f"nothing flies: {reason}", answer["text"])
    first = session.ask(lambda: preflight(session)).result()[0]
    assert first["name"] == "roll call" and re.match(reason, first["text"])
    assert client.command(name="takeoff", drones=["left"])["ok"]
    until(lambda: session.frame.position[0, 2] > 0.5)
    assert session.ask(world.positions).result()[1, 2] < 0.1
    # one that has landed may stand anywhere
    client.command(name="goto", drones=["left"], x=-0.6, y=-0.8, z=0.8, duration=3.0)
    until(lambda: session.frame.position[0, 1] < -0.7)
    client.command(name="land", drones=["left"])
    until(lambda: session.experiment.agents[0].phase is DronePhase.LANDED)
    assert client.command(name="takeoff", drones=["left"])["ok"]


@pytest.mark.parametrize("gain", [250.0, 300.0], ids=["as_tested", "another_gain"])
def test_the_page_says_go_or_no_go_before_anything_flies(lockstep, gain):
    """What crazychoir preflight finds stands in the list, with the campaign's verdict, and is looked for once."""
    meant = ONBOARD + f"defaults: {{parameters: {{pid_rate.roll_kp: {gain}}}}}\n"
    session, _ = lockstep(ONBOARD, "xyz", meant=meant)
    session.experiment.backend.radio_parts = [([0, 1], session.experiment.backend)]
    session.tested = Check("campaign", False, "none was flown")
    checks = {one["name"]: one for one in session.ask(lambda: preflight(session)).result(120.0)}
    assert {"firmware", "parameters", "positioning", "links", "radio budget", "campaign", "roll call"} <= set(checks)
    assert checks["parameters"]["ok"] is (gain == 250.0), checks["parameters"]
    assert ("pid_rate.roll_kp" in checks["parameters"]["text"]) is (gain != 250.0)
    assert not checks["campaign"]["ok"]
    looked = session.radio_checks
    session.ask(lambda: preflight(session)).result(60.0)
    assert session.radio_checks is looked


def test_the_others_fly_when_one_cannot_be_uploaded(lockstep, api, until, tmp_path, monkeypatch):
    session, world = lockstep(ONBOARD, "xyz")
    client = api(session, tmp_path / "drawings")
    preview = draw_two(client)
    monkeypatch.setattr(session.access._drones[1].cf.mem, "get_mems", lambda kind: [])
    client.command(name="fly", preview=preview)
    until(lambda: session.flying is None)
    errors = [line.text for line in session.lines if line.kind == "error"]
    assert len(errors) == 1
    assert "is flown without right (udp://" in errors[0]
    assert "no trajectory memory" in errors[0]
    drones = session.experiment.agents
    assert all(agent.is_up for agent in drones)
    # the end of the circle, and where the other one waits: the begin of its own
    end = np.array([np.cos(1.6 * np.pi), np.sin(1.6 * np.pi)])
    assert np.linalg.norm(world.positions()[0, :2] - (CENTERS[0] + 0.3 * end)) < 0.1
    assert np.linalg.norm(world.positions()[1, :2] - (CENTERS[1] + np.array([0.3, 0.0]))) < 0.1


def test_what_a_link_cannot_switch_is_said(lockstep, api, until, tmp_path):
    session, world = lockstep(ONBOARD, "xyz")
    client = api(session, tmp_path / "drawings")
    assert client.get("/api/setting").json()["has_software"]
    # nothing is wrong with them
    assert client.command(name="reboot") == {"ok": True, "text": "REBOOT: all 2 drones; told that it may fly"}
    session.ask(world.drones[1].emergency_stop).result()
    until(lambda: world.drones[1].supervisor_state == "Locked")
    answer = client.command(name="reboot")
    assert not answer["ok"]
    assert answer["text"] == (
        "right: is locked, and over udp:// its power cannot be switched; start crazychoir serve again, or a real "
        "drone by its button"
    )


def test_a_real_drone_is_switched_off_and_on(lockstep, api, until, tmp_path, monkeypatch):
    from crazychoir_fw.flight.access import hardware

    session, _ = lockstep(ONBOARD, "xyz")
    client = api(session, tmp_path / "drawings")
    monkeypatch.setattr(hardware, "can_switch", lambda uri: True)
    goes_on, rebooted = threading.Event(), []

    def reboot():
        goes_on.wait(20.0)
        rebooted.append(True)
        raise StateError("the radio chip does not answer")

    monkeypatch.setattr(session.access._drones[0], "reboot", reboot)
    assert client.command(name="reboot", drones=["left"])["text"] == "REBOOT: left; back in about 10 s"
    assert session.access.state(0).failure == "restarting"
    assert "restarting already" in client.command(name="reboot", drones=["left"])["text"]
    goes_on.set()
    until(lambda: session.access.state(0).failure == "the radio chip does not answer")
    assert len(rebooted) == 1


def test_arming_over_the_radio(lockstep, api, until, tmp_path):
    session, world = lockstep(ONBOARD.replace("id: right,", "id: right, platform: cf21bl,"), "xyz")
    client = api(session, tmp_path / "drawings")
    drone = world.drones[1]
    until(lambda: drone.can_arm and "can be armed" in session.access.state(1).supervisor)
    assert not drone.can_fly
    assert client.command(name="arm", drones=["right"]) == {"ok": True, "text": "ARM: right"}
    until(lambda: drone.can_fly)
    assert client.command(name="arm", drones=["right"], armed=False)["text"] == "DISARM: right"
    until(lambda: not drone.can_fly)
    session.ask(drone.emergency_stop).result()
    until(lambda: "locked" in session.access.state(1).supervisor)
    assert client.command(name="arm", drones=["right"])["text"].startswith(
        "right: cannot be armed now, its supervisor says: locked"
    )


@pytest.mark.parametrize(
    ("pieces", "sentence"),
    [
        (np.ones((1, 32)), "allowed: \\(n, 33\\) with n from 1 to 31"),
        (np.ones((32, 33)), "n from 1 to 31"),
        (np.full((1, 33), np.nan), "finite"),
        (np.zeros((1, 33)), "longer than 0 s"),
    ],
)
def test_pieces_that_are_none_are_refused(pieces, sentence):
    from crazychoir_fw.common.errors import RangeError
    from crazychoir_fw.radio.uploads import checked_pieces

    with pytest.raises(RangeError, match=sentence):
        checked_pieces("cf1", pieces)


def test_uri_base_flies_a_served_swarm(serve, tmp_path, until):
    """What `crazychoir gui --backend hardware --uri-base` does, in the time of the clock on the wall."""
    import httpx

    path = mission_file(tmp_path, ONBOARD)
    world = World([DroneConfig(**drone_settings(drone)) for drone in open_mission(path).fleet], seed=4, visuals=False)
    port = free_ports(2)
    with world.serve(port=port, speed=4.0) as server:
        thread = threading.Thread(target=server.run, daemon=True)
        thread.start()
        mission = open_mission(path, f"udp://127.0.0.1:{port}", backend="hardware")
        assert [drone.uri for drone in mission.fleet] == [f"udp://127.0.0.1:{port + k}" for k in range(2)]
        with Session(mission) as session:
            session.wait_until_ready()
            assert isinstance(session.access, HardwareAccess)
            page = serve(session, tmp_path / "drawings")
            with httpx.Client(base_url=page.address, timeout=40.0) as client:

                def press(**command):
                    return client.post("/api/command", json={"id": uuid.uuid4().hex, "command": command}).json()

                def tell():
                    return [
                        list(session.lines),
                        *((drone.mode, drone.latest) for drone in session.access.backend.handler),
                    ]

                assert client.get("/api/setting").json()["is_real_time"]
                assert press(name="speed", factor=2.0)["text"] == "the time of real drones goes on by itself"
                assert press(name="takeoff") == {"ok": True, "text": "TAKE-OFF: all 2 drones"}
                until(lambda: world.positions()[:, 2].min() > 0.4, tell=tell)
                assert press(name="goto", drones=["right"], x=0.9, y=0.4, z=0.7, duration=1.0)["ok"]
                until(lambda: np.linalg.norm(world.positions()[1] - (0.9, 0.4, 0.7)) < 0.1, tell=tell)
                assert abs(world.positions()[0, 0] + 0.6) < 0.1
                assert press(name="set_parameter", parameter="posCtlPid.xKp", value=1.75)["ok"]
                # a radio confirms at once, and writes between two steps
                until(lambda: [drone.param["posCtlPid.xKp"] for drone in world.drones] == [1.75, 1.75])
                assert press(name="land")["ok"]
                until(lambda: not any(agent.is_up for agent in session.experiment.agents), tell=tell)
                assert world.positions()[:, 2].max() < 0.1
        server.stop()
        thread.join(20.0)
