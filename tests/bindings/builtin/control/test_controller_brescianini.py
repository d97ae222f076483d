"""The controller of Brescianini: docs/reference/control-geometric.md#7, #12 and #13.3 (new quaternion product)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

DISABLE, ABS, VELOCITY = lib.modeDisable, lib.modeAbs, lib.modeVelocity
QUATERNION_B2 = (0.0472214818, 0.0298294611, 0.0984343961, 0.993574917)  # of rpy (0.1, 0.05, 0.2)
LEVEL = (0, 0, 0, 1)


def xyz(values):
    return dict(zip("xyz", values, strict=True))


class Flight:
    """The controller with what it reads and writes."""

    def __init__(self, mass=0.027, gyro=(0, 0, 0), quaternion=LEVEL, **setpoint):
        self.controller = ffi.new("controllerBrescianini_t *")
        assert lib.cf_controller_brescianini_boot(self.controller, lib.CF_PLATFORM_CF2) == lib.CF_OK
        lib.controllerBrescianiniInit(self.controller)
        self.controller.mass = mass
        self.control = ffi.new("control_t *")
        self.sensors = ffi.new("sensorData_t *", {"gyro": {"axis": gyro}})
        quat = dict(zip(("x", "y", "z", "w"), quaternion, strict=True))
        self.state = ffi.new("state_t *", {"attitudeQuaternion": quat})
        self.setpoint = ffi.new("setpoint_t *", {"mode": {"x": ABS, "y": ABS, "z": ABS, "yaw": ABS}})
        for name, value in setpoint.items():
            setattr(self, name, value)

    def reach(self, position, yaw=0.0, yaw_rate=0.0):
        self.setpoint.position = xyz(position)
        self.setpoint.attitude.yaw = yaw
        self.setpoint.attitudeRate.yaw = yaw_rate
        return self

    def step(self, step=10):
        lib.controllerBrescianini(self.controller, self.control, self.setpoint, self.sensors, self.state, step)
        return self.torque()

    def torque(self):
        return tuple(self.control.torque)


def b2():
    return Flight(gyro=(10, -5, 15), quaternion=QUATERNION_B2).reach((0.5, -0.3, 0.4), yaw=20, yaw_rate=10)


def b3():
    flight = b2()
    flight.setpoint.position = xyz((3, 2, 4))
    return flight


def b4():
    flight = b2()
    flight.controller.mixing_factor = 0.5
    return flight


def b5():
    flight = b2()
    flight.controller.mixing_factor = 0
    return flight


def b6():
    flight = b2()
    flight.sensors.gyro.axis = (0, 0, -400)
    flight.setpoint.attitude.yaw = 90
    return flight


# ---- reference numbers, docs/reference/control-geometric.md#13.3 ----


@pytest.mark.parametrize(
    ("make", "torque"),
    [
        (b2, (0.000825373339, 0.00134885928, 0.00202273065)),
        (b3, (-0.00140425842, 0.00149566017, 0.00171376066)),
        (b4, (0.000540756795, 0.00146397809, 0.00125436613)),
        (b5, (0.000464613957, 0.0014132309, 9.09481387e-05)),
        (b6, (0.00110896991, -0.000276429811, -0.0116920369)),
    ],
)
def test_torques_are_those_of_the_reference(make, torque):
    assert make().step() == pytest.approx(torque, rel=2e-6)


def test_b2_collective_and_rates():
    flight = b2()
    flight.step()
    assert flight.controller.control_thrust_accel == pytest.approx(14.3439388, rel=1e-6)
    assert flight.control.thrustSi == pytest.approx(0.387286365, rel=1e-6)
    assert tuple(flight.controller.omega) == pytest.approx((0.824866891, 0.995726585, 0.738306761), rel=2e-6)


def test_body_rates_run_at_every_step_on_the_old_command():
    flight = b2()
    flight.step(10)
    flight.sensors.gyro.x = 12
    assert flight.step(11) == pytest.approx((0.000786743301, 0.00134692783, 0.0020210552), rel=2e-6)


def test_b3_thrust_is_limited_and_the_lean_gives_way():
    flight = b3()
    flight.step()
    assert flight.controller.control_thrust_accel == pytest.approx(16.6300087, rel=1e-6)
    assert flight.control.thrustSi == pytest.approx(0.449010253, rel=1e-6)


def test_b6_a_fast_spin_is_stopped_at_the_largest_rate():
    flight = b6()
    flight.step()
    assert flight.controller.omega[2] == -10


def test_upstream_test_hovers_without_torque():
    flight = Flight()
    flight.setpoint.mode = {"x": VELOCITY, "y": VELOCITY, "z": VELOCITY, "yaw": VELOCITY}
    assert flight.step(100) == (0, 0, 0)
    assert flight.control.controlMode == lib.controlModeForceTorque
    assert flight.control.thrustSi == pytest.approx(0.264870018, rel=1e-7)  # B1


def test_hover_thrust_of_29_grams():
    """docs/reference/cffirmware-api.md#11."""
    flight = Flight(mass=0.029)
    flight.step()
    assert flight.control.thrustSi == pytest.approx(0.28449, rel=1e-5)


