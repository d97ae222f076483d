"""`crazychoir fly --view`: what is opened where, and what is seen."""

import contextlib
import os
import queue
import shutil
import socket
import subprocess
import sys
import threading
import types
import urllib.request

import mujoco
import numpy as np
import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app, view
from crazychoir_fw.cli.pace import FramePacer
from crazychoir_fw.common.errors import CrazychoirError, StateError
from crazychoir_fw.flight.engine import Progress
from crazychoir_fw.simulation import DroneConfig, World

HOP = "drones: {count: 2}\nflight: [{takeoff: {height: 0.3, duration: 1}}, {land: {duration: 1}}]\n"


@pytest.fixture
def hop(tmp_path):
    path = tmp_path / "hop.yaml"
    path.write_text(HOP)
    return path


@pytest.fixture
def no_display(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


# ---------------------------------------------------------------- the option


@pytest.mark.parametrize(
    ("words", "way"),
    [
        (["--view"], "auto"),
        (["--view", "native"], "native"),
        (["--view", "web"], "web"),
        (["--view=web"], "web"),
        (["--view", "--no-video"], "auto"),
        ([], None),
    ],
)
@pytest.mark.parametrize("mission_is_last", [False, True])
def test_the_way_may_be_left_out(monkeypatch, hop, words, way, mission_is_last):
    requests = []
    monkeypatch.setattr(sys.modules["crazychoir_fw.cli.fly"], "attempt", lambda request: requests.append(request) or 0)
    result = run("fly", *([*words, hop] if mission_is_last else [hop, *words]))
    assert result.exit_code == 0, result.output
    assert (requests[0].view, requests[0].mission) == (way, hop)


@pytest.mark.parametrize("words", [["--view=cinema"], ["--view", "cinema"]])
def test_an_unknown_way_is_refused(hop, words):
    for arguments in ([hop, *words], [*words, hop]):
        result = run("fly", *arguments)
        assert result.exit_code == 2
        assert result.stderr == "--view is 'cinema', allowed: auto, native, web, or nothing\n"


@pytest.mark.usefixtures("no_display")
@pytest.mark.skipif(sys.platform != "linux", reason="displays are asked for by environment variables on Linux")
def test_a_window_without_a_display_is_one_sentence(hop, tmp_path):
    result = run("fly", hop, "--view", "native", "--no-video", "--out", tmp_path)
    assert result.exit_code == 2
    assert result.stderr == "--view native: there is no display; --view web shows the flight in a browser\n"


@pytest.mark.skipif(sys.platform != "linux", reason="X11 displays")
def test_a_display_that_does_not_answer_is_none(monkeypatch):
    pytest.importorskip("glfw")
    monkeypatch.setenv("DISPLAY", ":987")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert view.no_window_because().startswith("no window can be opened (")


@pytest.mark.usefixtures("no_display")
def test_a_page_without_nicegui_is_one_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "nicegui", None)
    with (
        pytest.raises(CrazychoirError, match=r"the page needs NiceGUI: run pip install 'crazychoir-fw\[gui\]'"),
        view.open_view("auto", print),
    ):
        pass


def test_a_camera_that_is_not_there_is_one_sentence(hop, tmp_path):
    from crazychoir_fw.recording.opengl import rendering_available

    if reason := rendering_available():
        pytest.skip(reason)
    result = run("fly", hop, "--camera", "fpv:cf7", "--out", tmp_path)
    assert result.exit_code == 2
    assert result.stderr == "no drone 'cf7' for the camera; there are cf1, cf2\n"


def test_the_pace_is_that_of_the_clock(monkeypatch):
    now, slept = [100.0], []
    clock = types.SimpleNamespace(perf_counter=lambda: now[0], sleep=slept.append)
    monkeypatch.setattr("crazychoir_fw.cli.pace.time", clock)
    pace = FramePacer(0.1)
    assert [pace.is_frame(t) for t in (0.0, 0.05, 0.1, 0.12, 0.31)] == [True, False, True, False, True]
    pace.wait(0.5)
    now[0] += 1.0
    pace.wait(1.75)
    pace.wait(1.25)  # late already
    assert slept == pytest.approx([0.0, 0.25, 0.0])


# ---------------------------------------------------------------- the window


