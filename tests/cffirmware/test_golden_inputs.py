"""Public input cases through both providers (docs/reference/cffirmware-api.md#12).

Upstream's outputs for them are not public, so each provider is the other's reference. Where a checkout of the firmware
is at hand, `crazychoir firmware parity` compares more than that.
"""

import math
from typing import NamedTuple

import numpy as np
import pytest

ZERO = (0.0, 0.0, 0.0)


class Case(NamedTuple):
    position: tuple
    velocity: tuple
    rpy: tuple
    rates: tuple
    goal: tuple
    goal_velocity: tuple
    goal_acceleration: tuple
    yaw: float
    yaw_rate: float
    repeats: int
    jerk: tuple = ZERO


CASES = {
    1: Case(ZERO, ZERO, ZERO, ZERO, ZERO, ZERO, ZERO, 0, 0, 1),
    2: Case(
        (0.1, -0.2, 0.3),
        (0.15, -0.05, 0.08),
        (0.15, -0.1, 0.2),
        (0.12, -0.08, 0.21),
        (0.5, -0.1, 0.7),
        (0.3, -0.2, 0.1),
        (0.4, -0.3, 0.2),
        35,
        12,
        3,
        (0.8, -0.5, 0.25),
    ),
    3: Case(
        (-0.15, 0.25, 0.1),
        (-0.1, 0.06, -0.03),
        (-0.12, 0.09, -0.25),
        (-0.2, 0.14, -0.18),
        (0.25, -0.35, 0.5),
        (0.2, -0.18, 0.08),
        (-0.3, 0.25, 0.15),
        -40,
        -10,
        2,
    ),
    4: Case(ZERO, ZERO, ZERO, ZERO, ZERO, ZERO, (0, 0, -20), 45, 0, 1),
    5: Case(ZERO, ZERO, ZERO, ZERO, ZERO, ZERO, (12, 0, -9.81), 0, 0, 1),
    6: Case(
        (-250, 250, -250),
        (-180, 180, -180),
        (-0.1, 0.12, -0.2),
        (-0.2, 0.15, -0.1),
        (250, -250, 250),
        (180, -180, 180),
        ZERO,
        -30,
        -8,
        1,
    ),
}


def fill(target, values):
    target.x, target.y, target.z = values


def inputs(firm, case, legacy_pitch):
    state, sensors, setpoint = firm.state_t(), firm.sensorData_t(), firm.setpoint_t()
    fill(state.position, case.position)
    fill(state.velocity, case.velocity)
    quaternion = firm.rpy2quat(firm.mkvec(*case.rpy))
    for member in "xyzw":
        setattr(state.attitudeQuaternion, member, getattr(quaternion, member))
    roll, pitch, yaw = map(math.degrees, case.rpy)
    state.attitude.roll, state.attitude.yaw = roll, yaw
    state.attitude.pitch = -pitch if legacy_pitch else pitch
    fill(sensors.gyro, map(math.degrees, case.rates))
    for member in ("x", "y", "z", "yaw"):
        setattr(setpoint.mode, member, firm.modeAbs)
    fill(setpoint.position, case.goal)
    fill(setpoint.velocity, case.goal_velocity)
    fill(setpoint.acceleration, case.goal_acceleration)
    fill(setpoint.jerk, case.jerk)
    setpoint.attitude.yaw, setpoint.attitudeRate.yaw = case.yaw, case.yaw_rate
    return setpoint, sensors, state


def vectors(struct, *names):
    return [list(getattr(struct, name)) for name in names]


def mellinger(firm, case):
    """Return everything that the controller says, call by call."""
    self, control = firm.controllerMellinger_t(), firm.control_t()
    uncapped, pwm = firm.motors_thrust_uncapped_t(), firm.motors_thrust_pwm_t()
    firm.controllerMellingerInit(self)
    said = []
    for i in range(case.repeats):
        firm.controllerMellinger(self, control, *inputs(firm, case, legacy_pitch=True), 2 * i)
        firm.powerDistribution(control, uncapped)
        said += [control.thrust, control.roll, control.pitch, control.yaw, *self.z_axis_desired]
        said += [self.i_error_x, self.i_error_y, self.i_error_z, self.i_error_m_x, self.i_error_m_y, self.i_error_m_z]
        said += [*uncapped.list, firm.powerDistributionCap(uncapped, pwm), *pwm.list]
    return np.array(said, dtype=np.float64)


def lee(firm, case):
    self, control = firm.controllerLee_t(), firm.control_t()
    firm.controllerLeeInit(self)
    said = []
    for i in range(case.repeats):
        firm.controllerLee(self, control, *inputs(firm, case, legacy_pitch=False), 2 * i)
        rows = [list(firm.mrow(self.R_des, row)) for row in range(3)]
        logs = vectors(self, "p_error", "v_error", "i_error_pos", "i_error_att", "omega", "omega_r", "u")
        said += [control.thrustSi, control.torqueX, control.torqueY, control.torqueZ, *np.ravel(rows), *np.ravel(logs)]
    return np.array(said, dtype=np.float64)


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_mellinger_agrees_between_providers(modules, number):
    builtin, bitcraze = (mellinger(make(), CASES[number]) for make in modules.values())
    # the miniature has the same formulas, perhaps in another order
    assert np.allclose(builtin, bitcraze, rtol=1e-5, atol=1e-5)
    assert np.any(builtin != 0)


@pytest.mark.parametrize("number", [1, 2, 4, 5, 6])
def test_lee_agrees_between_providers(modules, number):
    builtin, bitcraze = (lee(make(), CASES[number]) for make in modules.values())
    assert np.allclose(builtin, bitcraze, rtol=1e-5, atol=1e-6, equal_nan=True)
    assert np.any(builtin != 0)


def test_lee_limits_position_and_velocity_errors(firm):
    self, control = firm.controllerLee_t(), firm.control_t()
    firm.controllerLeeInit(self)
    firm.controllerLee(self, control, *inputs(firm, CASES[6], legacy_pitch=False), 0)
    assert all(map(math.isfinite, self.u))
    assert max(map(abs, self.p_error)) <= self.Kpos_P_limit * (1 + 1e-6)
    assert max(map(abs, self.v_error)) <= self.Kpos_D_limit * (1 + 1e-6)


def test_mellinger_forgets_when_it_shall_fall(firm):
    # collective thrust is negative
    self, control = firm.controllerMellinger_t(), firm.control_t()
    firm.controllerMellingerInit(self)
    firm.controllerMellinger(self, control, *inputs(firm, CASES[4], legacy_pitch=True), 0)
    assert control.thrust <= 0
    assert (control.roll, control.pitch, control.yaw) == (0, 0, 0)
    assert (self.i_error_x, self.i_error_y, self.i_error_z) == (0, 0, 0)
