"""Upstream's own tests of its module, with its inputs and tolerances (docs/reference/cffirmware-api.md#10 and #11)."""

import math

import numpy as np
import pytest


def inputs(firm, mode_xy="modeVelocity"):
    """Return the all-zero setpoint, estimate and sensors of most tests of controllers."""
    setpoint, sensors, state, control = firm.setpoint_t(), firm.sensorData_t(), firm.state_t(), firm.control_t()
    setpoint.mode.z = firm.modeAbs
    setpoint.position.z = 0
    setpoint.mode.x = setpoint.mode.y = getattr(firm, mode_xy)
    setpoint.velocity.x = setpoint.velocity.y = 0
    setpoint.mode.yaw = firm.modeVelocity
    setpoint.attitudeRate.yaw = 0
    return control, setpoint, sensors, state


def test_vec_becomes_an_array(firm):
    assert np.allclose(np.array(firm.mkvec(1, 2, 3)), np.array([1, 2, 3]))


def test_zero_evaluation_is_valid(firm):
    zero = firm.traj_eval_zero()
    assert firm.is_traj_eval_valid(zero)
    for member in (zero.pos, zero.vel, zero.acc, zero.omega):
        assert np.allclose(np.array(member), np.zeros(3))
    assert zero.yaw == 0


def test_invalid_evaluation_is_not(firm):
    assert not firm.is_traj_eval_valid(firm.traj_eval_invalid())


def test_takeoff_ends_at_its_height(firm):
    planner = firm.planner()
    firm.plan_init(planner)
    firm.plan_takeoff(planner, firm.mkvec(0, 0, 0), 0, 1.0, 0, 2, 0)
    goal = firm.plan_current_goal(planner, 2)
    assert np.allclose(np.array(goal.pos), np.array([0, 0, 1.0]))
    assert np.allclose(np.array(goal.vel), np.zeros(3), atol=1e-8)


@pytest.mark.parametrize(
    ("member", "value", "expected"),
    [
        ("thrust", 10, (10, 10, 10, 10)),
        ("roll", 10, (-5, -5, 5, 5)),
        ("pitch", 12, (6, -6, -6, 6)),
        ("yaw", 20, (20, -20, 20, -20)),
    ],
)
def test_mixer(firm, member, value, expected):
    control, uncapped = firm.control_t(), firm.motors_thrust_uncapped_t()
    control.controlMode = firm.controlModeLegacy
    setattr(control, member, value)
    firm.powerDistribution(control, uncapped)
    motors = uncapped.motors
    assert (motors.m1, motors.m2, motors.m3, motors.m4) == expected


def test_mixer_in_newtons(firm):
    control, uncapped = firm.control_t(), firm.motors_thrust_uncapped_t()
    control.controlMode = firm.controlModeForceTorque
    control.thrustSi = 0.1
    firm.powerDistribution(control, uncapped)
    # a quarter of 0.1 N of at most 0.12 N per motor (docs/reference/cffirmware-api.md#11)
    assert list(uncapped.list) == [13653] * 4


@pytest.mark.parametrize(
    ("uncapped", "is_capped", "expected"),
    [
        ((1000, 2000, 3000, 4000), False, (1000, 2000, 3000, 4000)),
        ((-1000, -2000, -3000, -4000), False, (0, 0, 0, 0)),
        ((65536,) * 4, True, (65535,) * 4),
        ((65536, 65540, 65545, 65550), True, (65521, 65525, 65530, 65535)),
        ((0, 5, 1000, 65545), True, (0, 0, 990, 65535)),
    ],
)
def test_cap(firm, uncapped, is_capped, expected):
    thrust, pwm = firm.motors_thrust_uncapped_t(), firm.motors_thrust_pwm_t()
    thrust.motors.m1, thrust.motors.m2, thrust.motors.m3, thrust.motors.m4 = uncapped
    assert firm.powerDistributionCap(thrust, pwm) is is_capped
    assert (pwm.motors.m1, pwm.motors.m2, pwm.motors.m3, pwm.motors.m4) == expected


