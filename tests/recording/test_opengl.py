import os
import subprocess
import sys

import mujoco
import numpy as np
import pytest

from crazychoir_fw.recording.gl_contexts import opens_display
from crazychoir_fw.recording.opengl import rendering_available
from crazychoir_fw.recording.renderer import Renderer

ASK = "from crazychoir_fw.recording.opengl import rendering_available; print(rendering_available())"
BROKEN = """
import ctypes
real = ctypes.CDLL
def refuse(name, *rest, **more):
    if name and any(part in str(name) for part in ("EGL", "OSMesa")):
        raise OSError(f"{name}: cannot open shared object file")
    return real(name, *rest, **more)
ctypes.CDLL = refuse
"""


def ask(code: str, **environment: str) -> subprocess.CompletedProcess:
    """Run *code* in a fresh Python that has no screen."""
    hidden = ("MUJOCO_GL", "PYOPENGL_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY")
    keep = {key: value for key, value in os.environ.items() if key not in hidden}
    command = [sys.executable, "-c", code]
    return subprocess.run(command, env=keep | environment, capture_output=True, text=True, check=True)


def test_the_answer_is_none_or_one_line():
    answer = rendering_available()
    assert answer is None or ("\n" not in answer and answer.startswith("no rendering: "))
    assert rendering_available() == answer


def test_asking_prints_nothing():
    answer = ask(ASK)
    assert answer.stderr == ""
    assert len(answer.stdout.splitlines()) == 1


@pytest.mark.parametrize("value", ["off", "disable", "0", "FALSE"])
def test_drawing_can_be_forbidden(value):
    answer = ask(ASK, MUJOCO_GL=value)
    assert answer.stdout.strip() == f"no rendering: MUJOCO_GL={value.lower()}"
    assert answer.stderr == ""


def test_without_libraries_the_packages_to_install_are_named():
    answer = ask(BROKEN + ASK)
    assert answer.stderr == ""
    assert answer.stdout.startswith("no rendering: egl: ")
    assert "apt install libegl1 libgl1" in answer.stdout
    assert "apt install libosmesa6" in answer.stdout
    assert "glfw: there is no screen" in answer.stdout
    assert len(answer.stdout.splitlines()) == 1


def test_a_window_without_a_screen_is_refused_quietly():
    answer = ask(ASK, MUJOCO_GL="glfw")
    assert answer.stdout.strip() == "no rendering: glfw: there is no screen"
    assert answer.stderr == ""


@pytest.mark.parametrize(
    ("value", "says"),
    [
        ("osmesa", "osmesa: libOSMesa is not installed"),
        ("egl", "egl: libEGL"),
        ("foo", "MUJOCO_GL is foo, allowed: egl"),
    ],
)
def test_a_missing_library_of_mujoco_gl_is_one_sentence_when_something_is_drawn(value, says):
    answer = ask(BROKEN + ASK, MUJOCO_GL=value)
    assert answer.stdout.startswith("no rendering: " + says)
    assert answer.stderr == ""


@pytest.mark.parametrize("way", ["", "egl"])
def test_pictures_need_no_pyopengl(way):
    if not str(rendering_available()).startswith("None"):
        pytest.skip(rendering_available())
    answer = ask("import sys; sys.modules['OpenGL'] = None; import crazychoir_fw, mujoco; " + ASK, MUJOCO_GL=way)
    assert (answer.stdout, answer.stderr) == ("None\n", "")


def test_a_graphics_card_that_is_not_there_is_named():
    if not opens_display():
        pytest.skip("no EGL")
    answer = ask(ASK, MUJOCO_GL="egl", MUJOCO_EGL_DEVICE_ID="31")
    assert answer.stdout.startswith("no rendering: egl: MUJOCO_EGL_DEVICE_ID is 31, allowed: 0 to ")
    assert answer.stderr == ""


def test_pictures_show_the_scene(two_drones, drawing):
    data = mujoco.MjData(two_drones)
    mujoco.mj_forward(two_drones, data)
    camera = mujoco.MjvCamera()
    camera.lookat[:], camera.distance, camera.azimuth, camera.elevation = [0, 0, 1], 0.9, 90.0, -50.0
    with drawing, Renderer(two_drones, 320, 200) as renderer:
        renderer.update(data, camera)
        picture = renderer.draw().astype(int)
        assert picture.shape == (200, 320, 3)
        red = picture[..., 0] - picture[..., 2] > 100
        blue = picture[..., 2] - picture[..., 0] > 100
        assert red.sum() > 20 and blue.sum() > 20
        # azimuth 90 looks along +y: +x is on the right
        assert np.argwhere(red)[:, 1].mean() > 160 > np.argwhere(blue)[:, 1].mean()


def test_several_renderers_draw_in_turn(two_drones, drawing):
    data = mujoco.MjData(two_drones)
    mujoco.mj_forward(two_drones, data)
    camera = mujoco.MjvCamera()
    camera.distance = 2.0
    with drawing, Renderer(two_drones, 64, 48) as one, Renderer(two_drones, 80, 60) as two:
        for renderer in (one, two):
            renderer.update(data, camera)
        first = one.draw().copy()
        assert two.draw().shape == (60, 80, 3)
        np.testing.assert_array_equal(one.draw(), first)


def test_a_renderer_leaves_the_model_as_it_was(two_drones, drawing):
    size = two_drones.vis.global_
    before = size.offwidth, size.offheight
    with drawing, Renderer(two_drones, 64, 48) as renderer:
        renderer.close()
    assert (size.offwidth, size.offheight) == before
