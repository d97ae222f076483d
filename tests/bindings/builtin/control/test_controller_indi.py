"""The INDI controller: docs/reference/control-geometric.md#8 to #10, #13.5 and #13.6."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

F = np.float32
DISABLE, ABS, VELOCITY = lib.modeDisable, lib.modeAbs, lib.modeVelocity


def xyz(values):
    return dict(zip("xyz", values, strict=True))


def rpy(values):
    return dict(zip(("roll", "pitch", "yaw"), values, strict=True))


class Flight:
    """The controller, the PID whose loops it shares, and what it reads and writes."""

    def __init__(self, modes=(ABS, ABS, ABS), yaw_mode=ABS, acc=(0, 0, 1), gyro=(1, 2, 3), attitude=(1, -2, 3)):
        self.indi = ffi.new("controllerINDI_t *")
        self.pid = ffi.new("cf_controller_pid_t *")
        lib.cf_controller_indi_boot(self.indi)
        assert lib.cf_controller_pid_init(self.pid, lib.CF_PLATFORM_CF2) == lib.CF_OK
        self.init()
        self.control = ffi.new("control_t *")
        self.sensors = ffi.new("sensorData_t *", {"gyro": {"axis": gyro}, "acc": {"axis": acc}})
        self.state = ffi.new("state_t *", {"attitude": rpy(attitude)})
        self.setpoint = ffi.new("setpoint_t *", {"mode": xyz(modes)})
        self.setpoint.mode.yaw = yaw_mode
        self.setpoint.attitude.yaw = 10

    def init(self):
        lib.controllerINDIInit(self.indi, self.pid)

    def step(self, step):
        lib.controllerINDI(self.indi, self.pid, self.control, self.setpoint, self.sensors, self.state, step)
        return self.output()

    def output(self):
        return (self.control.thrust, self.control.roll, self.control.pitch, self.control.yaw)

    @property
    def outer(self):
        return self.indi.position.indiOuter


def position_flight():
    """The input of I1."""
    flight = Flight()
    flight.setpoint.position = xyz((0.1, -0.2, 0.5))
    return flight


def manual_flight(yaw_mode=ABS):
    """The input of I2."""
    flight = Flight(modes=(DISABLE, DISABLE, DISABLE), yaw_mode=yaw_mode)
    flight.setpoint.thrust = 30000
    flight.setpoint.attitude.roll = 5
    flight.setpoint.attitude.pitch = -3
    return flight


# ---- reference numbers, docs/reference/control-geometric.md#13.5 and #13.6 ----


def test_filter_follows_a_step_as_the_reference():
    flight = Flight(modes=(DISABLE, DISABLE, DISABLE), gyro=(math.degrees(1), 0, 0))
    answers = []
    for step in range(0, 12, 2):
        flight.step(step)
        answers.append(flight.indi.indi.rate[0].o[0])
    expected = (0.00235720747, 0.0114514139, 0.0286612324, 0.0527488366, 0.0825756043, 0.117099702)
    assert answers == pytest.approx(expected, rel=1e-5)


def test_i1_position():
    flight = position_flight()
    expected = [
        (49684.4297, 1466, -200, -8661, 0.101932593, -0.0509348437),
        (49328.6406, 1457, -174, -8791, 0.101916395, -0.0508053899),
        (48666.1289, 1446, -142, -8660, 0.101885647, -0.0505603813),
        (47757.9102, 1437, -111, -8547, 0.101842441, -0.050217364),
    ]
    for number, (thrust, roll, pitch, yaw, phi, theta) in enumerate(expected):
        output = flight.step(2 * number)
        assert output[0] == pytest.approx(thrust, rel=1e-6)
        assert output[1:] == (roll, pitch, yaw)
        assert flight.outer.attitude_c.phi == pytest.approx(phi, rel=1e-6)
        assert flight.outer.attitude_c.theta == pytest.approx(theta, rel=1e-6)


def test_i1_increments_of_the_outer_loop():
    flight = position_flight()
    flight.step(0)
    error = flight.outer.linear_accel_err
    assert (error.x, error.y, error.z) == pytest.approx((0.499998093, 0.999999046, -12.2868767), rel=1e-6)
    assert flight.outer.phi_tilde == pytest.approx(0.101891451, rel=1e-6)
    assert flight.outer.theta_tilde == pytest.approx(-0.0508525632, rel=1e-6)
    assert flight.outer.T_tilde == pytest.approx(49684.4297, rel=1e-6)


def test_i2_manual():
    flight = manual_flight()
    outputs = [flight.step(step) for step in (0, 2, 4, 6)]
    expected = [(1200, -233, -8661), (1191, -210, -8791), (1181, -183, -8660), (1173, -160, -8547)]
    assert [output[1:] for output in outputs] == expected
    assert {output[0] for output in outputs} == {30000}


def test_i3_a_yaw_rate_barely_moves_the_yaw_target():
    """Quirk 8: the target is turned into radians again at each pass."""
    flight = manual_flight(VELOCITY)
    flight.setpoint.attitudeRate.yaw = 90
    targets, outputs = [], []
    for step in (0, 2, 4):
        outputs.append(flight.step(step)[3])
        targets.append(flight.indi.attitudeDesired.yaw)
    assert targets == pytest.approx((0.00314159272, 0.00319642387, 0.00319738081), rel=1e-6)
    assert outputs == [5179, 5444, 5591]


def test_i4_mixed_modes_and_clamped_lean():
    flight = position_flight()
    flight.setpoint.mode.y = VELOCITY
    flight.state.position = xyz((0.2, -0.1, 0.4))
    flight.state.velocity = xyz((0.3, -0.2, 0.1))
    flight.setpoint.velocity = xyz((0.1, 0.2, -0.1))
    flight.sensors.acc.axis = (0.05, -0.04, 1.1)
    first = flight.step(0)
    assert first[0] == pytest.approx(39564.5664, rel=1e-6)
    assert first[1:] == (-3549, 4990, -8661)
    error = flight.outer.linear_accel_err
    assert (error.x, error.y, error.z) == pytest.approx((-2.00115848, -2.00092578, -9.78456402), rel=1e-6)
    assert flight.outer.phi_tilde == pytest.approx(-0.204034165, rel=1e-6)
    assert flight.outer.theta_tilde == pytest.approx(0.204048574, rel=1e-6)
    assert flight.outer.attitude_c.phi == -F(0.17453292)
    assert flight.outer.attitude_c.theta == F(0.17453292)
    second = flight.step(2)
    assert second[0] == pytest.approx(39166.8164, rel=1e-6)
    assert second[1:] == (-3558, 5013, -8791)


# ---- rules of docs/reference/control-geometric.md#9 and #10 ----


def test_odd_steps_write_the_same_output_again():
    flight = position_flight()
    expected = flight.step(2)
    before = bytes(ffi.buffer(flight.indi))
    flight.sensors.gyro.axis = (100, 100, 100)
    flight.control[0] = ffi.new("control_t *")[0]
    assert flight.step(3) == expected
    assert flight.control.controlMode == lib.controlModeLegacy
    assert bytes(ffi.buffer(flight.indi)) == before


def test_rate_setpoints_replace_the_attitude_and_reset_its_pid():
    flight = manual_flight()
    flight.setpoint.mode.roll = flight.setpoint.mode.pitch = VELOCITY
    flight.setpoint.attitudeRate.roll, flight.setpoint.attitudeRate.pitch = 30, -60
    flight.pid.attitude.roll.integ = flight.pid.attitude.pitch.integ = flight.pid.attitude.yaw.integ = 5
    flight.step(2)
    desired = flight.indi.rateDesired
    assert (desired.roll, desired.pitch) == pytest.approx((math.radians(30), math.radians(-60)), rel=1e-6)
    attitude = flight.pid.attitude
    assert (attitude.roll.integ, attitude.pitch.integ, attitude.yaw.integ) == (0, 0, 5)
    assert (attitude.roll.prevMeasured, attitude.pitch.prevMeasured) == (1, -2)


def test_little_thrust_makes_the_inner_loop_forget():
    flight = manual_flight()
    flight.step(2)
    flight.setpoint.thrust = 299
    flight.pid.position.z.integ = 5
    assert flight.step(4) == (299, 0, 0, 0)
    indi = flight.indi.indi
    assert (indi.u_act_dyn.p, indi.angular_accel_ref.q, indi.u_in.r) == (0, 0, 0)
    assert flight.pid.position.z.integ == 5
    assert flight.indi.attitudeDesired.yaw == pytest.approx(-math.radians(10), rel=1e-6)


def test_no_thrust_resets_the_pid_and_takes_the_heading_in_degrees():
    flight = manual_flight()
    flight.setpoint.thrust = 0
    flight.state.position = xyz((1, 2, 3))
    flight.pid.position.z.integ = flight.pid.attitude.yaw.integ = 5
    assert flight.step(3) == (0, 0, 0, 0)
    assert (flight.pid.position.z.integ, flight.pid.attitude.yaw.integ) == (0, 0)
    assert flight.pid.position.z.prevMeasured == 3
    assert flight.indi.attitudeDesired.yaw == -3


@pytest.mark.parametrize("step", [8, 10])
def test_without_outer_loop_the_pid_position_controller_leads(step):
    """It writes degrees, at 100 Hz; with all axes in position mode they are taken for radians."""
    flight = position_flight()
    flight.indi.outerLoopActive = 0
    flight.step(step)
    assert flight.outer.T_incremented == 0

    lead = Flight().pid
    thrust, attitude = ffi.new("float *"), ffi.new("attitude_t *")
    lib.cf_position_controller_update(ffi.addressof(lead, "position"), thrust, attitude, flight.setpoint, flight.state)
    desired = flight.indi.attitudeDesired
    if step == 10:
        assert (desired.roll, desired.pitch, flight.control.thrust) == (attitude.roll, attitude.pitch, thrust[0])
        assert abs(desired.pitch) > 1
    else:
        assert (desired.roll, desired.pitch, flight.control.thrust) == (0, 0, 0)


def test_yaw_setpoint_is_taken_within_half_a_turn():
    flight = manual_flight()
    flight.setpoint.attitude.yaw = 350
    flight.step(2)
    assert flight.indi.attitudeDesired.yaw == pytest.approx(math.radians(10), rel=1e-6)


def test_quirk_18_a_rate_counts_only_where_its_mode_is_velocity():
    flight, plain = manual_flight(), manual_flight()
    flight.setpoint.attitudeRate = {"roll": 100, "pitch": 200, "yaw": 300}
    assert flight.step(2) == plain.step(2)


@pytest.mark.parametrize(
    "change",
    [
        {"velocity": {"x": 1, "y": -2, "z": 3}},
        {"acceleration": {"x": 4, "y": 5, "z": -6}},
        {"jerk": {"x": 7, "y": -8, "z": 9}},
    ],
)
def test_quirk_19_a_goal_has_no_velocity_and_no_acceleration(change):
    flight, plain = position_flight(), position_flight()
    for name, value in change.items():
        setattr(flight.setpoint, name, value)
    for step in (2, 4, 6):
        assert flight.step(step) == plain.step(step)


def test_outer_loop_runs_even_when_nobody_asks_it():
    """docs/reference/control-geometric.md#10.2: so that its filters are warm when a mode becomes absolute."""
    flight = manual_flight()
    flight.step(2)
    assert flight.outer.linear_accel_f.z != 0
    assert flight.outer.T_incremented > 0


