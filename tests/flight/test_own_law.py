"""A law of one file, examples/new_law: it flies everywhere, and is validated, judged and drawn by what it says."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.flight.agents import make_controller, make_safety_filter
from crazychoir_fw.flight.engine import fly
from crazychoir_fw.mission import load_mission, registry
from crazychoir_fw.mission.loader import parse_mission

EXAMPLE = Path(__file__).parents[2] / "examples" / "new_law"
TRIANGLE = 0.6 / np.sqrt(3)  # from the middle to each of three that are `gap` apart [m]


def data(**guidance):
    text = yaml.safe_load((EXAMPLE / "mission.yaml").read_text())
    text["layers"]["guidance"] |= guidance
    return {**text, "name": "meet"}


def mission(text, **options):
    return parse_mission(text, folder=EXAMPLE, **options)


def check(result):
    assert result.success, result.failures
    verdict = result.summary["criteria"][0]
    assert verdict["criterion"] == "meeting_m"
    assert verdict["value"] == pytest.approx(TRIANGLE, abs=0.03)


@pytest.mark.parametrize("backend", ["sim", "integrator"])
def test_it_flies_and_is_judged_and_drawn(backend):
    result = fly(mission(data(), backend=backend), visuals=False)
    check(result)
    curve = result.curve
    assert (curve.label, curve.limit) == ("distance from the middle (m)", 0.45)
    assert np.nanmax(curve.mean) > 0.9
    assert curve.mean[np.isfinite(curve.mean)][-1] == pytest.approx(TRIANGLE, abs=0.03)
    (mark,) = curve.marks
    np.testing.assert_allclose(mark.position[:2], [1.0, 1.6 / 3], atol=0.1)


def test_it_flies_over_the_radio(tmp_path):
    pytest.importorskip("cflib")
    from served_drones import Served

    flown = mission(data())
    check(fly(flown, backend=Served(flown, tmp_path)))


def test_an_installed_package_offers_it_by_its_name(tmp_path, monkeypatch):
    shutil.copy(EXAMPLE / "rendezvous.py", tmp_path / "meeting_laws.py")
    info = tmp_path / "meeting_laws-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: meeting-laws\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[crazychoir.guidance]\nMeeting = meeting_laws:Rendezvous\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    registry.installed_names.cache_clear()
    try:
        text = data(**{"class": "Meeting"})
        text["flight"] = [{"takeoff": {"duration": 2}}, {"start": {"duration": 5}}]
        check(fly(mission(text, backend="integrator")))
        with pytest.raises(MissionError, match="did you mean 'Meeting'"):
            mission(data(**{"class": "Meting"}))
    finally:
        registry.installed_names.cache_clear()


def test_a_limit_that_is_not_met_fails_the_flight(tmp_path):
    text = data()
    text["criteria"] = {"meeting_m": 0.1}
    text["flight"] = [{"start": {"duration": 1}}]
    text["layers"]["guidance"]["class"] = f"{EXAMPLE / 'rendezvous.py'}:Rendezvous"
    (tmp_path / "mission.yaml").write_text(yaml.safe_dump(text))
    command = ["fly", str(tmp_path / "mission.yaml"), "--no-video", "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(app, [*command, "--backend", "integrator"])
    assert result.exit_code == 1
    (failure,) = json.loads((tmp_path / "out" / "summary.json").read_text())["failures"]
    assert "m from the middle of all, allowed: 0.1 m" in failure


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("layers.guidance.options", {"gap": -1.0}, r"layers.guidance.options: gap is -1.0, allowed: above 0 m"),
        ("layers.guidance.options", {"pul": 1.0}, "has no key 'pul' .did you mean 'pull'"),
        ("layers.guidance.goals", {"agent_0": [[1, 0, 0, 1]]}, "goals are for the class GoToGuidance"),
        ("layers.communication.graph", [], "layers.communication.graph is missing: .*Rendezvous needs"),
        ("criteria.meeting_m", -1, "criteria.meeting_m is -1, but must be a number in .0, 1000. m"),
        ("criteria.meting_m", 1, "did you mean 'meeting_m'"),
        ("criteria.routes_gap", 1, "criteria.routes_gap needs layers.delivery"),
    ],
)
def test_its_missions_are_validated(path, value, said):
    text = data()
    section = text
    *keys, last = path.split(".")
    for key in keys:
        section = section[key]
    section[last] = value
    with pytest.raises(MissionError, match=said):
        mission(text)


def test_metrics_that_raise_are_a_verdict(tmp_path):
    law = (EXAMPLE / "rendezvous.py").read_text()
    (tmp_path / "rendezvous.py").write_text(law.replace("self.errors(flown)[flown.final]", "self.errors(flown)[1e9]"))
    shutil.copy(EXAMPLE / "mission.yaml", tmp_path)
    text = load_mission(tmp_path / "mission.yaml", backend="integrator", changes=["flight=[{start: {duration: 1}}]"])
    result = fly(text)
    assert any(failure.startswith("criteria.meeting_m: IndexError") for failure in result.failures)


FILTER = """
from crazychoir_fw.control import VelocityController
from crazychoir_fw.control.safety import SingleIntegratorCBF


class Shy(SingleIntegratorCBF):
    def __init__(self, shyness=1.0, **options):
        super().__init__(**options)
        self.shyness = shyness


class Calm(VelocityController):
    pass
"""


def filtered(folder, **control):
    (folder / "shy.py").write_text(FILTER)
    text = data(**{"class": "GoToGuidance", "goals": {}, "options": {}})
    text["criteria"] = {}
    text["layers"]["control"] = control
    text["layers"]["safety"] = {"filter": "shy.py:Shy", "max_velocity": 0.3, "options": {"shyness": 2.0}}
    return text


def test_filters_and_controllers_of_a_file_say_what_fits(tmp_path):
    flown = parse_mission(filtered(tmp_path, **{"class": "shy.py:Calm"}), folder=tmp_path)
    assert flown.layers.commands == ("vel",)
    made = make_safety_filter(flown)
    assert (made.shyness, made.max_velocity, made.distance) == (2.0, 0.3, 0.4)
    assert type(make_controller(flown, 0)).__name__ == "Calm"
    with pytest.raises(
        MissionError, match="filters the commands of a VelocityController, but .* HierarchicalController"
    ):
        parse_mission(filtered(tmp_path), folder=tmp_path)
    wrong = filtered(tmp_path, **{"class": "VelocityController"})
    wrong["layers"]["safety"]["options"] = {"shynes": 1.0}
    with pytest.raises(MissionError, match="layers.safety.options has no key 'shynes'"):
        parse_mission(wrong, folder=tmp_path)
