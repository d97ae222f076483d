"""Whole flights against the table "Closed-loop reference" of docs/reference/control-pid.md#19.

The table was computed with 29 g, first-order motors of 0.07 s, linear drag 0.0135 / 0.0168 N s/m, a supply of 4.0 V,
gyro noise 0.1 deg/s, accelerometer noise 0.02 g and poses at 100 Hz with 1 mm and 2 mrad. `REFERENCE` is that vehicle.
Times and overshoots are met within 20 %, as the table is meant.
"""

import numpy as np
import pytest

from crazychoir_fw.simulation import DroneConfig, World

DEG = np.pi / 180

REFERENCE = {
    "supply_voltage": 4.0,
    "noise": 1.0,
    "bias": 0.0,
    "mocap_latency_ms": 0,
    "mocap_std": 0.01,
    "mocap_attitude_std": 4.5e-3,
    "mocap_noise": 0.001,
    "mocap_attitude_noise": 0.002,
    "drag": "linear",
    "flight_moment": "off",
    "body_drag": 0.0,
}


def reference_world(platform="cf2", seed=1, **changes):
    # the reference has no ground effect, with which a drone lifts off in 0.37 s instead of 0.61 s
    attributes = {"vehicle": "ground_effect.enabled=off", **REFERENCE, **changes}
    return World([DroneConfig("cf1", (0.0, 0.0), platform=platform, attributes=attributes)], seed=seed)


def hovering(world, height=1.0, settle=14.0):
    """Return the drone of a world after it has taken off and settled (the vertical integrators are slow)."""
    world.wait_until_ready()
    drone = world.drones[0]
    drone.high_level_commander.takeoff(height, 2.0)
    world.run(2.0 + settle)
    return drone


def record(world, seconds, read, command=None, every=10):
    """Run and return times from the start (s) and what `read` gives at each sample; `command` is sent at 100 Hz."""
    times, values = [], []
    start = world.time
    while world.time - start < seconds - 1e-9:
        if command is not None:
            command()
        world.step(every)
        times.append(world.time - start)
        values.append(read())
    return np.array(times), np.array(values)


def rise_and_overshoot(times, values, start, goal):
    """Return the time from 10 % to 90 % (s) and the overshoot (%) of a step response."""
    fraction = (values - start) / (goal - start)
    rise = times[np.argmax(fraction >= 0.9)] - times[np.argmax(fraction >= 0.1)]
    return rise, 100 * (fraction.max() - 1)


def yaw_deg(drone):
    w, x, y, z = drone.true_quat_wxyz
    return np.degrees(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def within(value, expected, fraction=0.2, slack=0.0):
    return abs(value - expected) <= fraction * abs(expected) + slack


@pytest.mark.parametrize(("drag", "rise", "most_overshoot"), [("linear", 1.24, 1.0), ("none", 0.73, 4.0)])
def test_x_step_of_one_meter(drag, rise, most_overshoot):
    """The filter knows no drag, so that drag makes the step slower; the table gives no overshoot without drag."""
    world = reference_world(drag=drag)
    drone = hovering(world)
    times, x = record(
        world, 6.0, lambda: drone.true_position[0], lambda: drone.commander.send_position_setpoint(1.0, 0.0, 1.0, 0.0)
    )
    measured, overshoot = rise_and_overshoot(times, x, 0.0, 1.0)
    assert within(measured, rise)
    assert overshoot < most_overshoot


def test_z_step_of_half_a_meter():
    world = reference_world()
    drone = hovering(world)
    position = drone.true_position
    hold = lambda z: drone.commander.send_position_setpoint(position[0], position[1], z, 0.0)
    record(world, 12.0, lambda: None, lambda: hold(1.0))  # the change of mode resets the integrators
    start = drone.true_position[2]
    times, z = record(world, 5.0, lambda: drone.true_position[2], lambda: hold(1.5))
    rise, overshoot = rise_and_overshoot(times, z, start, start + 0.5)
    assert within(rise, 0.56)
    assert within(overshoot, 11.0, slack=1.0)


def test_yaw_step_of_45_degrees():
    world = reference_world()
    drone = hovering(world)
    times, yaw = record(
        world, 4.0, lambda: yaw_deg(drone), lambda: drone.commander.send_position_setpoint(0.0, 0.0, 1.0, 45.0)
    )
    rise, overshoot = rise_and_overshoot(times, yaw, 0.0, 45.0)
    assert within(rise, 0.34)
    assert within(overshoot, 3.2, slack=1.0)


def test_roll_step_of_10_degrees():
    world = reference_world()
    drone = hovering(world)

    def roll_deg():
        w, x, y, z = drone.true_quat_wxyz
        return np.degrees(np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)))

    level = lambda roll: drone.commander.send_zdistance_setpoint(roll, 0.0, 0.0, 1.0)
    record(world, 2.0, lambda: None, lambda: level(0.0))
    times, roll = record(world, 1.2, roll_deg, lambda: level(10.0), every=2)
    rise, overshoot = rise_and_overshoot(times, roll, roll[0], 10.0)
    assert within(rise, 0.24)
    assert within(overshoot, 5.9, slack=2.0)


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
def test_take_off_overshoots_and_comes_back(platform):
    world = reference_world(platform)
    world.wait_until_ready()
    drone = world.drones[0]
    ground = drone.true_position[2]
    drone.high_level_commander.takeoff(1.0, 2.0)
    times, z = record(world, 14.0, lambda: drone.true_position[2])
    # the table does not say how high "lifted" is; at 2 mm it is 0.66 s, the edge of the 20 %
    lift_off = times[np.argmax(z > ground + 0.0005)]
    back = times[np.flatnonzero(np.abs(z - 1.0) > 0.02)[-1]]
    # the brushless takes off with another margin between thrustBase and hover thrust
    assert within(lift_off, 0.55, slack=0.0 if platform == "cf2" else 0.15)
    if platform == "cf2":
        assert 9.0 * 0.8 <= 100 * (z.max() - 1.0) <= 10.0 * 1.2
        assert within(times[z.argmax()], 3.4)
        assert within(back, 9.7)
    assert np.abs(z[times > 12.0] - 1.0).max() < 0.012


