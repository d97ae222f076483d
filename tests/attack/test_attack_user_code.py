"""`sys.exit`, and worse, in a user's code: one sentence with file and line, an exit code as documented."""

import pytest
import yaml
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.recording import plot

LAW = """
import sys
from crazychoir_fw.control import PositionCtrlStrategy
from crazychoir_fw.guidance import CFGuidance
from crazychoir_fw.simulation.motor_ctrl import MotorCtrl

class Law(CFGuidance):
    def __init__(self, **known):
        super().__init__(**known)
        AT_MAKING
    def step(self, now):
        AT_FLYING

class Control(PositionCtrlStrategy):
    def __init__(self, **known):
        super().__init__()
        AT_MAKING
    def control(self, *_):
        AT_FLYING

class Motors(MotorCtrl):
    def init(self, *_):
        AT_MAKING
    def step(self, *_):
        AT_FLYING
AT_IMPORT
"""


def mission(kind):
    told = {"drones": [{"id": "agent_0", "position": [0, 0]}, {"id": "agent_1", "position": [1, 0]}]}
    if kind == "motor_ctrl":
        told["drones"][0]["motor_ctrl"] = "law.py:Motors"
        return {**told, "flight": [{"hover": {"duration": 0.2, "drones": ["agent_1"]}}]}
    guidance = "law.py:Law" if kind == "guidance" else "SimpleGuidance"
    control = {"position": "law.py:Control"} if kind == "control" else {}
    layers = {"guidance": {"class": guidance}, "planning": {"class": "Spline"}, "control": control}
    return {**told, "backend": "integrator", "layers": layers, "flight": [{"takeoff": {"duration": 0.3}}]}


@pytest.mark.parametrize("what", ["sys.exit(0)", "sys.exit('a\\nb')", "raise MemoryError"])
@pytest.mark.parametrize("when", ["IMPORT", "MAKING", "FLYING"])
@pytest.mark.parametrize("kind", ["guidance", "control", "motor_ctrl"])
def test_an_exit_in_user_code_is_a_mistake_as_every_other(tmp_path, monkeypatch, kind, when, what):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(plot, "plot_flight", lambda *_: None)
    text = LAW.replace(f"AT_{when}", what)
    for other in ("IMPORT", "MAKING", "FLYING"):
        text = text.replace(f"AT_{other}", "pass")
    (tmp_path / "law.py").write_text(text)
    (tmp_path / "mission.yaml").write_text(yaml.safe_dump(mission(kind)))
    flown = CliRunner().invoke(app, ["fly", "mission.yaml", "--no-video", "--out", "out"])
    error = {"s": "SystemExit", "r": what.removeprefix("raise ")}[what[0]]
    said = [line for line in flown.stderr.splitlines() if error in line]
    assert flown.exception is None or isinstance(flown.exception, SystemExit), flown.exception
    assert flown.exit_code == (1 if when == "FLYING" else 2), flown.output
    assert said
    assert "law.py:" in said[0]
    assert "Traceback" not in flown.output
