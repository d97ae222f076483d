"""Hovering on every positioning system, with the errors that it has in a room (docs/reference/vehicle.md#10)."""

import numpy as np
import pytest

from crazychoir_fw.simulation import DroneConfig, World

GOAL = np.array([0.4, -0.3, 1.0])

IDEAL = {
    "lighthouse": {"noise": 0, "position_error": 0, "attitude_error": 0, "dropout": 0, "outlier": 0},
    "loco": {"noise": 0, "bias": 0, "dropout": 0, "outlier": 0},
    "mocap": {"noise": 0},
}


def hover(positioning, seconds=20.0, settle=12.0, seed=1, parameters=None, **attributes):
    """Fly at GOAL; return true and estimated positions (m) and the error of the estimated yaw (deg) at 100 Hz."""
    config = DroneConfig("cf1", tuple(GOAL[:2]), positioning=positioning, attributes=attributes)
    world = World([config], seed=seed)
    world.wait_until_ready()
    drone = world.drones[0]
    for name, value in (parameters or {}).items():
        drone.param[name] = value
    drone.high_level_commander.takeoff(GOAL[2], 2.0)
    world.run(settle)
    truth, estimate, yaw = [], [], []
    for _ in range(int(seconds * 100)):
        world.step(10)
        truth.append(drone.true_position)
        estimate.append(drone.estimated_position)
        w, x, y, z = drone.true_quat_wxyz
        true_yaw = np.degrees(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
        yaw.append(drone.log["stateEstimate.yaw"] - true_yaw)
    assert drone.failure is None
    return np.array(truth), np.array(estimate), np.array(yaw)


def rms(errors):
    return np.sqrt(np.mean(np.square(errors), axis=0))


# horizontal and vertical error of the estimate (m, RMS), error of the yaw (deg, RMS)
AS_THEY_COME = [
    ("mocap_position", {}, 0.003, 0.002, 3.0),
    ("lighthouse", {}, 0.04, 0.03, 1.5),
    ("lighthouse", {"lighthouse.method": 0}, 0.04, 0.03, 1.5),
    ("loco_twr", {}, 0.15, 0.25, 3.0),
    ("loco_tdoa2", {}, 0.15, 0.30, 3.0),
    ("loco_tdoa3", {}, 0.15, 0.30, 3.0),
]


@pytest.mark.parametrize(("positioning", "parameters", "horizontal", "vertical", "yaw"), AS_THEY_COME)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_hover_with_the_errors_of_the_system(positioning, parameters, horizontal, vertical, yaw, seed):
    truth, estimate, yaw_error = hover(positioning, seed=seed, parameters=parameters)
    error = rms(estimate - truth)
    assert error[0] < horizontal
    assert error[1] < horizontal
    assert error[2] < vertical
    assert rms(yaw_error) < yaw
    # a takeoff rises from where the estimate has been on the floor
    assert np.abs(truth.mean(axis=0) - GOAL).max() < max(horizontal, vertical) + 0.02


def hover_without_errors(positioning, **more):
    kind = positioning.split("_")[0]
    ideal = {f"{kind}_{name}": float(value) for name, value in IDEAL[kind].items()}
    truth, estimate, _ = hover(positioning, **ideal, **more)
    return estimate - truth


@pytest.mark.parametrize(("positioning", "error"), [("lighthouse", 0.001), ("loco_tdoa2", 0.002), ("loco_twr", 0.008)])
def test_without_errors_the_estimate_is_the_truth(positioning, error):
    assert rms(hover_without_errors(positioning, noise=0, bias=0)).max() < error


@pytest.mark.parametrize(("positioning", "error"), [("lighthouse", 0.001), ("loco_tdoa2", 0.02), ("loco_twr", 0.065)])
def test_inertial_sensors_alone_move_the_estimate(positioning, error):
    """Their turn-on errors do it, and so differently from drone to drone that one says little.

    Largest error of an axis with two-way ranging, six drones: 0.04, 0.05, 0.08, 0.06, 0.09, 0.04 m; the same with white
    noise in place of the chip's, 0.02 to 0.04 m without turn-on errors, 0.006 m without noise as well. Light corrects
    the attitude too.
    """
    errors = [rms(hover_without_errors(positioning, seed=seed)) for seed in (1, 2, 3, 4)]
    assert rms(errors).max() < error


@pytest.mark.parametrize(
    ("positioning", "parameter"), [("loco_tdoa2", "kalman.robustTdoa"), ("loco_twr", "kalman.robustTwr")]
)
def test_robust_filters_hover_among_many_outliers(positioning, parameter):
    truth, estimate, _ = hover(positioning, parameters={parameter: 1}, loco_outlier=0.05)
    assert rms(estimate - truth).max() < 0.3


@pytest.mark.parametrize("positioning", ["mocap", "mocap_position", "lighthouse", "loco_tdoa2"])
def test_every_third_reading_may_be_lost(positioning):
    truth, _, _ = hover(positioning, **{f"{positioning.split('_')[0]}_dropout": 1 / 3})
    assert np.abs(truth - truth.mean(axis=0)).max() < 0.2
    assert np.abs(truth.mean(axis=0) - GOAL).max() < 0.3


def test_reflections_do_not_reach_the_position():
    """The filter's gate lets in what is within 5 cm once it has settled (docs/reference/estimators.md#6.3)."""
    clean, _, _ = hover("lighthouse", lighthouse_outlier=0.0)
    dirty, _, _ = hover("lighthouse", lighthouse_outlier=0.02)
    assert np.abs(dirty.mean(axis=0) - clean.mean(axis=0)).max() < 0.02
    assert dirty.std(axis=0).max() < clean.std(axis=0).max() + 0.02


def test_in_two_dimensions_the_height_is_given():
    world = World(
        [DroneConfig("cf1", (0.0, 0.0), positioning="loco_tdoa2", attributes={"loco_2d": "on", "loco_height": 0.0145})],
        seed=2,
    )
    world.run(10.0)
    drone = world.drones[0]
    assert drone.estimated_position[2] == pytest.approx(0.0145, abs=2e-3)
    assert np.linalg.norm(drone.estimated_position[:2]) < 0.2


def test_a_swarm_shares_the_errors_of_the_room():
    """Drones at the same place see the same geometry: their biases point the same way."""
    fleet = [DroneConfig(f"cf{i}", (0.2 * i, 0.0), positioning="lighthouse") for i in range(3)]
    world = World(fleet, seed=4)
    world.run(10.0)
    biases = np.array([drone.estimated_position - drone.true_position for drone in world.drones])
    assert np.linalg.norm(biases[0]) > 0.003
    assert np.abs(biases - biases[0]).max() < 0.5 * np.linalg.norm(biases[0])


@pytest.mark.parametrize("positioning", ["loco_tdoa2", "loco_tdoa3"])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_robust_tdoa_starts_and_restarts(positioning, seed):
    """From its large covariance at boot, and after a reset while samples arrive; the firmware's root is NaN there."""
    config = DroneConfig("cf1", (0.5, 0.0), positioning=positioning, parameters={"kalman.robustTdoa": 1})
    world = World([config], seed=seed)
    world.wait_until_ready()
    drone = world.drones[0]
    for _ in range(3):
        assert np.abs(drone.estimated_position - drone.true_position).max() < 0.4
        drone.param["kalman.resetEstimation"] = 1
        world.run(2.0)
    assert drone.failure is None


def test_a_flow_drone_that_stands_for_long_knows_where_it_is():
    """What cflib's `reset_estimator` waits for: in ten readings, 0.5 s apart, no variance changes by 0.001 or more."""
    world = World([DroneConfig("cf1", positioning="flow")], seed=1, visuals=False)
    world.wait_until_ready()
    drone = world.drones[0]
    drone.param["kalman.resetEstimation"] = 1
    world.run(0.1)
    variances = []
    for _ in range(12):
        world.run(0.5)
        variances.append([drone.log[f"kalman.varP{axis}"] for axis in "XYZ"])
    assert np.ptp(np.array(variances[-10:]), axis=0).max() < 0.001
    assert np.linalg.norm(drone.estimated_position[:2] - drone.true_position[:2]) < 0.02
    for height in np.linspace(0.0, 0.5, 13):
        drone.commander.send_hover_setpoint(0.0, 0.0, 0.0, height)
        world.run(0.2)
    assert np.linalg.norm(drone.true_position[:2]) < 0.15