def test_controller_pid_at_rest(fresh):
    control, setpoint, sensors, state = inputs(fresh)
    fresh.controllerPidInit()
    fresh.controllerPid(control, setpoint, sensors, state, 100)
    assert control.controlMode == fresh.controlModeLegacy
    assert (control.roll, control.pitch, control.yaw) == (0, 0, 0)
    # thrust base (docs/reference/cffirmware-api.md#11)
    assert control.thrust == 36000


def test_controller_mellinger_at_rest(firm):
    control, setpoint, sensors, state = inputs(firm)
    mellinger = firm.controllerMellinger_t()
    firm.controllerMellingerInit(mellinger)
    firm.controllerMellinger(mellinger, control, setpoint, sensors, state, 100)
    assert control.controlMode == firm.controlModeLegacy
    assert (control.roll, control.pitch, control.yaw) == (0, 0, 0)
    # massThrust m g (docs/reference/cffirmware-api.md#11)
    assert control.thrust == pytest.approx(mellinger.massThrust * mellinger.mass * 9.81, rel=1e-6)
    assert (mellinger.massThrust, mellinger.mass) == (132000, pytest.approx(0.029))


def test_controller_brescianini_at_rest(fresh):
    control, setpoint, sensors, state = inputs(fresh)
    setpoint.mode.z = fresh.modeVelocity
    state.attitudeQuaternion.w = 1
    fresh.controllerBrescianiniInit()
    fresh.controllerBrescianini(control, setpoint, sensors, state, 100)
    assert control.controlMode == fresh.controlModeForceTorque
    assert (control.torqueX, control.torqueY, control.torqueZ) == (0, 0, 0)
    assert control.thrustSi == pytest.approx(9.81 * 0.029, rel=1e-6)


def test_controller_lee_at_rest(firm):
    control, setpoint, sensors, state = inputs(firm)
    lee = firm.controllerLee_t()
    firm.controllerLeeInit(lee)
    firm.controllerLee(lee, control, setpoint, sensors, state, 100)
    assert control.controlMode == firm.controlModeForceTorque
    assert (control.torqueX, control.torqueY, control.torqueZ) == (0, 0, 0)


def mellinger_in_modes(firm, x, y, z, roll=0.0, pitch=0.0):
    """Return control and controller of upstream's tests of modes: a goal beside the vehicle."""
    control, setpoint, sensors, state = firm.control_t(), firm.setpoint_t(), firm.sensorData_t(), firm.state_t()
    setpoint.mode.x, setpoint.mode.y, setpoint.mode.z = (getattr(firm, f"mode{word}") for word in (x, y, z))
    setpoint.mode.roll = setpoint.mode.pitch = setpoint.mode.yaw = firm.modeAbs
    setpoint.attitude.roll, setpoint.attitude.pitch = roll, pitch
    setpoint.thrust = 32000
    setpoint.position.x, setpoint.position.y, setpoint.position.z = 0.4, 0.3, 1.0
    state.position.z = 1.0
    state.attitudeQuaternion.w = 1
    mellinger = firm.controllerMellinger_t()
    firm.controllerMellingerInit(mellinger)
    firm.controllerMellinger(mellinger, control, setpoint, sensors, state, 100)
    assert control.controlMode == firm.controlModeLegacy
    assert all(map(math.isfinite, (control.thrust, control.roll, control.pitch, control.yaw)))
    assert all(map(math.isfinite, mellinger.z_axis_desired))
    assert control.thrust > 0
    return control, mellinger


def test_mellinger_follows_position(firm):
    _, mellinger = mellinger_in_modes(firm, "Abs", "Abs", "Abs")
    assert mellinger.z_axis_desired.x > 0
    assert mellinger.z_axis_desired.y > 0