@pytest.mark.parametrize(("height", "thrust"), [(100.0, 60000.0), (-100.0, 0.0)])
def test_thrust_of_the_outer_loop_stays_within_its_limits(height, thrust):
    """docs/reference/control-geometric.md#10.1: MIN_THRUST and MAX_THRUST."""
    flight = position_flight()
    flight.setpoint.position.z = height
    assert flight.step(2)[0] == thrust


def test_init_starts_filters_and_commands_but_keeps_targets():
    flight = position_flight()
    flight.pid.position.z.integ = 5
    for step in range(2, 12, 2):
        flight.step(step)
    kept = (flight.indi.indi.du.p, flight.indi.attitudeDesired.roll, flight.indi.actuatorThrust, flight.outer.T_inner)
    flight.init()
    indi = flight.indi.indi
    assert (indi.u_in.p, indi.u_act_dyn.q, indi.angular_accel_ref.r) == (0, 0, 0)
    assert (indi.rate[0].o[0], indi.u[1].o[0], flight.outer.ddxi[2].o[0], flight.outer.ang[0].o[0]) == (0, 0, 0, 0)
    assert flight.pid.position.z.integ == 0
    assert kept == (indi.du.p, flight.indi.attitudeDesired.roll, flight.indi.actuatorThrust, flight.outer.T_inner)


