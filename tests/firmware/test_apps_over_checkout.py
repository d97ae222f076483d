"""A user's own C around which a checkout of the firmware flies: here its miniature."""

from pathlib import Path

import numpy as np
import pytest

from crazychoir_fw.firmware.apps import build_app
from crazychoir_fw.simulation import DroneConfig, FlightRecorder, World

APPS = Path(__file__).parent / "apps"
BOTH = [APPS / "counting.c", APPS / "following.c"]
NAME = "bitcraze+counting+following"


pytestmark = pytest.mark.usefixtures("lasting_cache")


def test_app_is_built_with_the_headers_of_the_checkout(miniature):
    app = build_app(BOTH, provider="bitcraze", checkout=miniature)
    assert app.library.name == NAME
    assert app.hooks == ("controller", "estimator")
    assert app.library.identity["checkout"] == str(miniature)
    assert app.warnings == ""


def test_example_compiles_over_a_checkout_too(miniature):
    example = Path(__file__).parents[2] / "examples" / "new_controller" / "tilt_prioritized.c"
    # with an estimator beside it, so that the checkout is configured as in the other tests
    app = build_app([example, APPS / "following.c"], provider="bitcraze", checkout=miniature)
    assert app.hooks == ("controller", "estimator")
    assert app.warnings == ""


def test_apps_fly_beside_a_stock_drone(miniature, monkeypatch):
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(miniature))
    configs = [DroneConfig(f"cf{i}", (i, 0.0), provider="bitcraze", app=BOTH) for i in range(2)]
    world = World([*configs, DroneConfig("stock", (0.0, 1.0))], seed=1, visuals=False)
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(absolute_height_m=0.5, duration_s=1.5)
    first, second, stock = world.drones
    first.param["count.scale"] = 3.0
    world.run(2.0)
    second.param["stabilizer.controller"] = 1
    recorder = FlightRecorder(world)
    recorder.run(1.0)

    assert [drone.config.provider for drone in world.drones] == [NAME, NAME, "builtin"]
    assert [drone.param["stabilizer.controller"] for drone in world.drones] == [6, 1, 1]
    assert [drone.param["stabilizer.estimator"] for drone in world.drones] == [3, 3, 2]
    assert (first.param["count.scale"], second.param["count.scale"]) == (3.0, 1.0)
    assert first.log["count.calls"] == second.log["count.calls"] + 1000
    poses = recorder.finish().signals["follow.poses"]
    assert poses[:, :2].min() > 200
    assert np.isnan(poses[:, 2]).all()
    assert stock.failure is None
    np.testing.assert_allclose([drone.true_position[2] for drone in world.drones], 0.5, atol=0.1)
