"""Four controllers around an ideal rigid body: docs/reference/control-geometric.md#16 and #14.17.

What the sensors, the Kalman filter, the battery and drag add is flown in tests/whole_flights.
"""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from rigid_body import INERTIA, Brescianini, Indi, Lee, Mellinger, RigidBody

from crazychoir_fw._core import ffi, lib

FIGURE8 = np.loadtxt(Path(__file__).parents[1] / "planning" / "data" / "figure8.csv", delimiter=",")
DURATION = 7.28
START = (0.0, 0.0, 1.0)


# ---- steps: 1 m at once, from rest in mid-air


def settling_time(fraction: NDArray[np.float64]) -> float:
    """Return when a step response, sampled every 10 ms, is within 5 % for good (s)."""
    return 0.01 * (1 + np.flatnonzero(np.abs(fraction - 1.0) > 0.05)[-1])


# controller, overshoot (%), settling (s), dip in height (cm)
SIDEWAYS = [(Mellinger, 6, 3.5, 2), (Brescianini, 18, 2.7, 2), (Indi, 0, 2.8, 9), (Lee, 4, 1.5, 9)]
# controller, overshoot (%), settling (s)
UPWARD = [(Mellinger, 1, 0.9), (Brescianini, 0, 1.1), (Indi, 0, 2.7), (Lee, 2.5, 1.2)]


@pytest.mark.parametrize(("controller", "overshoot", "settling", "dip_cm"), SIDEWAYS)
def test_section_16_step_of_one_meter_along_x(controller, overshoot, settling, dip_cm):
    body = RigidBody(controller())
    body.hold((1.0, 0.0, 1.0))
    track = np.array(body.fly(8.0))
    assert 100 * (track[:, 0].max() - 1) == pytest.approx(overshoot, abs=0.6)
    assert settling_time(track[:, 0]) == pytest.approx(settling, abs=0.06)
    assert 100 * (1 - track[:, 2].min()) == pytest.approx(dip_cm, abs=0.6)
    assert np.abs(track[:, 1]).max() < 0.02


@pytest.mark.parametrize(("controller", "overshoot", "settling"), UPWARD)
def test_section_16_step_of_one_meter_along_z(controller, overshoot, settling):
    body = RigidBody(controller())
    body.hold((0.0, 0.0, 2.0))
    height = np.array(body.fly(8.0))[:, 2]
    assert 100 * (height.max() - 2) == pytest.approx(overshoot, abs=0.3)
    assert settling_time(height - 1.0) == pytest.approx(settling, abs=0.06)


def test_section_16_mellinger_is_28_mm_off_after_8_s_because_its_integral_is_slow():
    body = RigidBody(Mellinger())
    body.hold((1.0, 0.0, 1.0))
    assert body.fly(8.0)[-1][0] == pytest.approx(1.028, abs=0.001)


# ---- figure-8


def figure8() -> tuple:
    """Return the pieces of the planner's test trajectory; the caller keeps a reference while it uses views of them."""
    pieces = ffi.new("struct poly4d[]", len(FIGURE8))
    for piece, row in zip(pieces, FIGURE8, strict=True):
        piece.duration = row[0]
        piece.p[0], piece.p[1] = list(row[1:9]), list(row[9:17])
    return pieces


def xyz(v, scale: float = 1.0) -> dict[str, float]:
    return {"x": scale * v.x, "y": scale * v.y, "z": scale * v.z}


def follow_figure8(body: RigidBody, slowed: float = 1.0) -> NDArray[np.float64]:
    """Fly it with full-state setpoints at 100 Hz; return position minus setpoint every ms (m), shape (T, 3)."""
    pieces = figure8()
    trajectory = ffi.new("struct piecewise_traj *", [0.0, slowed, list(START), 0.0, len(pieces), pieces])
    errors = []
    for i in range(round(100 * DURATION * slowed)):
        goal, setpoint = lib.piecewise_eval(trajectory, 0.01 * i), body.setpoint
        setpoint.position, setpoint.velocity = xyz(goal.pos), xyz(goal.vel)
        setpoint.acceleration, setpoint.jerk = xyz(goal.acc), xyz(goal.jerk)
        setpoint.attitude.yaw = lib.degrees(goal.yaw)
        rates = (lib.degrees(rate) for rate in (goal.omega.x, goal.omega.y, goal.omega.z))
        setpoint.attitudeRate = dict(zip(("roll", "pitch", "yaw"), rates, strict=True))
        for _ in range(10):
            body.fly(0.001)
            errors.append(np.subtract(body.position, (goal.pos.x, goal.pos.y, goal.pos.z)))
    return np.array(errors)


# Brescianini at half speed is 11.8 mm here; the reference says 22, which nothing in its text explains.
TRACKING = [
    (Mellinger, 1.0, 7.5),
    (Mellinger, 2.0, 6.0),
    (Brescianini, 1.0, 110.0),
    (Brescianini, 2.0, 11.8),
    (Indi, 1.0, 560.0),
    (Indi, 2.0, 370.0),
    (Lee, 1.0, 3.6),
    (Lee, 2.0, 1.3),
]


@pytest.mark.parametrize(("controller", "slowed", "rms_mm"), TRACKING)
def test_section_16_figure8_is_followed_as_closely(controller, slowed, rms_mm):
    error = follow_figure8(RigidBody(controller()), slowed)
    assert 1000 * np.sqrt(np.mean(np.sum(error**2, axis=1))) == pytest.approx(rms_mm, rel=0.09)


# ---- motor lag (quirk 17)