def test_a_cutoff_acts_at_the_next_init():
    flight = position_flight()
    old = [tuple(flight.indi.indi.rate[i].a) for i in range(3)]
    flight.indi.indi.filt_cutoff = 16
    flight.indi.indi.filt_cutoff_r = 4
    flight.step(2)
    assert [tuple(flight.indi.indi.rate[i].a) for i in range(3)] == old
    flight.init()
    new = [tuple(flight.indi.indi.rate[i].a) for i in range(3)]
    assert new[0] == new[1] != old[0]
    assert new[2] != old[2] != new[0]
    # pole pairs of a Butterworth low-pass
    assert new[2][1] > old[2][1] > new[0][1]


def test_a_bound_beyond_the_integers_saturates():
    flight = manual_flight()
    flight.indi.bound_control_input = 1e6
    flight.sensors.gyro.axis = (2000, -2000, 2000)
    output = flight.step(2)
    assert output[1] == -32767
    assert output[2] == -32767
    assert output[3] == 32767


def test_test_passes():
    assert lib.controllerINDITest(Flight().indi)


# ---- variables, docs/reference/control-geometric.md#9.4 and #10.3 ----


def names(table):
    return [
        f"{ffi.string(table.rows[i].group).decode()}.{ffi.string(table.rows[i].name).decode()}"
        for i in range(table.count)
    ]


