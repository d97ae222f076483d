"""The policies that lie in examples/learning: their apps are what `from-policy` writes, and fly their missions."""

from pathlib import Path

import pytest

from crazychoir_fw.flight import fly
from crazychoir_fw.learning.policy import read_policy, write_app
from crazychoir_fw.mission import load_mission

FOLDER = Path(__file__).parents[2] / "examples" / "learning"


@pytest.mark.parametrize("name", ["hover", "figure8"])
def test_app_is_what_its_policy_becomes(name, tmp_path):
    shipped = (FOLDER / f"{name}.c").read_text()
    origin = shipped.partition(" * from ")[2].partition(";")[0]
    written = write_app(read_policy(FOLDER / f"{name}.npz"), tmp_path, name, origin)
    assert written.read_text() == shipped


def test_hover_flies_its_mission(lasting_cache):
    assert fly(load_mission(FOLDER / "hover.yaml")).failures == []


def test_figure8_is_followed_more_closely_than_by_pid(lasting_cache):
    """13 cm root mean square beside 29 cm of the PID controller on the whole mission."""
    flown = fly(load_mission(FOLDER / "figure8.yaml"))
    assert flown.failures == []
    assert flown.summary["drones"][0]["rms_error_m"] < 0.2