def test_quirk_17_mellinger_loses_a_vehicle_whose_motors_know_no_lag():
    error = follow_figure8(RigidBody(Mellinger(), time_constant=0.0))
    assert np.abs(error).max() > 1.0


def test_quirk_17_a_lag_of_one_millisecond_is_enough_for_mellinger():
    error = follow_figure8(RigidBody(Mellinger(), time_constant=0.001))
    assert np.abs(error).max() < 0.03


@pytest.mark.parametrize(("controller", "most"), [(Brescianini, 0.25), (Indi, 1.2), (Lee, 0.02)])
def test_quirk_17_the_others_need_no_lag(controller, most):
    error = follow_figure8(RigidBody(controller(), time_constant=0.0))
    assert np.abs(error).max() < most


# ---- height: thrust in newtons, mass, integral


@pytest.mark.parametrize(
    ("controller", "least", "most"), [(Brescianini, -0.1, 0.1), (Indi, -0.5, 0.0), (Lee, -0.1, 0.1)]
)
def test_section_16_hover_is_where_it_should_be(controller, least, most):
    x, y, z = RigidBody(controller()).fly(5.0)[-1]
    assert least < 1000 * (z - 1.0) < most
    assert np.hypot(x, y) < 1e-4


# Mass the controller believes in, mass of the plant, thrust of one motor (N), offset (mm). The page has these after
# 5 s of hover; here they are a quarter larger then, because the integral takes kp_z / ki_z = 25 s, and agree at 12 s.
OFFSETS = [(0.029, 0.029, 0.12, -5.0), (0.027, 0.027, 0.1125, -15.0), (0.027, 0.029, 0.12, -13.0)]


@pytest.mark.parametrize(("believed", "mass", "thrust_max", "offset_mm"), OFFSETS)
def test_section_16_mellinger_hovers_low_as_its_thrust_constant_and_mass_say(believed, mass, thrust_max, offset_mm):
    controller = Mellinger()
    controller.struct.mass = believed
    body = RigidBody(controller, mass=mass)
    body.limit_thrust(thrust_max)
    heights = np.array(body.fly(12.0))[:, 2]
    assert 1000 * (heights[-1] - 1.0) == pytest.approx(offset_mm, rel=0.16)
    # what is missing in force, over the gain; then the integral
    missing = mass * 9.81 * 65535 / (132000 * 4 * thrust_max) - believed * 9.81
    assert heights[499] - 1.0 == pytest.approx(-missing / 1.25 * np.exp(-5 / 25), rel=0.03)


@pytest.mark.parametrize(("controller", "offset_mm"), [(Brescianini, -65), (Lee, -104)])
def test_section_16_without_vertical_integral_a_wrong_mass_stays_an_offset(controller, offset_mm):
    """Believing in 27 g with 29 g."""
    flown = controller()
    flown.struct.mass = 0.027
    assert 1000 * (RigidBody(flown).fly(5.0)[-1][2] - 1.0) == pytest.approx(offset_mm, abs=1.0)


@pytest.mark.parametrize(("counts_per_newton", "offset_mm"), [(132000, 101), (81919, 0)])
def test_section_16_mellinger_hovers_high_on_the_brushless_unless_told_its_thrust(counts_per_newton, offset_mm):
    """The stock constant is meant for 0.124 N per motor, and here are 0.2."""
    brushless = lib.CF_PLATFORM_CF21BL
    controller = Mellinger(brushless)
    controller.struct.massThrust = counts_per_newton
    body = RigidBody(controller, mass=0.0393, platform=brushless)
    assert 1000 * (body.fly(8.0)[-1][2] - 1.0) == pytest.approx(offset_mm, abs=1.0)


@pytest.mark.parametrize(("thrust_max", "gain"), [(0.12, 1.44), (0.1125, 1.35)])
def test_section_16_gain_of_the_rate_damping_is_above_one_without_lag(thrust_max, gain):
    """Angular acceleration that a measured one calls forth at once, per pass of the loop."""
    controller = Mellinger()
    controller.struct.kw_xy = 0.0
    control, sensors = ffi.new("control_t *"), ffi.new("sensorData_t *")
    state = ffi.new("state_t *", {"attitudeQuaternion": {"w": 1.0}})
    setpoint = ffi.new("setpoint_t *", {"mode": {"z": lib.modeAbs}})
    sensors.gyro.x = np.degrees(0.002 * 50.0)  # 50 rad/s^2 for one pass
    controller.step(control, setpoint, sensors, state, 2)

    power, motors = ffi.new("cf_power_distribution_t *"), ffi.new("motors_thrust_uncapped_t *")
    assert lib.cf_power_distribution_init(power, lib.CF_PLATFORM_CF2) == lib.CF_OK
    lib.cf_power_distribution_update(power, control, motors)
    m1, m2, m3, m4 = (motor / 65535 * thrust_max for motor in motors.list)
    torque = np.sqrt(0.5) * power.arm_length * (m3 + m4 - m1 - m2)
    assert -torque / INERTIA[0] / 50.0 == pytest.approx(gain, abs=0.01)


@pytest.mark.parametrize("yaw", [0, 90, 135, 180])
def test_section_7_4_brescianini_is_stable_at_every_heading(yaw):
    """With the product of quaternions of the release; the one before would diverge from 60 degrees on."""
    body = RigidBody(Brescianini())
    body.setpoint.attitude.yaw = yaw
    body.hold((1.0, 0.0, 1.0))
    track = np.array(body.fly(10.0))
    assert np.abs(track[-100:] - [1.0, 0.0, 1.0]).max() < 0.01
    w, _, _, z = body.quat
    assert abs((2 * np.degrees(np.arctan2(z, w)) - yaw + 180) % 360 - 180) < 0.5
