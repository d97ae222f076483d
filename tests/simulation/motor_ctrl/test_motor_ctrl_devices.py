"""What a motor control reads of its drone."""

import numpy as np
import pytest

from crazychoir_fw.simulation import DroneConfig, MotorCtrlFPQR, MotorCtrlFRPY, World


@pytest.fixture(scope="module")
def control():
    """A drone that climbs, tilted and turned."""
    world = World([DroneConfig("cf1", yaw_deg=40.0, battery=0.7, motor_ctrl=MotorCtrlFRPY)], seed=5)
    world.wait_until_ready()
    world.run(0.2)  # the accelerometer finds its scale at rest
    control = world.drones[0].motor_ctrl
    control.drone.place((1.0, 2.0, 8.0), 40.0)
    control.command(1.1 * control.weight, 0.1, -0.15, np.radians(40.0))
    world.run(1.0)
    return control


def test_pose_is_the_true_one_in_every_form(control):
    drone = control.drone
    assert control.position.tolist() == drone.true_position.tolist()
    assert control.quat_xyzw.tolist() == [*drone.true_quat_wxyz[1:], drone.true_quat_wxyz[0]]
    assert control.rotation @ control.rotation.T == pytest.approx(np.eye(3))
    assert control.rotation.ravel() == pytest.approx(control.world.data.body("cf1").xmat, abs=0.02)
    roll, pitch, yaw = control.roll_pitch_yaw
    assert [roll, pitch] == pytest.approx([0.1, -0.15], abs=0.05)
    assert yaw == pytest.approx(np.radians(40.0), abs=0.05)
    assert -np.degrees(pitch) == pytest.approx(drone.log["stateEstimate.pitch"], abs=1.5)


def test_sensors_agree_with_the_truth_within_their_noise(control):
    pairs = []
    for _ in range(50):
        control.world.run(0.01)
        pairs.append([control.gyro - control.body_rates, control.accelerometer - control.specific_force])
    gyro, acc = np.array(pairs).transpose(1, 0, 2)
    assert np.abs(gyro.mean(axis=0)).max() < 0.02
    assert np.abs(acc.mean(axis=0)).max() < 0.5
    assert gyro.std() > 1e-4
    assert acc.std() > 1e-3


def test_a_drone_at_rest_feels_its_weight():
    world = World([DroneConfig("cf1", noise=0, motor_ctrl=MotorCtrlFPQR)])
    world.wait_until_ready()
    control = world.drones[0].motor_ctrl
    assert control.specific_force == pytest.approx([0.0, 0.0, 9.81], abs=0.02)
    assert control.accelerometer == pytest.approx([0.0, 0.0, 9.81], abs=0.3)
    assert control.weight == pytest.approx(0.029 * 9.81)


def test_motors_and_battery(control):
    assert control.rotor_thrust.sum() == pytest.approx(1.1 * control.weight, rel=0.02)
    assert np.all((control.motor_ratios > 0.3) & (control.motor_ratios < 1.0))
    assert np.all((control.rotor_rpm > 15000) & (control.rotor_rpm < 30000))
    assert 3.0 < control.battery_voltage < 4.2
    assert control.battery_charge == pytest.approx(0.7, abs=0.02)


def test_the_estimate_is_near_the_truth(control):
    # the drone was put elsewhere in one piece, which the filter had to find out
    assert control.estimated_position == pytest.approx(control.position, abs=0.15)
    assert control.estimated_velocity == pytest.approx(control.velocity, abs=0.3)
    assert control.time == control.world.time


def test_the_camera_is_that_of_the_drone_where_it_has_one(control, monkeypatch):
    monkeypatch.setattr(type(control.drone), "camera", lambda self, *what: ("own", *what), raising=False)
    assert control.camera("fpv", 64, 48) == ("own", "fpv", 64, 48)
