"""A user's own C within the firmware's own modules: tasks, tables, the console."""

from pathlib import Path

import pytest

from crazychoir_fw.common.errors import BuildError
from crazychoir_fw.firmware.apps import build_app
from crazychoir_fw.firmware.levels import ALGORITHMS, MODULES, STABILIZER, word_of
from crazychoir_fw.simulation import DroneConfig, World

APPS = Path(__file__).parent / "apps"
FLYING, ASKING = APPS / "flying.c", APPS / "asking.c"
NEWEST = "2026.08"

pytestmark = pytest.mark.usefixtures("lasting_cache")


@pytest.fixture
def checkout(checkout_of, monkeypatch):
    """The newest release, as the checkout of this machine."""
    root = checkout_of(NEWEST)
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(root))
    return root


@pytest.mark.parametrize("level", [MODULES, STABILIZER])
def test_an_app_with_a_task_flies_by_itself(level, checkout):
    app = build_app(FLYING, provider=word_of(level), checkout=checkout)
    assert app.hooks == ()
    assert app.groups == {"flying"}
    assert app.warnings == ""
    configs = [DroneConfig(f"cf{i}", (i, 0.0), app=FLYING, provider=word_of(level)) for i in range(2)]
    world = World(configs, seed=1, visuals=False)
    first, second = world.drones
    second.param["flying.wanted"] = 0
    world.run(0.01)
    assert "FLYING: hello" in first.console
    world.run(4.8)
    assert first.true_position[2] == pytest.approx(0.4, abs=0.05)
    assert second.true_position[2] < 0.03
    assert first.log["flying.seen"] == pytest.approx(first.log["stateEstimate.z"], abs=0.01)
    assert first.log["flying.turns"] == pytest.approx(230, abs=2)
    assert first.param["hlCommander.vland"] == 0.25
    world.run(2.7)
    assert "FLYING: at 4" in first.console or "FLYING: at 3" in first.console
    assert first.true_position[2] < 0.05
    assert first.failure is None and second.failure is None


def test_an_app_with_a_task_only_is_refused_where_no_task_runs(checkout, tmp_path):
    path = tmp_path / "idle.c"
    path.write_text('#include "app.h"\n\nvoid appMain(void) {\n}\n')
    with pytest.raises(BuildError, match=r"idle\.c has nothing that a drone would call"):
        build_app(path, provider=word_of(ALGORITHMS), checkout=checkout)


@pytest.mark.parametrize("provider", ["builtin", word_of(ALGORITHMS), word_of(STABILIZER)])
def test_an_app_asks_the_tables_and_prints_over_everything(provider, checkout):
    app = build_app(ASKING, provider=provider, checkout=checkout)
    assert app.hooks == ("controller", "estimator")
    assert app.warnings == ""
    config = DroneConfig("cf1", app=ASKING, provider=provider, estimator="kalman")
    world = World([config], seed=1, visuals=False)
    drone = world["cf1"]
    world.wait_until_ready()
    drone.high_level_commander.takeoff(absolute_height_m=0.4, duration_s=1.0)
    world.run(2.0)
    assert drone.failure is None
    assert drone.true_position[2] == pytest.approx(0.4, abs=0.05)
    assert "ASKING: asked" in drone.console
    assert [drone.log[f"asking.{name}"] for name in ("paramFound", "paramNamed", "logNamed")] == [1, 1, 1]


def test_functions_with_the_same_code_are_both_found_at_full_speed():
    app = build_app(ASKING, provider="builtin")
    assert "-O3" in app.library.identity["flags"]
    assert app.hooks == ("controller", "estimator")


def test_only_warnings_of_the_own_file_are_told(checkout, tmp_path):
    path = tmp_path / "sloppy.c"
    path.write_text(FLYING.read_text().replace("void appMain", "static int unused;\nvoid appMain"))
    app = build_app(path, provider=word_of(STABILIZER), checkout=checkout)
    told = [line for line in app.warnings.splitlines() if "warning:" in line]
    assert len(told) == 1
    assert told[0].startswith(f"{path}:")
    assert "unused" in told[0]
