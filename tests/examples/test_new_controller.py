"""examples/new_controller: the C file compiles cleanly, beats PID where its page says so, and the picture is drawn."""

import re
import runpy
from pathlib import Path

import matplotlib.image
import pytest

from crazychoir_fw.firmware.apps import build_app
from crazychoir_fw.flight.engine import fly
from crazychoir_fw.mission import load_mission

FOLDER = Path(__file__).parents[2] / "examples" / "new_controller"


@pytest.fixture(scope="module")
def compare():
    """The script, as a mapping from names to functions."""
    return runpy.run_path(str(FOLDER / "compare.py"))


@pytest.fixture(scope="module")
def flown():
    """The mission and its result."""
    mission = load_mission(FOLDER / "compare.yaml")
    return mission, fly(mission, visuals=False)


def test_controller_compiles_without_a_warning():
    app = build_app(FOLDER / "tilt_prioritized.c")
    assert app.hooks == ("controller",)
    assert app.warnings == ""


def test_flight_succeeds_and_log_shows_the_new_controller(flown):
    _, result = flown
    assert result.failures == []
    assert result.world["ours"].config.provider == "builtin+tilt_prioritized"
    tilt = result.log.signals["ctrlTilt.tilt"][:, 1]
    assert 0.0 < tilt.max() < 40.0


def test_figures_are_those_of_the_page(flown, compare):
    mission, result = flown
    table = compare["figures"](mission, result.log)
    page = (FOLDER / "README.md").read_text()
    cells = re.findall(r"^\| [^|]+ \| ([\d.]+) [^|]+ \| ([\d.]+) [^|]+ \|$", page, flags=re.M)
    rows = list(table["pid"])
    assert len(cells) == len(rows)
    for row, printed in zip(rows, cells, strict=True):
        for name, text in zip(("pid", "ours"), printed, strict=True):
            # other compilers and math libraries fly a little differently
            least = 0.5 if row == "overshoot_percent" else 0.0
            assert table[name][row] == pytest.approx(float(text), rel=0.05, abs=least)
    assert table["ours"]["figure8_rms_mm"] < table["pid"]["figure8_rms_mm"] / 3


def test_picture_shows_something(flown, compare, tmp_path):
    mission, result = flown
    path = tmp_path / "folder" / "compare.png"
    compare["draw"](mission, result.log, compare["figures"](mission, result.log), path)
    picture = matplotlib.image.imread(path)
    assert min(picture.shape[:2]) > 500
    assert picture[..., :3].std() > 0.05
