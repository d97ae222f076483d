"""The PID cascade: rules and worked vectors of docs/reference/control-pid.md#11 and #19."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

F = np.float32
DISABLE, ABS, VELOCITY = lib.modeDisable, lib.modeAbs, lib.modeVelocity
MODE_NAMES = ("x", "y", "z", "roll", "pitch", "yaw", "quat")

# modes as x, y, z, roll, pitch, yaw, quat
POSITION_MODES = (1, 1, 1, 0, 0, 1, 0)
MANUAL_MODES = (0, 0, 0, 1, 1, 2, 0)
RATE_MODES = (0, 0, 0, 2, 2, 2, 0)

LOGS = [
    f"controller.{name}"
    for name in (
        *("cmd_thrust", "cmd_roll", "cmd_pitch", "cmd_yaw", "r_roll", "r_pitch", "r_yaw", "accelz"),
        *("actuatorThrust", "roll", "pitch", "yaw", "rollRate", "pitchRate", "yawRate"),
    )
]


def xyz(values):
    return dict(zip("xyz", values, strict=True))


def rpy(values):
    return dict(zip(("roll", "pitch", "yaw"), values, strict=True))


def make_setpoint(modes, position=(0, 0, 0), attitude=(0, 0, 0), rate=(0, 0, 0), thrust=0.0, quat_xyzw=(0, 0, 0, 1)):
    fields = {
        "mode": dict(zip(MODE_NAMES, modes, strict=True)),
        "position": xyz(position),
        "attitude": rpy(attitude),
        "attitudeRate": rpy(rate),
        "attitudeQuaternion": dict(zip(("x", "y", "z", "w"), quat_xyzw, strict=True)),
        "thrust": thrust,
    }
    return ffi.new("setpoint_t *", fields)


def make_state(position=(0, 0, 0), velocity=(0, 0, 0), attitude=(0, 0, 0)):
    return ffi.new("state_t *", {"position": xyz(position), "velocity": xyz(velocity), "attitude": rpy(attitude)})


class Flight:
    """A controller with the control it writes, the state and the gyro it reads."""

    def __init__(self, platform=lib.CF_PLATFORM_CF2, gyro=(0, 0, 0), state=None):
        self.pid = ffi.new("cf_controller_pid_t *")
        assert lib.cf_controller_pid_init(self.pid, platform) == lib.CF_OK
        self.control = ffi.new("control_t *")
        self.sensors = ffi.new("sensorData_t *", {"gyro": {"axis": gyro}, "acc": {"axis": (0, 0, 1)}})
        self.state = state or make_state()

    def step(self, setpoint, step):
        lib.cf_controller_pid_update(self.pid, self.control, setpoint, self.sensors, self.state, step)
        return self.output()

    def run(self, setpoint, first, last):
        for step in range(first, last + 1):
            self.step(setpoint, step)
        return self.output()

    def output(self):
        return (self.control.roll, self.control.pitch, self.control.yaw, self.control.thrust)


def assert_output(output, expected):
    """Compare as the reference allows: counts within 1, thrust in float32."""
    assert output[:3] == pytest.approx(expected[:3], abs=1, rel=0)
    assert output[3] == pytest.approx(expected[3], rel=1e-6)


# ---- worked vectors, docs/reference/control-pid.md#19 ----


def test_case_a_hover_asks_for_the_base_thrust():
    flight = Flight()
    # also the upstream test of docs/reference/control-pid.md#18
    assert flight.step(make_setpoint((2, 2, 1, 0, 0, 2, 0)), 100) == (0, 0, 0, 36000.0)
    assert flight.control.controlMode == lib.controlModeLegacy


def test_case_b_a_far_goal_saturates_the_lean():
    flight = Flight(state=make_state(position=(0, 0, 0.5)))
    output = flight.step(make_setpoint(POSITION_MODES, position=(1, 0, 1)), 100)
    assert_output(output, (0, -30150, 0, 61212.875))
    assert flight.pid.attitude_desired.pitch == -20.0
    assert flight.pid.rate_desired.pitch == pytest.approx(-120.12, rel=1e-6)


def test_case_c_a_near_goal():
    flight = Flight(state=make_state(position=(0, 0, 0.98)))
    output = flight.step(make_setpoint(POSITION_MODES, position=(0.1, -0.05, 1)), 100)
    assert_output(output, (3770, -7540, 0, 37008.516))
    desired, rate = flight.pid.attitude_desired, flight.pid.rate_desired
    assert (desired.roll, desired.pitch) == pytest.approx((2.501, -5.002), rel=1e-5)
    assert (rate.roll, rate.pitch) == pytest.approx((15.021006, -30.042011), rel=1e-6)


def test_case_d_turned_by_a_quarter():
    flight = Flight(gyro=(3, 4, -5), state=make_state((0, 0, 0.98), attitude=(1, -2, 90)))
    output = flight.step(make_setpoint(POSITION_MODES, (0.1, -0.05, 1), (0, 0, 90)), 100)
    assert_output(output, (1530, 12789, -600, 37008.516))
    desired, rate = flight.pid.attitude_desired, flight.pid.rate_desired
    assert (desired.roll, desired.pitch) == pytest.approx((5.002, 2.501), rel=1e-5)
    assert (rate.roll, rate.pitch, rate.yaw) == pytest.approx((24.036011, 27.033009, 0), rel=1e-6)


@pytest.mark.parametrize(
    ("last", "output", "desired"),
    [
        (1, (0, 0, 0, 0), (1, -2)),
        (9, (0, 0, 0, 0), (1, -2)),
        (10, (-16949, 13760, -11406, 39523.516), (-7.256473, 3.145412)),
        (12, (-13264, 8803, -11413, 39523.516), (-7.256473, 3.145412)),
        (20, (-13529, 8976, -11440, 39547.043), (-7.259374, 3.146669)),
        (100, (-16218, 10729, -11712, 39735.824), (-7.282586, 3.156731)),
        (200, (-19700, 12994, -12054, 39973.148), (-7.311600, 3.169307)),
    ],
)
def test_case_e_two_hundred_consecutive_steps(last, output, desired):
    state = make_state((0, 0, 0.98), (0.1, 0.2, -0.1), (1, -2, 175))
    flight = Flight(gyro=(3, 4, -5), state=state)
    setpoint = make_setpoint(POSITION_MODES, (0.1, -0.05, 1), (0, 0, -170))
    assert_output(flight.run(setpoint, 1, last), output)
    asked = flight.pid.attitude_desired
    assert (asked.roll, asked.pitch) == pytest.approx(desired, rel=1e-6)


def test_case_e_yaw_goes_the_short_way_round():
    flight = Flight(gyro=(3, 4, -5), state=make_state((0, 0, 0.98), (0.1, 0.2, -0.1), (1, -2, 175)))
    flight.run(make_setpoint(POSITION_MODES, (0.1, -0.05, 1), (0, 0, -170)), 1, 10)
    # 15 degrees, after the reset at step 9: 6 * 15 + 1 * 15 * 0.002
    assert flight.pid.rate_desired.yaw == pytest.approx(90.03, rel=1e-6)


@pytest.mark.parametrize(
    ("last", "output"),
    [
        (1, (0, 0, 0, 0)),
        (2, (6036, -1520, 316, 30000)),
        (3, (6036, -1520, 316, 30000)),
        (4, (7323, -4041, 273, 30000)),
        (10, (7432, -4102, 144, 30000)),
    ],
)
def test_case_f_manual_attitude(last, output):
    flight = Flight(gyro=(1, 2, 3))
    setpoint = make_setpoint(MANUAL_MODES, attitude=(5, -3, 0), rate=(0, 0, 30), thrust=30000)
    assert_output(flight.run(setpoint, 1, last), output)


@pytest.mark.parametrize(
    ("last", "output"),
    [(2, (8589, -1114, 316, 30000)), (4, (9878, -3628, 273, 30000)), (10, (9996, -3672, 144, 30000))],
)
def test_case_g_manual_rates_of_the_brushless_platform(last, output):
    flight = Flight(platform=lib.CF_PLATFORM_CF21BL, gyro=(1, 2, 3))
    setpoint = make_setpoint(RATE_MODES, rate=(50, -20, 30), thrust=30000)
    assert_output(flight.run(setpoint, 1, last), output)


# ---- rules of docs/reference/control-pid.md#11 ----


def test_an_unknown_platform_is_refused():
    pid = ffi.new("cf_controller_pid_t *")
    assert lib.cf_controller_pid_init(pid, lib.CF_PLATFORM_COUNT) == lib.CF_ERR_UNKNOWN


def test_boot_overwrites_everything():
    pid = ffi.new("cf_controller_pid_t *")
    ffi.memmove(pid, b"\xa5" * ffi.sizeof(pid[0]), ffi.sizeof(pid[0]))
    lib.cf_controller_pid_init(pid, lib.CF_PLATFORM_CF2)
    setpoint = make_setpoint(POSITION_MODES, (1, 0, 1))
    used, fresh = Flight(), Flight()
    used.pid = pid
    assert used.run(setpoint, 1, 30) == fresh.run(setpoint, 1, 30)


def test_a_copy_of_the_struct_flies_on_alike():
    flight, twin = Flight(gyro=(3, 4, -5)), Flight(gyro=(3, 4, -5))
    setpoint = make_setpoint(POSITION_MODES, (0.1, -0.05, 0.2), (0, 0, 20))
    flight.run(setpoint, 1, 57)
    ffi.memmove(twin.pid, flight.pid, ffi.sizeof(flight.pid[0]))
    ffi.memmove(twin.control, flight.control, ffi.sizeof(flight.control[0]))
    assert flight.run(setpoint, 58, 120) == twin.run(setpoint, 58, 120)
    assert bytes(ffi.buffer(flight.pid)) == bytes(ffi.buffer(twin.pid))


def test_outputs_are_held_on_odd_steps():
    flight = Flight()
    setpoint = make_setpoint(POSITION_MODES, (0.1, 0, 0))
    even = flight.run(setpoint, 1, 10)
    flight.sensors.gyro.x = 50.0
    assert flight.step(setpoint, 11) == even
    assert flight.step(setpoint, 12) != even


def test_thrust_of_zero_forgets_everything():
    flight = Flight(gyro=(5, 5, 5), state=make_state(attitude=(3, 4, 50)))
    flight.run(make_setpoint(POSITION_MODES, (0.1, 0, 0.5), (0, 0, 60)), 1, 100)
    assert flight.pid.position.z.integ != 0.0
    assert flight.run(make_setpoint((0,) * 7), 101, 102) == (0, 0, 0, 0.0)

    pid = flight.pid
    loops = [pid.position.z, pid.position.vz, pid.attitude.roll, pid.attitude.yaw, pid.attitude.roll_rate]
    assert [loop.integ for loop in loops] == [0.0] * 5
    assert pid.position.vz.dFilter.delay_element_1 == 0.0
    assert (pid.attitude_desired.roll, pid.attitude_desired.pitch, pid.attitude_desired.yaw) == (3, 4, 50)
    assert (pid.cmd_thrust, pid.cmd_roll, pid.cmd_pitch, pid.cmd_yaw) == (0, 0, 0, 0)


@pytest.mark.parametrize("changed", MODE_NAMES)
def test_any_changed_mode_resets_the_loops(changed):
    flight = Flight()
    flight.state.position.z = 0.5
    flight.run(make_setpoint((2, 2, 1, 0, 0, 2, 0), (0, 0, 1)), 1, 100)
    assert flight.pid.position.vz.integ != 0.0

    modes = dict(zip(MODE_NAMES, (2, 2, 1, 0, 0, 2, 0), strict=True))
    modes[changed] = (modes[changed] + 1) % 3
    before = flight.output()
    # an odd step: the PIDs are reset, the outputs stay
    assert flight.step(make_setpoint(tuple(modes.values()), (0, 0, 1)), 101) == before
    assert flight.pid.position.vz.integ == 0.0
    assert flight.pid.position.z.prevMeasured == 0.5


def test_equal_modes_keep_the_integrals():
    flight = Flight()
    flight.run(make_setpoint(POSITION_MODES, (0, 0, 1)), 1, 100)
    integral = flight.pid.position.vz.integ
    flight.step(make_setpoint(POSITION_MODES, (0, 0, 2)), 101)
    assert flight.pid.position.vz.integ == integral != 0.0


def test_a_mode_change_in_flight_falls_back_to_the_base_thrust():
    flight = Flight()
    setpoint = make_setpoint(POSITION_MODES, (0, 0, 0.1))
    flight.run(setpoint, 1, 1000)
    flight.step(make_setpoint((2, 2, 1, 0, 0, 2, 0), (0, 0, 0)), 1010)
    assert flight.control.thrust == 36000.0


def test_a_first_call_with_modes_resets_to_the_present_attitude():
    flight = Flight(state=make_state(attitude=(1, 2, 3)))
    flight.step(make_setpoint(POSITION_MODES), 1)
    assert flight.pid.attitude.roll.prevMeasured == 1.0
    assert (flight.pid.attitude_desired.roll, flight.pid.attitude_desired.pitch) == (1.0, 2.0)


def test_switching_to_manual_keeps_the_thrust_until_the_next_even_step():
    flight = Flight()
    flight.run(make_setpoint(POSITION_MODES), 1, 10)
    manual = make_setpoint(MANUAL_MODES, thrust=12345)
    assert flight.step(manual, 11)[3] == 36000.0
    assert flight.step(manual, 12)[3] == 12345.0


@pytest.mark.parametrize(("modes", "manual"), [((0, 1, 1), True), ((1, 0, 1), True), ((1, 1, 1), False)])
def test_one_disabled_horizontal_axis_hands_the_lean_to_the_setpoint(modes, manual):
    flight = Flight()
    setpoint = make_setpoint((*modes, 1, 1, 1, 0), attitude=(7, 8, 0))
    flight.run(setpoint, 1, 10)
    lean = (flight.pid.attitude_desired.roll, flight.pid.attitude_desired.pitch)
    assert (lean == (7.0, 8.0)) == manual


def test_the_gyro_pitch_is_negated_and_so_is_the_yaw_output():
    flight = Flight(gyro=(0, 10, 10))
    roll, pitch, yaw, _ = flight.run(make_setpoint(RATE_MODES, thrust=30000), 1, 2)
    # what turns nose down (right-handed) is answered by nose up, what turns left by clockwise
    assert roll == 0
    assert pitch > 0
    assert yaw > 0


@pytest.mark.parametrize("axis", range(3))
def test_moment_that_is_not_a_number_makes_the_thrust_none(axis):
    """Whole numbers cannot show it; the loop around stops a drone whose thrust is not a number."""
    flight = Flight()
    flight.sensors.gyro.axis[axis] = math.nan
    output = flight.run(make_setpoint(RATE_MODES, thrust=30000), 1, 2)
    assert output[axis] == 0
    assert math.isnan(output[3])


def test_rate_mode_overrules_an_angle_loop_that_keeps_integrating():
    flight = Flight(state=make_state(attitude=(10, 0, 0)))
    flight.run(make_setpoint(RATE_MODES, rate=(25, 35, 0), thrust=30000), 1, 40)
    assert (flight.pid.rate_desired.roll, flight.pid.rate_desired.pitch) == (25.0, 35.0)
    assert flight.pid.attitude.roll.integ < 0.0


# ---- the yaw target ----


def yaw_target(start, setpoint, max_delta=0.0, yaw=0.0):
    flight = Flight(state=make_state(attitude=(0, 0, yaw)))
    flight.run(make_setpoint(setpoint_modes(setpoint), thrust=30000), 1, 2)
    flight.pid.attitude_desired.yaw = start
    flight.pid.attitude.yaw_max_delta = max_delta
    flight.step(setpoint, 4)
    return flight.pid.attitude_desired.yaw


def setpoint_modes(setpoint):
    return tuple(getattr(setpoint.mode, name) for name in MODE_NAMES)


def yaw_setpoint(yaw_mode, quat_mode=DISABLE, **kwargs):
    return make_setpoint((0, 0, 0, 1, 1, yaw_mode, quat_mode), thrust=30000, **kwargs)


@pytest.mark.parametrize(
    ("start", "rate", "target"),
    [(0, 50, 0.1), (179.95, 50, -179.95), (-179.95, -50, 179.95), (180, 0, 180), (-180, 0, -180)],
)
def test_a_yaw_rate_turns_the_target(start, rate, target):
    assert yaw_target(start, yaw_setpoint(VELOCITY, rate=(0, 0, rate))) == pytest.approx(target, rel=1e-5)


@pytest.mark.parametrize(
    ("start", "yaw", "target"), [(50, 0, 30), (-50, 0, -30), (20, 0, 20), (-170, 170, -170), (-150, 170, 200 - 360)]
)
def test_the_target_runs_ahead_by_at_most_the_parameter(start, yaw, target):
    assert yaw_target(start, yaw_setpoint(VELOCITY), max_delta=30.0, yaw=yaw) == pytest.approx(target, rel=1e-6)


@pytest.mark.parametrize(
    ("angle", "target"),
    [(90, 90), (270, -90), (540, 180), (-540, -180), (900, 180), (-190, 170), (3690, 90), (180, 180), (-180, -180)],
)
def test_an_absolute_yaw_is_capped_to_half_a_turn(angle, target):
    assert yaw_target(5.0, yaw_setpoint(ABS, attitude=(0, 0, angle))) == target


@given(angle=st.floats(-20000, 20000, width=32))
def test_capping_equals_taking_turn_by_turn(angle):
    turned = F(angle)
    while turned > F(180):
        turned -= F(360)
    while turned < F(-180):
        turned += F(360)
    assert yaw_target(5.0, yaw_setpoint(ABS, attitude=(0, 0, angle))) == turned


@given(yaw=st.floats(-179, 179), lean=st.floats(-60, 60))
def test_only_the_yaw_of_a_quaternion_setpoint_counts(yaw, lean):
    half_yaw, half_lean = math.radians(yaw) / 2, math.radians(lean) / 2
    quat_xyzw = (
        -math.sin(half_yaw) * math.sin(half_lean),
        math.cos(half_yaw) * math.sin(half_lean),
        math.sin(half_yaw) * math.cos(half_lean),
        math.cos(half_yaw) * math.cos(half_lean),
    )
    setpoint = yaw_setpoint(DISABLE, ABS, quat_xyzw=quat_xyzw, attitude=(1, 2, 0))
    assert yaw_target(5.0, setpoint) == pytest.approx(yaw, abs=1e-3)


def test_without_a_yaw_mode_the_target_stays():
    assert yaw_target(5.0, yaw_setpoint(DISABLE, attitude=(0, 0, 77))) == 5.0


# ---- selecting the controller again ----


def test_reinit_starts_the_position_loops_over_and_leaves_the_attitude_loops():
    flight = Flight(gyro=(1, 2, 3))
    setpoint = make_setpoint(POSITION_MODES, (0.1, 0.1, 0.5))
    flight.run(setpoint, 1, 100)
    flight.pid.position.z.kp = 3.0
    roll_integral, thrust = flight.pid.attitude.roll.integ, flight.pid.actuator_thrust

    lib.cf_controller_pid_reinit(flight.pid)
    assert (flight.pid.position.z.integ, flight.pid.position.vz.integ) == (0.0, 0.0)
    assert flight.pid.position.z.kp == 3.0
    assert flight.pid.attitude.roll.integ == roll_integral != 0.0
    assert flight.pid.actuator_thrust == thrust
    assert flight.pid.previous_mode.x == ABS


# ---- logs ----


def log(flight, name):
    table = lib.cf_controller_pid_logs()
    row = next(row for row in (table.rows[i] for i in range(table.count)) if ffi.string(row.name) == name.encode())
    return ffi.cast("float *", ffi.cast("char *", flight.pid) + row.offset)[0]


def test_log_table_lists_names_in_order():
    table = lib.cf_controller_pid_logs()
    rows = [table.rows[i] for i in range(table.count)]
    assert [f"{ffi.string(row.group).decode()}.{ffi.string(row.name).decode()}" for row in rows] == LOGS
    assert {(row.type, row.flags) for row in rows} == {(lib.CF_TYPE_FLOAT, 0)}


def test_logs_show_commands_rates_and_targets():
    flight = Flight(gyro=(10, 20, 30))
    setpoint = make_setpoint(MANUAL_MODES, attitude=(5, -3, 0), rate=(0, 0, 30), thrust=30000)
    roll, pitch, yaw, _ = flight.run(setpoint, 1, 2)
    assert (log(flight, "cmd_roll"), log(flight, "cmd_pitch"), log(flight, "cmd_yaw")) == (roll, pitch, yaw)
    rates = (log(flight, "r_roll"), log(flight, "r_pitch"), log(flight, "r_yaw"))
    assert rates == pytest.approx(tuple(math.radians(rate) for rate in (10, -20, 30)), rel=1e-6)
    assert (log(flight, "accelz"), log(flight, "actuatorThrust")) == (1.0, 30000.0)
    assert (log(flight, "roll"), log(flight, "pitch")) == (5.0, -3.0)
    assert log(flight, "rollRate") == flight.pid.rate_desired.roll


def test_the_logged_thrust_is_one_call_late():
    flight = Flight()
    flight.run(make_setpoint(MANUAL_MODES, thrust=30000), 1, 4)
    flight.step(make_setpoint(MANUAL_MODES, thrust=40000), 6)
    assert (log(flight, "cmd_thrust"), flight.control.thrust) == (30000.0, 40000.0)
