"""A control law from a file: one that raises stops its own drone, and it may import what lies beside it."""

import re
from pathlib import Path

import numpy as np
import pytest
from flown_layers import hover

from crazychoir_fw.common.user_code import load_module
from crazychoir_fw.flight.engine import fly
from crazychoir_fw.mission.loader import parse_mission

LAW = """
from crazychoir_fw.control import FlatnessPositionCtrl


class Mine(FlatnessPositionCtrl):
    def control(self, current_pose, desired_reference):
        {what}
        return super().control(current_pose, desired_reference)
"""


def flown(tmp_path, what, count=3):
    (tmp_path / "mine.py").write_text(LAW.format(what=what))
    data = hover(count, seed=1, backend="integrator")
    data["layers"]["control"]["position"] = "mine.py:Mine"
    return fly(parse_mission(data, folder=tmp_path))


def test_a_law_that_raises_for_one_drone_stops_that_one_and_the_log_is_kept(tmp_path):
    east = "if (current_pose.position[..., 0].max() > {x} and current_pose.position[..., 2].max() > 0.3): 1 / 0"
    result = flown(tmp_path, east.format(x=0.5), count=2)
    assert [drone["phase"] for drone in result.summary["drones"]] == ["landed", "failed"]
    (failure,) = (sentence for sentence in result.failures if "ZeroDivisionError" in sentence)
    assert re.match(r"\w+: HierarchicalController: ZeroDivisionError: .* \(mine.py:7\) \(at [\d.]+ s\)", failure)
    assert result.log.time[-1] > 2.0


def test_a_law_that_always_raises_stops_all(tmp_path):
    result = flown(tmp_path, "raise ValueError('no idea')", count=2)
    assert [drone["phase"] for drone in result.summary["drones"]] == ["failed", "failed"]
    assert sum("ValueError: no idea (mine.py:7)" in sentence for sentence in result.failures) == 2


def test_a_file_imports_what_lies_beside_it_and_not_what_lies_beside_another(tmp_path):
    for name, number in (("a", 1), ("b", 2)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "numbers_of_mine.py").write_text(f"K = {number}\n")
        (tmp_path / name / "law.py").write_text("from numbers_of_mine import K\n")
    assert [load_module(str(tmp_path / name / "law.py"), "law").K for name in "aba"] == [1, 2, 1]
    (tmp_path / "a" / "numbers_of_mine.py").write_text("K = 33\n")
    assert load_module(str(tmp_path / "a" / "law.py"), "law").K == 33


def test_the_law_of_the_docs_flies_one_drone_and_a_batch(tmp_path):
    text = (Path(__file__).parents[2] / "docs" / "control.md").read_text()
    block = next(block for block in re.findall(r"```python[^\n]*\n(.*?)```", text, re.DOTALL) if "class Soft" in block)
    (tmp_path / "soft.py").write_text(block)
    for count in (1, 3):
        data = hover(count, seed=1, backend="integrator")
        data["layers"]["control"]["position"] = "soft.py:Soft"
        result = fly(parse_mission(data, folder=tmp_path))
        assert result.success, result.failures
        assert np.nanmax(result.log.signals["sim.z"]) == pytest.approx(0.5, abs=0.3)