# ---- rules, docs/reference/control-geometric.md#7 ----


def test_quirk_12_a_yaw_rate_is_added_to_holding_the_yaw_angle_of_the_setpoint():
    held, turning = Flight(), Flight().reach((0, 0, 0), yaw_rate=90)
    for flight in (held, turning):
        flight.setpoint.mode.yaw = VELOCITY
        flight.state.attitude.yaw = 40  # the angle of the state is not looked at, its quaternion is
        flight.state.attitudeQuaternion = {"z": math.sin(math.radians(20)), "w": math.cos(math.radians(20))}
        flight.step()
    # back towards 0, 2 / tau_rp sin(half of it)
    back = -2 / 0.25 * math.sin(math.radians(20))
    assert held.controller.omega[2] == pytest.approx(back, rel=1e-5)
    assert turning.controller.omega[2] == pytest.approx(back + math.radians(90), rel=1e-5)


def test_quirk_15_an_all_zero_quaternion_is_not_level():
    flight = Flight(quaternion=(0, 0, 0, 0))
    assert all(map(math.isnan, flight.step()))


def test_quirk_18_of_the_rates_of_the_setpoint_only_yaw_counts():
    expected = b2().step()
    flight = b2()
    flight.setpoint.attitudeRate.roll, flight.setpoint.attitudeRate.pitch = 500, -700
    assert flight.step() == expected


def test_a_disabled_height_stops_the_motors():
    flight = b2()
    flight.step()
    flight.setpoint.mode.z = DISABLE
    assert flight.step(11) == (0, 0, 0)
    assert flight.control.thrustSi == 0
    assert flight.control.controlMode == lib.controlModeForceTorque


@pytest.mark.parametrize(("platform", "mass"), [(lib.CF_PLATFORM_CF2, 0.029), (lib.CF_PLATFORM_CF21BL, 0.0393)])
def test_mass_is_that_of_the_platform(platform, mass):
    controller = ffi.new("controllerBrescianini_t *")
    assert lib.cf_controller_brescianini_boot(controller, platform) == lib.CF_OK
    assert controller.mass == np.float32(mass)
    assert lib.controllerBrescianiniTest(controller)


def test_an_unknown_platform_is_refused():
    controller = ffi.new("controllerBrescianini_t *", {"tau_xy": 7})
    assert lib.cf_controller_brescianini_boot(controller, 99) == lib.CF_ERR_UNKNOWN
    assert controller.tau_xy == 7


def test_init_leaves_state_and_gains_alone():
    flight = b2()
    flight.controller.tau_xy = 0.5
    flight.step()
    before = bytes(ffi.buffer(flight.controller))
    lib.controllerBrescianiniInit(flight.controller)
    assert bytes(ffi.buffer(flight.controller)) == before


def test_straight_above_or_below_the_target_there_is_an_axis():
    """The hazard of step 5: a direction whose norm rounds to less than 1 has an angle to itself, but no axis."""
    torques = []
    for z in np.linspace(-0.8, 0.7, 151):
        flight = Flight().reach((0, 0, z))
        torques.append(flight.step())
        assert flight.control.thrustSi > 0
    torques = np.array(torques)
    assert np.all(np.abs(torques) < 5e-6)
    # it did happen
    assert 5 < np.count_nonzero(torques[:, 0]) < 50


@pytest.mark.parametrize("quaternion", [LEVEL, (0.5, 0.5, 0.5, 0.5), QUATERNION_B2])
def test_free_fall_asks_for_no_turn(quaternion):
    flight = Flight(quaternion=quaternion)
    flight.setpoint.acceleration.z = -9.81
    flight.controller.mixing_factor = 0
    flight.step()
    assert flight.controller.control_thrust_accel == 1
    assert tuple(flight.controller.omega) == pytest.approx((0, 0, 0), abs=5e-3)


def test_on_its_side_a_level_wish_asks_for_the_least_thrust():
    flight = Flight(quaternion=(0.5, 0.5, 0.5, 0.5)).reach((1, 0, 0))
    flight.setpoint.acceleration.z = -9.81
    assert all(map(math.isfinite, flight.step()))
    assert flight.controller.control_thrust_accel == 1