def spread(stem, endings):
    return [f"{stem}_{ending}" for ending in endings]


def test_parameters_are_those_of_the_firmware():
    table = lib.cf_controller_indi_parameters()
    expected = [
        *("thrust_threshold", "bound_ctrl_input", "g1_p", "g1_q", "g1_r", "g2"),
        *("ref_err_p", "ref_err_q", "ref_err_r", "ref_rate_p", "ref_rate_q", "ref_rate_r"),
        *("act_dyn_p", "act_dyn_q", "act_dyn_r", "filt_cutoff", "filt_cutoff_r", "outerLoopActive"),
    ]
    assert names(table) == [f"ctrlINDI.{name}" for name in expected]
    assert [table.rows[i].type for i in range(table.count)] == [lib.CF_TYPE_FLOAT] * 17 + [lib.CF_TYPE_UINT8]
    assert {table.rows[i].flags for i in range(table.count)} == {0}

    outer = lib.cf_position_controller_indi_parameters()
    expected = ["K_xi_x", "K_xi_y", "K_xi_z", "K_dxi_x", "K_dxi_y", "K_dxi_z", "pq_clamping"]
    assert names(outer) == [f"posCtrlIndi.{name}" for name in expected]


def test_logs_are_those_of_the_firmware():
    expected = [
        *("cmd_thrust", "cmd_roll", "cmd_pitch", "cmd_yaw", "r_roll", "r_pitch", "r_yaw"),
        *(*spread("u_act_dyn", "pqr"), *spread("du", "pqr"), *spread("ang_accel_ref", "pqr")),
        *("rate_d[0]", "rate_d[1]", "rate_d[2]"),
        *(*spread("uf", "pqr"), *spread("Omega_f", "pqr"), *spread("n", "pqr")),
    ]
    assert names(lib.cf_controller_indi_logs()) == [f"ctrlINDI.{name}" for name in expected]

    turns = ("roll", "pitch", "yaw")
    expected = [
        *(*spread("posRef", "xyz"), *spread("velS", "xyz"), *spread("velRef", "xyz")),
        *(*spread("angS", turns), *spread("angF", turns)),
        *(*spread("accRef", "xyz"), *spread("accS", "xyz"), *spread("accF", "xyz")),
        *(*spread("accFT", "xyz"), *spread("accErr", "xyz")),
        *("phi_tilde", "theta_tilde", "T_tilde", "T_inner", "T_inner_f", "T_incremented", "cmd_phi", "cmd_theta"),
    ]
    assert names(lib.cf_position_controller_indi_logs()) == [f"posCtrlIndi.{name}" for name in expected]


