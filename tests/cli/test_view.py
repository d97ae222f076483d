"""`crazychoir fly --view`: what is opened where, and what is seen."""

import contextlib
import os
import shutil
import socket
import subprocess
import sys
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
def test_a_page_without_viser_is_one_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    with (
        pytest.raises(CrazychoirError, match=r"the page needs viser: run pip install 'crazychoir-fw\[viz\]'"),
        view.open_view("auto", print),
    ):
        pass


def test_a_camera_that_is_not_there_is_one_sentence(hop, tmp_path):
    from crazychoir_fw.recording.video import rendering_available

    if reason := rendering_available():
        pytest.skip(reason)
    result = run("fly", hop, "--camera", "fpv:cf7", "--out", tmp_path)
    assert result.exit_code == 2
    assert result.stderr == "--camera: no drone 'cf7' for the camera; there are cf1, cf2\n"


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
    """A screen that nobody looks at."""
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


@pytest.fixture
def viser():
    return pytest.importorskip("viser", reason="viser is not installed (pip install 'crazychoir-fw[viz]')")


def test_the_page_is_on_this_machine_only(viser, monkeypatch):
    from crazychoir_fw.cli import view_web

    servers = []
    monkeypatch.setattr(view_web, "_wait_for_somebody", lambda server, _: servers.append(server))
    world, said = swarm(2), []
    with view_web.open_page(said.append) as show:
        show(world, Progress(0.0, 1.0, 0.0))
        show(world, Progress(0.05, 1.0, 0.0))
        port = servers[0].get_port()
        assert said == [
            f"Watch at http://127.0.0.1:{port}/ (this machine only); "
            "the flight begins when the page is open, or in 60 s"
        ]
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=10) as answer:
            assert b"<html" in answer.read().lower()
        # a server on all interfaces would answer on every address of the loopback
        with pytest.raises(OSError), socket.create_connection(("127.0.0.2", port), timeout=2):
            pass


def test_the_page_prints_one_line(viser, monkeypatch, capfd):
    from crazychoir_fw.cli import view_web

    with view_web.open_page(print, patience_s=0.0) as show:
        show(swarm(1), Progress(0.0, 1.0, 0.0))
    assert capfd.readouterr().out.count("\n") == 1


def test_a_browser_watches(viser, tmp_path):
    """The flight waits for the page, and goes on when it is closed."""
    from crazychoir_fw.cli import view_web

    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if chromium is None:
        pytest.skip("Chromium is not installed (Debian: apt install chromium)")
    browsers = []

    def browse(line: str) -> None:
        address = line.split()[2]
        # root has no sandbox
        options = ["--headless=new", "--no-sandbox", "--disable-gpu-sandbox", f"--user-data-dir={tmp_path}", address]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        browsers.append(subprocess.Popen([chromium, *options], **quiet))

    world, seen = swarm(2), []
    real = view_web._wait_for_somebody

    def wait(server, patience_s):
        real(server, patience_s)
        seen.append(len(server.get_clients()))

    try:
        with pytest.MonkeyPatch.context() as patch, view_web.open_page(browse, patience_s=60.0) as show:
            patch.setattr(view_web, "_wait_for_somebody", wait)
            show(world, Progress(0.0, 1.0, 0.0))
            browsers[0].terminate()
            browsers[0].wait()
            show(world, Progress(0.1, 1.0, 0.0))
    finally:
        for browser in browsers:
            browser.kill()
            browser.wait()
    assert seen == [1]


def test_drones_are_drawn_in_batches_with_their_colors(viser):
    from crazychoir_fw.cli.web_scene import body_mesh, drone_batches

    world = World([DroneConfig("cf1"), DroneConfig("cf2", (1.0, 0.0)), DroneConfig("bl", platform="cf21bl")])
    model = world.model
    batches = drone_batches(model, [model.body(drone.id).id for drone in world.drones])
    assert sorted(drone for batch in batches for drone in batch.drones) == [0, 0, 1, 1, 2, 2]
    own = [batch.colors for batch in batches if batch.colors is not None and len(batch.drones) == 2]
    assert len(own) == 1 and not np.array_equal(own[0][0], own[0][1])
    for batch in batches:
        # a Crazyflie is a hand wide, and its body is its middle
        assert 0.05 < np.ptp(batch.mesh.vertices, axis=0).max() < 0.2
        assert np.abs(batch.mesh.bounds.mean(axis=0)).max() < 0.03
    floor = body_mesh(model, 0)
    assert floor.bounds[1, 2] == pytest.approx(0.0, abs=1e-3) and np.ptp(floor.bounds[:, 0]) == 40.0


@pytest.mark.parametrize(
    ("kind", "size", "extent"),
    [
        ("box", "0.1 0.2 0.3", (0.2, 0.4, 0.6)),
        ("sphere", "0.1", (0.2, 0.2, 0.2)),
        ("ellipsoid", "0.1 0.2 0.3", (0.2, 0.4, 0.6)),
        ("cylinder", "0.1 0.3", (0.2, 0.2, 0.6)),
        ("capsule", "0.1 0.3", (0.2, 0.2, 0.8)),
        ("plane", "0.1 0.3 1", (0.2, 0.6, 0.0002)),
    ],
)
def test_shapes_have_the_size_and_place_of_their_geom(viser, kind, size, extent):
    from crazychoir_fw.cli.web_scene import body_mesh

    xml = f'<mujoco><worldbody><geom type="{kind}" size="{size}" pos="1 2 3" rgba="1 0 0 1"/></worldbody></mujoco>'
    mesh = body_mesh(mujoco.MjModel.from_xml_string(xml), 0)
    np.testing.assert_allclose(np.ptp(mesh.bounds, axis=0), extent, atol=2e-3)
    np.testing.assert_allclose(mesh.bounds.mean(axis=0), [1, 2, 3], atol=2e-3)
    assert mesh.visual.vertex_colors[0].tolist() == [255, 0, 0, 255]
