"""examples/app_task: an app's own task flies a drone over a checkout."""

import re
import runpy
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[2] / "examples" / "app_task" / "hop.py"


def test_the_task_flies_a_square_and_lands(miniature, monkeypatch, capsys, lasting_cache):
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(miniature))
    runpy.run_path(str(EXAMPLE))
    printed = capsys.readouterr().out
    assert "HOP: done after 4 corners" in printed
    highest, x, y = map(float, re.search(r"highest (\S+) m, back at (\S+), (\S+) m", printed).groups())
    assert highest == pytest.approx(0.7, abs=0.1)
    assert (x, y) == pytest.approx((0.0, 0.0), abs=0.05)
    corners = re.findall(r"(\S+) +(\S+) +\S+ m  corner (\d)", printed)
    reached = {corner: (float(x), float(y)) for x, y, corner in corners}
    assert reached["1"] == pytest.approx((0.41, 0.27), abs=0.1)
    assert reached["2"] == pytest.approx((0.08, 0.39), abs=0.1)