def test_fairness_is_limited_to_one():
    torques = []
    for fairness in (1.0, 7.0):
        flight = b3()
        flight.controller.coll_fairness = fairness
        torques.append(flight.step())
    assert torques[0] == torques[1]


def test_without_lateral_wish_the_reduction_keeps_height_alone():
    """With fairness 0 and no wish in x and y there is nothing to shrink: A is 0, and so is r."""
    flight = Flight().reach((0, 0, 10))
    flight.controller.coll_fairness = 0
    flight.state.attitudeQuaternion = {"x": math.sin(0.3), "w": math.cos(0.3)}
    flight.step()
    assert flight.controller.control_thrust_accel == 18


def test_a_tumbling_vehicle_is_stopped_on_every_axis():
    flight = Flight(gyro=(-800, 800, 0)).reach((0, 0, 0))
    flight.state.attitudeQuaternion = {"x": -0.2, "y": 0.2, "w": math.sqrt(1 - 0.08)}
    flight.step()
    # the attitude asks for positive roll and negative pitch, the spin goes the other way
    assert tuple(flight.controller.omega)[:2] == (-30, 30)


def test_upside_down_asks_for_the_least_thrust():
    flight = Flight(quaternion=(1, 0, 0, 0))
    torque = flight.step()
    assert all(map(math.isfinite, torque))
    assert flight.controller.control_thrust_accel == 1


def test_parameters_are_those_of_the_firmware():
    table = lib.cf_controller_brescianini_parameters()
    rows = [table.rows[i] for i in range(table.count)]
    memory = bytes(ffi.buffer(Flight().controller))
    values = {ffi.string(row.name).decode(): np.frombuffer(memory, np.float32, 1, row.offset)[0] for row in rows}
    expected = {"tau_xy": 0.3, "zeta_xy": 0.85, "tau_z": 0.3, "zeta_z": 0.85}
    expected |= {"tau_rp": 0.25, "mixing_factor": 1.0, "coll_fairness": 0.25}
    assert list(values) == list(expected)
    assert values == {name: np.float32(value) for name, value in expected.items()}
    assert {(ffi.string(row.group), row.type, row.flags) for row in rows} == {(b"ctrlAtt", lib.CF_TYPE_FLOAT, 0)}


# ---- properties ----

lengths = st.floats(-50, 50, width=32)
velocities = st.floats(-20, 20, width=32)
rates = st.floats(-2000, 2000, width=32)
angles = st.floats(-3.125, 3.125, width=32)
triple = lambda values: st.tuples(values, values, values)


def quaternion(roll, pitch, yaw):
    cr, sr, cp, sp = math.cos(roll / 2), math.sin(roll / 2), math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return {
        "x": sr * cp * cy - cr * sp * sy,
        "y": cr * sp * cy + sr * cp * sy,
        "z": cr * cp * sy - sr * sp * cy,
        "w": cr * cp * cy + sr * sp * sy,
    }


@given(
    position=triple(lengths),
    velocity=triple(velocities),
    acceleration=triple(velocities),
    attitude=triple(angles),
    gyro=triple(rates),
    yaw=rates,
    mixing=st.floats(-1, 2, width=32),
    fairness=st.floats(-1, 2, width=32),
)
def test_finite_inputs_give_finite_outputs(position, velocity, acceleration, attitude, gyro, yaw, mixing, fairness):
    flight = Flight(gyro=gyro).reach(position, yaw=yaw)
    flight.setpoint.velocity = xyz(velocity)
    flight.setpoint.acceleration = xyz(acceleration)
    flight.state.attitudeQuaternion = quaternion(*attitude)
    flight.controller.mixing_factor = mixing
    flight.controller.coll_fairness = fairness
    assert all(map(math.isfinite, flight.step()))
    assert 1 <= flight.controller.control_thrust_accel <= 18
    omega = np.abs(tuple(flight.controller.omega))
    assert np.all(omega <= np.array([30, 30, 10]) * (1 + 1e-6))

    power = ffi.new("cf_power_distribution_t *")
    assert lib.cf_power_distribution_init(power, lib.CF_PLATFORM_CF2) == lib.CF_OK
    uncapped, pwm = ffi.new("motors_thrust_uncapped_t *"), ffi.new("motors_thrust_pwm_t *")
    lib.cf_power_distribution_update(power, flight.control, uncapped)
    lib.cf_power_distribution_cap(power, uncapped, pwm)
    assert all(0 <= ratio <= 65535 for ratio in pwm.list)
