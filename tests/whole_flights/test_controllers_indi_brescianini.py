"""Flights with the controllers INDI and Brescianini against docs/reference/control-geometric.md#16.

The loop there has true state, no sensors and motors of 30 ms; `IDEAL` comes as near to it as a whole drone can.
"""

import numpy as np
import pytest
from test_acceptance import hovering, record, within, yaw_deg
from test_figure8_tracking import pieces

from crazychoir_fw.simulation import DroneConfig, World

IDEAL = {
    "supply_voltage": 4.0,
    "noise": 0.0,
    "bias": 0.0,
    "mocap_latency_ms": 0,
    "mocap_std": 0.01,
    "mocap_attitude_std": 4.5e-3,
    "mocap_noise": 0.0,
    "mocap_attitude_noise": 0.0,
    "drag": "none",
    "flight_moment": "off",
    "body_drag": 0.0,
    "motor_time_constant": 0.03,
}


def world_with(controller, platform="cf2", seed=3, position=(0.0, 0.0), **attributes):
    drone = DroneConfig("cf1", position, platform=platform, controller=controller, attributes=attributes)
    return World([drone], seed=seed)


def rms(error):
    """Return the root of the mean squared length of rows, in mm."""
    return 1000 * np.sqrt(np.mean(np.sum(np.square(error), axis=1)))


# ---- hover with sensors, battery and drag as they come ----


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
@pytest.mark.parametrize(("controller", "most_mm"), [("indi", 60), ("brescianini", 5)])
def test_hover_at_one_meter(controller, most_mm, platform):
    """INDI has no integral: the bias of the accelerometer is an offset, bias / (K_xi K_dxi)."""
    world = world_with(controller, platform, position=(0.3, -0.2))
    drone = hovering(world, settle=8.0)
    _, samples = record(world, 20.0, lambda: [*drone.true_position, yaw_deg(drone)])
    error = samples[:, :3] - [0.3, -0.2, 1.0]
    assert rms(error) < most_mm
    assert rms(error - error.mean(axis=0)) < 4
    assert abs(error[:, 2].mean()) < 0.005
    assert np.abs(samples[:, 3]).max() < 1.0


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
def test_indi_without_accelerometer_bias_has_no_offset(platform):
    world = world_with("indi", platform, bias=0.0)
    drone = hovering(world, settle=8.0)
    _, position = record(world, 20.0, lambda: drone.true_position)
    assert rms(position - [0.0, 0.0, 1.0]) < 5


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
@pytest.mark.parametrize("controller", ["indi", "brescianini"])
def test_landing_ends_with_motors_off(controller, platform):
    world = world_with(controller, platform)
    drone = hovering(world, settle=4.0)
    drone.high_level_commander.land(0.0, 2.5)
    world.run(8.0)
    assert drone.true_position[2] < 0.03
    assert np.linalg.norm(drone.true_position[:2]) < 0.06
    assert [drone.log[f"motor.m{i}"] for i in (1, 2, 3, 4)] == [0, 0, 0, 0]
    assert drone.failure is None


# ---- docs/reference/control-geometric.md#16 ----


@pytest.mark.parametrize(
    ("controller", "goal", "overshoot", "settling"),
    [
        ("brescianini", (1, 0, 1), 18.0, 2.7),
        ("brescianini", (0, 0, 2), 0.0, 1.1),
        ("indi", (1, 0, 1), 0.0, 2.8),
        ("indi", (0, 0, 2), 0.0, 2.7),
    ],
)
def test_step_of_one_meter(controller, goal, overshoot, settling):
    """Overshoot in %, settling within 5 % in s; the dips of the table belong to its start in mid-air."""
    world = world_with(controller, **IDEAL)
    drone = hovering(world, settle=8.0)
    hold = lambda *position: drone.commander.send_position_setpoint(*position, 0.0)
    record(world, 1.0, lambda: None, lambda: hold(0, 0, 1))
    times, position = record(world, 8.0, lambda: drone.true_position, lambda: hold(*goal))
    fraction = position @ np.subtract(goal, (0, 0, 1)) - np.dot((0, 0, 1), np.subtract(goal, (0, 0, 1)))
    assert within(100 * (fraction.max() - 1), overshoot, slack=1.0)
    assert within(times[np.flatnonzero(np.abs(fraction - 1) > 0.05)[-1]], settling)
    assert position[:, 2].min() > 0.98


@pytest.mark.parametrize(
    ("controller", "time_scale", "expected_mm"),
    [
        ("brescianini", 1.0, 110),
        ("brescianini", 2.0, 22),
        ("indi", 1.0, 560),
        ("indi", 2.0, 370),
    ],
)
def test_figure8_is_followed_as_well_as_the_reference_does(controller, time_scale, expected_mm):
    """INDI lags a moving setpoint by about a second of motion, because it ignores its velocity (quirk 19).

    Ours are 101, 14, 560 and 368 mm: where Brescianini does well, a little better than the reference.
    """
    world = world_with(controller, **IDEAL)
    drone = hovering(world, settle=8.0)
    duration = drone.high_level_commander.upload_trajectory(1, pieces())
    drone.high_level_commander.start_trajectory(1, time_scale, relative_position=True)
    target = lambda: [drone.log[f"ctrltarget.{axis}"] for axis in "xyz"]
    _, samples = record(world, duration * time_scale, lambda: [*drone.true_position, *target()])
    assert 0.5 * expected_mm < rms(samples[:, :3] - samples[:, 3:]) < 1.1 * expected_mm


def test_brescianini_holds_every_heading():
    world = world_with("brescianini")
    drone = hovering(world, settle=2.0)
    for yaw in (0.0, 90.0, 135.0, 180.0, -90.0):
        hold = lambda: drone.commander.send_position_setpoint(0.0, 0.0, 1.0, yaw)  # noqa: B023 - called at once
        record(world, 3.0, lambda: None, hold)
        _, samples = record(world, 2.0, lambda: [*drone.true_position, yaw_deg(drone)], hold)
        assert rms(samples[:, :3] - [0, 0, 1]) < 10
        assert np.abs((samples[:, 3] - yaw + 180) % 360 - 180).max() < 1.5


def test_indi_spins_when_it_holds_the_heading_where_its_angle_jumps():
    """It does not take the yaw error the short way round; up to 178 degrees all is well."""
    world = world_with("indi")
    drone = hovering(world, settle=2.0)
    spin = {}
    for yaw in (170.0, 178.0, 180.0):
        hold = lambda: drone.commander.send_position_setpoint(0.0, 0.0, 1.0, yaw)  # noqa: B023 - called at once
        record(world, 3.0, lambda: None, hold)
        _, rates = record(world, 3.0, lambda: drone.log["gyro.z"], hold)
        spin[yaw] = np.abs(rates).max()
    assert spin[178.0] < 10
    assert spin[180.0] > 100