def test_mellinger_is_flown_by_attitude(firm):
    control, mellinger = mellinger_in_modes(firm, "Disable", "Disable", "Disable", roll=12, pitch=-7)
    assert control.thrust == pytest.approx(32000, rel=1e-6)
    assert abs(mellinger.z_axis_desired.x) > 0.01
    assert abs(mellinger.z_axis_desired.y) > 0.01


@pytest.mark.parametrize("mode", ["Velocity", "Disable"])
def test_mellinger_stays_level_without_a_position(firm, mode):
    control, mellinger = mellinger_in_modes(firm, mode, mode, "Abs")
    assert np.allclose(np.array(mellinger.z_axis_desired), [0, 0, 1], atol=1e-6)
    assert (control.roll, control.pitch) == (0, 0)


@pytest.mark.parametrize(("y", "z"), [("Disable", "Abs"), ("Velocity", "Abs"), ("Abs", "Velocity"), ("Abs", "Disable")])
def test_mellinger_of_release_2026_08_looks_at_mode_x_alone(firm, y, z):
    # trees after that release ask for all three to be absolute; these rows of upstream's table are theirs
    _, mellinger = mellinger_in_modes(firm, "Abs", y, z)
    _, following = mellinger_in_modes(firm, "Abs", "Abs", "Abs")
    assert np.array_equal(np.array(mellinger.z_axis_desired)[0], np.array(following.z_axis_desired)[0])
    assert mellinger.z_axis_desired.x > 0


def test_failed_assertion_is_a_system_error(firm):
    with pytest.raises(SystemError) as caught:
        firm.assertFail("Assert in firmware (triggered from python)", "Some file", 4711)
    cause = caught.value.__cause__
    assert isinstance(cause, AssertionError)
    assert str(cause) == 'Assert in firmware (triggered from python) in File: "Some file", line 4711\n'


def test_text_of_a_failed_assertion_fits_into_150_bytes(firm):
    with pytest.raises(SystemError) as caught:
        firm.assertFail("x" * 500, "file", 1)
    assert str(caught.value.__cause__) == "x" * 149


# docs/reference/cffirmware-api.md#11: coefficients of the take-off, and the way there


def test_takeoff_polynomial_is_exact(firm):
    planner = firm.planner()
    firm.plan_init(planner)
    firm.plan_takeoff(planner, firm.mkvec(0, 0, 0), 0, 1.0, 0, 2, 0)
    piece = firm.piecewise_get(planner.trajectory, 0)
    assert [firm.poly4d_get(piece, 2, power) for power in range(8)] == [0, 0, 0, 0, 2.1875, -2.625, 1.09375, -0.15625]
    halfway = firm.plan_current_goal(planner, 1)
    assert (halfway.pos.z, halfway.vel.z) == (0.5, 1.09375)


def test_zero_quaternion_is_the_identity(firm):
    rotation = firm.quat2rotmat(firm.mkquat(0, 0, 0, 0))
    assert np.array_equal(rotation.m, np.eye(3))


def test_torques_are_mixed_by_sign(firm):
    control, uncapped = firm.control_t(), firm.motors_thrust_uncapped_t()
    control.controlMode = firm.controlModeForceTorque

    def motors(**torques):
        control.torqueX = control.torqueY = control.torqueZ = 0
        control.thrustSi = 0.2
        firm.powerDistribution(control, uncapped)
        level = uncapped.list.copy()
        for name, value in torques.items():
            setattr(control, name, value)
        firm.powerDistribution(control, uncapped)
        return np.sign(uncapped.list - level).tolist()

    assert motors(torqueX=1e-4) == [-1, -1, 1, 1]
    assert motors(torqueY=1e-4) == [-1, 1, 1, -1]
    assert motors(torqueZ=1e-5) == [-1, 1, -1, 1]


def test_forces_are_mixed_one_by_one(firm):
    control, uncapped = firm.control_t(), firm.motors_thrust_uncapped_t()
    control.controlMode = firm.controlModeForce
    control.normalizedForces = [0, 0.5, 1, 2]
    firm.powerDistribution(control, uncapped)
    assert list(uncapped.list) == [0, 32767, 65535, 65535]