@pytest.mark.parametrize(
    ("noise", "attitude_noise", "expected"),
    [(0.001, 0.002, (0.8, 0.6, 1.1)), (0.005, 0.010, (3.7, 3.1, 1.6)), (0.020, 0.030, (11.5, 9.8, 5.0))],
)
def test_settled_hover(noise, attitude_noise, expected):
    """RMS in mm per axis; the reference is one run of a noisy process, so x and y share the larger of their numbers."""
    world = reference_world(mocap_noise=noise, mocap_attitude_noise=attitude_noise)
    drone = hovering(world, settle=20.0)
    _, position = record(world, 30.0, lambda: drone.true_position)
    rms = 1000 * np.std(position, axis=0)
    horizontal = max(expected[:2])
    assert np.all(rms[:2] < 1.3 * horizontal + 0.3)
    assert rms[2] < 1.3 * expected[2] + 0.5


def test_flow_deck_drifts_but_holds_its_height():
    """The table says "about 0.1 m in 30 s": a random walk, here the mean of a few."""
    drifts = []
    for seed in (1, 2, 3, 4, 5):
        world = reference_world(positioning="flow", seed=seed)
        drone = hovering(world, settle=15.0)
        start = drone.true_position
        _, position = record(world, 30.0, lambda: drone.true_position)  # noqa: B023 - called at once
        drifts.append(np.linalg.norm(position[-1, :2] - start[:2]))
        assert np.std(position[:, 2]) < 0.004
    assert 0.02 < np.mean(drifts) < 0.3


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
def test_hover_for_a_minute(platform):
    """Motion capture at 100 Hz with 1 mm of noise, everything else as it comes: < 2 cm RMS and < 1 deg of yaw."""
    world = World([DroneConfig("cf1", (0.3, -0.2), platform=platform)], seed=3)
    drone = hovering(world, settle=8.0)
    _, samples = record(world, 60.0, lambda: [*drone.true_position, yaw_deg(drone), drone.log["stabilizer.thrust"]])
    error = samples[:, :3] - [0.3, -0.2, 1.0]
    assert np.sqrt(np.mean(np.sum(error**2, axis=1))) < 0.02
    assert np.abs(samples[:, 3]).max() < 1.0
    # docs/reference/vehicle.md#14.1: hover thrust before compensation, in counts
    hover = {"cf2": 38841, "cf21bl": 31582}[platform]
    assert np.mean(samples[:, 4]) == pytest.approx(hover, rel=0.03)


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
def test_landing_ends_on_the_spot_with_motors_off(platform):
    world = World([DroneConfig("cf1", (0.5, 0.5), platform=platform)], seed=5)
    drone = hovering(world, settle=4.0)
    drone.high_level_commander.land(0.0, 2.5)
    # an armed brushless idles on the floor until it disarms: landed 2 s after its last thrust, at rest 3 s later
    world.run(2.5 + 2.0 + 3.0 + 0.5)
    assert np.linalg.norm(drone.true_position[:2] - [0.5, 0.5]) < 0.05
    assert drone.true_position[2] < 0.03
    assert np.linalg.norm(drone.true_velocity) < 1e-3
    assert [drone.log[f"motor.m{i}"] for i in (1, 2, 3, 4)] == [0, 0, 0, 0]
    assert drone.failure is None