def test_all_three_logs_of_the_rates_show_roll():
    """Quirk 10."""
    flight = position_flight()
    flight.step(2)
    table = lib.cf_controller_indi_logs()
    rows = {ffi.string(table.rows[i].name).decode(): table.rows[i].offset for i in range(table.count)}
    memory = bytes(ffi.buffer(flight.indi))
    values = [np.frombuffer(memory, F, 1, rows[name])[0] for name in ("r_roll", "r_pitch", "r_yaw")]
    assert values == pytest.approx([math.radians(1)] * 3, rel=1e-6)


# ---- properties ----

lengths = st.floats(-100, 100, width=32)
rates = st.floats(-2000, 2000, width=32)
leans = st.floats(-80, 80, width=32)
accelerations = st.floats(-20, 20, width=32)
triple = lambda values: st.tuples(values, values, values)
modes = st.sampled_from([DISABLE, ABS, VELOCITY])


@given(
    position=triple(lengths),
    velocity=triple(lengths),
    lean=st.tuples(leans, leans, st.floats(-180, 180, width=32)),
    gyro=triple(rates),
    acc=triple(accelerations),
    axis_modes=triple(modes),
    yaw=rates,
    thrust=st.floats(0, 65535, width=32),
)
def test_finite_inputs_give_finite_outputs(position, velocity, lean, gyro, acc, axis_modes, yaw, thrust):
    flight = Flight(modes=axis_modes, acc=acc, gyro=gyro, attitude=lean)
    flight.setpoint.position = xyz(position)
    flight.state.velocity = xyz(velocity)
    flight.setpoint.attitude.yaw = yaw
    flight.setpoint.thrust = thrust
    power = ffi.new("cf_power_distribution_t *")
    assert lib.cf_power_distribution_init(power, lib.CF_PLATFORM_CF2) == lib.CF_OK
    uncapped, pwm = ffi.new("motors_thrust_uncapped_t *"), ffi.new("motors_thrust_pwm_t *")
    for step in range(2, 30):
        output = flight.step(step)
        assert 0 <= output[0] <= 65535
        assert all(abs(value) <= 32000 for value in output[1:])
        lib.cf_power_distribution_update(power, flight.control, uncapped)
        lib.cf_power_distribution_cap(power, uncapped, pwm)
        assert all(0 <= ratio <= 65535 for ratio in pwm.list)
    memory = ffi.buffer(ffi.addressof(flight.indi.position, "indiOuter"))
    assert np.all(np.isfinite(np.frombuffer(memory, dtype=np.float32)))


@given(heading=st.floats(-180, 180, width=32), lean=leans, push=st.floats(-3, 3, width=32))
def test_outer_loop_inverts_the_effect_of_the_motors(heading, lean, push):
    """Increments times effectiveness give back the missing acceleration: G solve(e) = e."""
    flight = Flight(attitude=(lean, 0.5 * lean, heading))
    flight.setpoint.position = xyz((push, 0.2, -push))
    for step in range(2, 400, 2):
        flight.step(step)
    outer = flight.outer
    phi, theta, psi = outer.attitude_f.phi, outer.attitude_f.theta, outer.attitude_f.psi
    s_phi, c_phi, s_theta, c_theta = math.sin(phi), math.cos(phi), math.sin(theta), math.cos(theta)
    s_psi, c_psi, g = math.sin(psi), math.cos(psi), -9.81
    down = np.array(
        [s_phi * s_psi + c_phi * s_theta * c_psi, -s_phi * c_psi + c_phi * s_theta * s_psi, c_phi * c_theta]
    )
    by_phi = g * np.array(
        [c_phi * s_psi - s_phi * s_theta * c_psi, -c_phi * c_psi - s_phi * s_theta * s_psi, -s_phi * c_theta]
    )
    by_theta = g * np.array([c_phi * c_theta * c_psi, c_phi * c_theta * s_psi, -c_phi * s_theta])
    given_back = (
        by_phi * outer.phi_tilde + by_theta * outer.theta_tilde + down * (-outer.T_tilde * float(F(0.00024730)))
    )
    error = outer.linear_accel_err
    assert given_back == pytest.approx(np.array([error.x, error.y, error.z]), rel=2e-3, abs=2e-2)