def swarm(count: int) -> World:
    drones = [DroneConfig(f"cf{k}", (0.4 * (k % 10), 0.4 * (k // 10), 1.0)) for k in range(count)]
    return World(drones, visuals=count < 10)


def test_the_overlay_has_trails_ghosts_and_names_that_keys_switch():
    from crazychoir_fw.cli.view_native import Overlay, Switches

    world, switches = swarm(2), Switches()
    scene = mujoco.MjvScene(world.model, maxgeom=10000)
    overlay = Overlay(world, scene, switches)
    overlay.draw()
    everything = scene.ngeom
    assert {scene.geoms[2].label, scene.geoms[3].label} == {"cf0", "cf1"}
    lines = range(4, everything)
    start = world.positions()
    for _ in range(3):
        world["cf0"].place(world["cf0"].true_position + np.array([0.1, 0.0, 0.0]))
        world.data.time += 1.0
        overlay.draw()
    reach = max(scene.geoms[k].size[2] for k in lines)  # length of a line
    assert reach == pytest.approx(0.1, abs=1e-3)
    assert np.linalg.norm(world.positions()[0] - start[0]) == pytest.approx(0.3, abs=1e-6)
    switches.press(ord("T"))
    switches.press(ord("N"))
    overlay.draw()
    assert scene.ngeom == 4
    assert scene.geoms[2].label == ""


@pytest.mark.parametrize("count", [1, 100])
def test_a_large_swarm_has_a_bounded_overlay(count):
    from crazychoir_fw.cli.view_native import Overlay, Switches

    world = swarm(count)
    scene = mujoco.MjvScene(world.model, maxgeom=10000)
    Overlay(world, scene, Switches()).draw()
    assert 3 * count <= scene.ngeom <= 1500 + 2 * count


def test_closing_the_window_ends_the_flight(monkeypatch):
    viewer_module = pytest.importorskip("mujoco.viewer")
    from crazychoir_fw.cli.view_native import open_window

    world = swarm(1)

    class Window:
        is_open = True
        cam, user_scn = mujoco.MjvCamera(), mujoco.MjvScene(world.model, maxgeom=1000)
        lock = staticmethod(contextlib.nullcontext)
        sync = close = staticmethod(lambda: None)
        is_running = staticmethod(lambda: Window.is_open)

    monkeypatch.setattr(viewer_module, "launch_passive", lambda *_, **__: Window)
    said = []
    with open_window(said.append) as show:
        show(world, Progress(0.0, 1.0, 0.0))
        Window.is_open = False
        with pytest.raises(StateError, match="the window was closed before the end of the flight"):
            show(world, Progress(0.01, 1.0, 0.0))
    assert len(said) == 1 and "MuJoCo's window is open" in said[0]


@pytest.fixture
def screen():
    """Start a virtual X display (Xvfb)."""
    if shutil.which("Xvfb") is None:
        pytest.skip("Xvfb is not installed (Debian: apt install xvfb)")
    read, write = os.pipe()
    command = ["Xvfb", "-displayfd", str(write), "-screen", "0", "640x480x24", "-nolisten", "tcp"]
    server = subprocess.Popen(command, pass_fds=[write], stderr=subprocess.DEVNULL)
    os.close(write)
    with os.fdopen(read) as answer:
        number = answer.readline().strip()
    try:
        if not number:
            pytest.skip("Xvfb does not start here")
        yield f":{number}"
    finally:
        server.terminate()
        server.wait()


SHOW = """
from crazychoir_fw.cli.view import open_view
from crazychoir_fw.flight.engine import Progress
from crazychoir_fw.simulation import DroneConfig, World

world = World([DroneConfig("cf1"), DroneConfig("cf2", (0.5, 0.0))])
with open_view("auto", print) as show:
    for sample in range(5):
        world.step(10)
        show(world, Progress(world.time, 1.0, 0.0))
print("flown")
"""


def test_a_flight_is_shown_in_a_window(screen):
    # in a process of its own, because a library of windows remembers the first display that it meets
    environment = {**os.environ, "DISPLAY": screen}
    environment.pop("WAYLAND_DISPLAY", None)
    done = subprocess.run([sys.executable, "-c", SHOW], env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    opened, flown = done.stdout.splitlines()
    assert opened.startswith("MuJoCo's window is open") and flown == "flown"


# ---------------------------------------------------------------- the page


def test_the_page_is_on_this_machine_only(monkeypatch, capfd):
    from crazychoir_fw.cli import view_web

    monkeypatch.setattr(view_web, "_wait_for_somebody", lambda live, patience_s: None)
    world, said = swarm(2), []
    with view_web.open_page(said.append) as show:
        show(world, Progress(0.0, 1.0, 0.0))
        show(world, Progress(0.07, 1.0, 0.0))
        port = int(said[0].split("/")[2].rpartition(":")[2])
        assert said == [
            f"Watch at http://127.0.0.1:{port}/ (this machine only); "
            "the flight begins when the page is open, or in 60 s"
        ]
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=60) as answer:
            assert b"<html" in answer.read().lower()
        # a server on all interfaces would answer on every address of the loopback
        with pytest.raises(OSError), socket.create_connection(("127.0.0.2", port), timeout=2):
            pass
    assert capfd.readouterr().out == ""


def test_a_browser_watches():
    """The flight waits for the page, shows what moves, takes no commands, and says when it is over."""
    from playwright.sync_api import sync_playwright

    from crazychoir_fw.cli import view_web

    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if chromium is None:
        pytest.skip("Chromium is not installed (Debian: apt install chromium)")
    world = swarm(2)
    told, requests, errors = queue.Queue(), [], []
    is_seen, is_over = threading.Event(), threading.Event()

    def browse():
        with sync_playwright() as driver:
            options = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
            page = driver.chromium.launch(executable_path=chromium, args=options).new_page()
            page.on("request", lambda request: requests.append(request.url))
            page.on("pageerror", lambda error: errors.append(str(error)))
            address = told.get(timeout=60.0)
            page.goto(address, timeout=90_000)
            page.wait_for_function("window.cc && cc.frame && cc.setting && cc.frame.time > 0", timeout=90_000)
            page.keyboard.press("Escape")
            page.keyboard.press("t")
            names, frame = page.evaluate("[cc.setting.names, cc.frame]")
            page.get_by_text("follow").click(timeout=90_000)
            told.put((names, frame["drones"][1]["position"], page.get_by_test_id("view").count()))
            is_seen.set()
            page.get_by_text("The flight is over.").wait_for(timeout=90_000)
            is_over.set()

    thread = threading.Thread(target=browse)
    with view_web.open_page(lambda line: told.put(line.split()[2])) as show:
        thread.start()
        while not is_seen.is_set():
            show(world, Progress(world.time, 1.0, 0.0))
            world.step(10)
    thread.join(90.0)
    assert is_over.is_set()
    names, position, views = told.get_nowait()
    assert (names, views, errors) == (["cf0", "cf1"], 1, [])
    np.testing.assert_allclose(position[:2], [0.4, 0.0], atol=1e-6)
    assert 0.0 < position[2] <= 1.0  # it falls
    assert not [url for url in requests if "/api/command" in url or "127.0.0.1" not in url]


ROOM = """<mujoco>
  <asset>
    <texture name="half" type="2d" builtin="flat" rgb1="1 0 0" width="2" height="2"/>
    <material name="cloth" texture="half" rgba="0.5 1 1 1"/>
    <mesh name="wedge" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>
  </asset>
  <worldbody>
    <geom type="plane" size="0 0 1"/>
    <geom type="box" size="1 1 1" group="3"/>
    <geom type="box" size="1 1 1" rgba="1 1 1 0"/>
    <geom type="ellipsoid" size="0.1 0.2 0.3" pos="1 2 3" rgba="0 1 0 0.5"/>
    <geom type="plane" size="0.1 0.3 1" material="cloth"/>
    <body pos="0 0 1"><geom type="mesh" mesh="wedge"/></body>
    <body name="ball" pos="4 5 6" euler="0 0 180">
      <freejoint/><geom type="sphere" size="0.1" pos="0 0 0.5"/><geom type="capsule" size="0.1 0.2"/>
    </body>
  </worldbody>
</mujoco>"""


def test_the_room_is_shown_with_shapes_colors_and_what_moves():
    from crazychoir_fw.gui.room import Room

    model = mujoco.MjModel.from_xml_string(ROOM)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    room = Room(types.SimpleNamespace(model=model, data=data))
    shapes = [thing["shape"] for thing in room.things]
    assert shapes == ["ellipsoid", "plane", "mesh", "sphere", "capsule"]
    ellipsoid, plane, mesh, sphere, _ = room.things
    assert (ellipsoid["size"], ellipsoid["position"], ellipsoid["color"]) == (
        [0.1, 0.2, 0.3],
        [1, 2, 3],
        [0, 1, 0, 0.5],
    )
    assert (plane["size"][:2], plane["color"]) == ([0.1, 0.3], [0.5, 0.0, 0.0, 1.0])
    corners = np.array(mesh["corners"]).reshape(-1, 3)
    assert len(corners) == 4 * 3
    turn = np.zeros(9)  # MuJoCo turns meshes to their principal axes
    mujoco.mju_quat2Mat(turn, mesh["quat"])
    placed = corners @ turn.reshape(3, 3).T + mesh["position"]
    np.testing.assert_allclose([placed.min(axis=0), placed.max(axis=0)], [[0, 0, 1], [1, 1, 2]], atol=1e-3)
    assert [thing["body"] for thing in room.things] == [None, None, None, 0, 0]
    assert sphere["position"] == [0.0, 0.0, 0.5]
    data.qpos[:3] = 7.0, 8.0, 9.0
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(room.poses(), [[7, 8, 9, 0, 0, 1, 0]], atol=1e-12)


def test_an_empty_room_has_nothing():
    from crazychoir_fw.gui.room import Room

    assert Room(None).things == [] and Room(None).poses().shape == (0, 7)
