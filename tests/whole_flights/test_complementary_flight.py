"""Flights on the complementary estimator: attitude from the IMU, height from the range finder or the barometer.

It knows neither position nor drag, so a drone drifts; what it can hold is its attitude and its height.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from crazychoir_fw._core import lib
from crazychoir_fw.recording.signals import roll_pitch_yaw_deg
from crazychoir_fw.simulation import DroneConfig, World

COMPLEMENTARY, KALMAN = 1, 2

# deg: a turn-on error of 20 mg tilts the accelerometer's idea of level by 1.15 deg per axis
# (docs/reference/vehicle.md#10), and while the drone gathers speed along this tilt gravity seems to be where the
# estimate has it; seen: up to 1.5
TILT_ERROR = 1.7


def ready(platform: str = "cf2", seed: int = 1, **settings: Any) -> tuple[World, Any]:
    world = World([DroneConfig("cf1", (0.0, 0.0), platform=platform, **settings)], seed=seed)
    world.wait_until_ready()
    return world, world.drones[0]


def attitude_error(drone: Any) -> np.ndarray:
    """Roll, pitch and yaw (deg) by the estimate minus the true ones, shape (3,)."""
    told = [drone.log[f"stateEstimate.{name}"] for name in ("roll", "pitch", "yaw")]
    return np.array(told) - roll_pitch_yaw_deg(drone.true_quat_wxyz)


def fly(world: World, drone: Any, seconds: float, command: Callable[[], None]) -> dict[str, np.ndarray]:
    """Command at 100 Hz and return what happened, sampled likewise."""
    rows = []
    for _ in range(round(seconds * 100)):
        command()
        world.step(10)
        rows.append([drone.true_position[2], drone.log["stateEstimate.z"], *attitude_error(drone)])
    table = np.array(rows)
    return {"height": table[:, 0], "told": table[:, 1], "attitude_error": table[:, 2:]}


def level_at(drone: Any, height: float) -> Callable[[], None]:
    return lambda: drone.commander.send_zdistance_setpoint(0.0, 0.0, 0.0, height)


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
@pytest.mark.parametrize("seed", [1, 2])
def test_takes_off_level_and_keeps_its_height_above_the_floor(platform, seed):
    """The range is right to 2.5 mm and whole millimeters, then smoothed; the rest is the vertical loop, which lifts off
    with thrustBase and pulls in within seconds, as it does on the Kalman filter."""
    world, drone = ready(platform, seed, positioning="flow", estimator="complementary")
    assert drone.param["stabilizer.estimator"] == COMPLEMENTARY
    flight = fly(world, drone, 15.0, level_at(drone, 0.5))
    assert drone.failure is None
    assert drone.is_flying
    settled = slice(500, None)
    assert np.abs(flight["told"] - flight["height"])[settled].max() < 0.01
    assert np.abs(flight["height"] - 0.5)[settled].max() < 0.04
    assert np.abs(flight["height"] - 0.5)[-200:].max() < 0.01
    assert np.abs(flight["attitude_error"][:, :2]).max() < TILT_ERROR
    assert np.abs(flight["attitude_error"][:, 2]).max() < 1.0


def test_height_is_kept_as_well_as_on_the_kalman_filter():
    heights = []
    for estimator in ("complementary", "kalman"):
        world, drone = ready(positioning="flow", estimator=estimator)
        heights.append(fly(world, drone, 8.0, level_at(drone, 0.5))["height"])
    complementary, kalman = (np.sqrt(np.mean((height[400:] - 0.5) ** 2)) for height in heights)
    assert complementary < 1.5 * kalman + 0.005


def test_ideal_sensors_give_the_true_attitude():
    world, drone = ready(positioning="flow", estimator="complementary", attributes={"noise": 0.0, "bias": 0.0})
    flight = fly(world, drone, 6.0, level_at(drone, 0.5))
    assert np.abs(flight["attitude_error"]).max() < 0.05
    assert np.linalg.norm(drone.true_position[:2]) < 0.05


@pytest.mark.parametrize("seed", [1, 2])
def test_attitude_follows_the_stick_without_any_positioning(seed):
    """By thrust, roll and pitch alone: within the tilt error and what a lean of 1 s may add (2 deg at 8)."""
    world, drone = ready(seed=seed, positioning="none")
    assert drone.param["stabilizer.estimator"] == COMPLEMENTARY
    drone.commander.send_setpoint(0, 0, 0, 0)  # unlocks the thrust
    world.step(10)
    level = fly(world, drone, 1.5, lambda: drone.commander.send_setpoint(0, 0, 0, 42000))
    assert np.abs(level["attitude_error"]).max() < TILT_ERROR
    fly(world, drone, 1.0, lambda: drone.commander.send_setpoint(8.0, -5.0, 0, 42000))
    roll, pitch, _ = roll_pitch_yaw_deg(drone.true_quat_wxyz)
    assert roll == pytest.approx(8.0, abs=3.0)
    assert pitch == pytest.approx(5.0, abs=3.0)  # cflib's positive pitch lowers the nose
    assert drone.true_velocity[1] < -0.3
    assert drone.true_velocity[0] < -0.2
    assert drone.failure is None


def test_barometer_holds_an_altitude_above_sea_level():
    """Climb rate 0 through the vertical loop: 430 m of altitude do not matter, only drift and noise do."""
    world, drone = ready(positioning="none", attributes={"altitude": 430.0, "baro_noise": 0.0})
    climb = lambda rate: lib.cf_send_altitude_hold(drone.struct, 0.0, 0.0, 0.0, rate)
    fly(world, drone, 3.0, lambda: climb(0.5))
    assert drone.true_position[2] > 0.5
    fly(world, drone, 2.0, lambda: climb(0.0))
    start = drone.true_position[2]
    flight = fly(world, drone, 5.0, lambda: climb(0.0))
    # a step of the barometer's height is 5.5 mm in float32
    assert np.abs(flight["height"] - start).max() < 0.03
    assert np.abs(flight["told"] - 430.0 - flight["height"]).max() < 0.015


def test_noisy_barometer_lets_the_height_wander_and_the_drone_level():
    """0.15 m of noise per sample and 0.3 m of drift: the height stays within three deviations of the drift."""
    world, drone = ready(positioning="none")
    flight = fly(world, drone, 12.0, level_at(drone, 1.5))
    assert np.abs(flight["height"] - 1.5)[500:].max() < 0.9
    assert np.abs(flight["attitude_error"][:, :2]).max() < TILT_ERROR
    assert np.std(flight["told"][500:]) < 0.15


@pytest.mark.parametrize("seed", [1, 2])
def test_estimators_may_be_switched_in_flight(seed):
    """Kalman, complementary for 2 s, Kalman: the filter restarts and the first poses put it right."""
    world, drone = ready(seed=seed)
    drone.high_level_commander.takeoff(1.0, 2.0)
    world.run(6.0)
    drone.param["stabilizer.estimator"] = COMPLEMENTARY
    blind = fly(world, drone, 2.0, level_at(drone, 1.0))
    assert drone.param["stabilizer.estimator"] == COMPLEMENTARY
    assert [drone.log["stateEstimate.x"], drone.log["stateEstimate.y"]] == [0.0, 0.0]
    assert drone.log["kalman.rtUpdate"] == 0.0
    assert drone.log["estimator.rtApnd"] == 2150.0
    assert np.abs(blind["attitude_error"][:, :2]).max() < TILT_ERROR
    assert np.linalg.norm(drone.true_position[:2]) < 0.3

    drone.param["stabilizer.estimator"] = KALMAN
    errors = []
    for _ in range(500):
        drone.commander.send_position_setpoint(0.0, 0.0, 1.0, 0.0)
        world.step(10)
        errors.append(np.linalg.norm(drone.estimated_position - drone.true_position))
    assert max(errors[1:]) < 0.1
    assert max(errors[-100:]) < 0.01
    assert drone.log["kalman.rtUpdate"] == 1000.0
    np.testing.assert_allclose(drone.true_position, [0.0, 0.0, 1.0], atol=0.05)
    assert drone.is_flying


def test_reset_of_the_kalman_filter_still_works_in_flight():
    world, drone = ready()
    drone.high_level_commander.takeoff(1.0, 2.0)
    world.run(6.0)
    drone.param["kalman.resetEstimation"] = 1
    world.run(3.0)
    assert drone.param["kalman.resetEstimation"] == 0
    assert np.linalg.norm(drone.estimated_position - drone.true_position) < 0.02
    np.testing.assert_allclose(drone.true_position, [0.0, 0.0, 1.0], atol=0.1)
