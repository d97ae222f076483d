"""`crazychoir run` on the example's model, and on what is none."""

import re
import sys
from contextlib import nullcontext
from pathlib import Path

import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app

MODEL = Path(__file__).parents[2] / "examples" / "motor_ctrl" / "drones.xml"


def run(*words):
    return CliRunner().invoke(app, ["run", *map(str, words)])


def test_drones_of_a_model_fly_themselves():
    result = run(MODEL, "--seconds", "2.5", "--seed", "3")
    assert result.exit_code == 0, result.output
    assert "cf1: Ready to fly at 0.00, 0.00, 0.01 m, flown by MotorCtrlXYZ" in result.output
    assert "cf2: Flying" in result.output
    assert "flown by Bounce" in result.output


def test_air_that_counts_twice_and_a_floor_that_is_missing_are_told(tmp_path):
    (tmp_path / "bounce.py").write_text((MODEL.parent / "bounce.py").read_text())
    text = MODEL.read_text()
    model = tmp_path / "model.xml"
    model.write_text(re.sub(r"<geom name=.floor.*/>", "", text).replace("<option ", '<option density="1.2" '))
    result = run(model, "--seconds", "0")
    assert result.exit_code == 0, result.output
    told = " ".join(result.output.split())
    assert 'Note: <option density="1.2">: MuJoCo adds a drag of its own to that of the Crazyflies' in told
    assert "Note: nothing is below cf1, cf2: they fall without end" in told
    assert "Note" not in run(MODEL, "--seconds", "0").output


def test_a_class_that_raises_is_told_and_fails_the_run(tmp_path):
    (tmp_path / "bad.py").write_text(
        "from crazychoir_fw.simulation import MotorCtrl\nclass Bad(MotorCtrl):\n    def step(self): 1 / 0\n"
    )
    model = tmp_path / "model.xml"
    model.write_text(MODEL.read_text().replace("bounce.py:Bounce", "bad.py:Bad"))
    result = run(model, "--seconds", "0.5")
    assert result.exit_code == 1
    assert "cf2: its motor control failed: Bad: ZeroDivisionError: division by zero (bad.py:3)" in result.output


@pytest.mark.parametrize(("words", "way"), [(["--view"], "auto"), (["--view", "web"], "web")])
def test_a_run_can_be_watched(monkeypatch, words, way):
    opened, shown = [], []
    observer = nullcontext(lambda world, progress: shown.append(progress.sim_seconds))
    monkeypatch.setattr(
        sys.modules["crazychoir_fw.cli.run"], "open_view", lambda way, say: opened.append(way) or observer
    )
    result = run(*words, MODEL, "--seconds", "0.05")
    assert result.exit_code == 0, result.output
    assert opened == [way]
    assert shown == [0.0, 0.02, 0.04, 0.05]


def test_a_run_is_watched_on_a_page_without_a_display(monkeypatch):
    pytest.importorskip("nicegui")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr("crazychoir_fw.cli.view_web._wait_for_somebody", lambda live, patience_s: None)
    result = run(MODEL, "--seconds", "0.1", "--view")
    assert result.exit_code == 0, result.output
    assert "Watch at http://127.0.0.1:" in result.output


@pytest.mark.parametrize(
    "words", [("nothing.xml",), (__file__,), (MODEL, "--seconds", "-1"), (MODEL, "--view=hologram")]
)
def test_what_cannot_be_run_is_refused(words):
    result = run(*words)
    assert result.exit_code == 2
    assert "Traceback" not in result.output
