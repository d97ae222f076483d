"""The Lee controller: docs/reference/control-geometric.md#11, #12, #13.4 and #13.6."""

import math

import numpy as np
import pytest
from geometric_inputs import (
    ABS,
    DISABLE,
    MANUAL_MODES,
    QA,
    QA_YAW,
    QUAT_MODES,
    UPSTREAM_MODES,
    VELOCITY,
    YAW_RATE_MODES,
    ZERO,
    Provider,
    float32,
    make_sensors,
    make_setpoint,
    make_state,
    platforms,
    sensors,
    setpoints,
    states,
    unit_xyz,
    variable,
    variable_names,
)
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from crazychoir_fw._core import ffi, lib

F = np.float32
DT = float32(0.002)

PARAMETERS = {
    "KR_x": 0.007, "KR_y": 0.007, "KR_z": 0.008, "KI_x": 0.03, "KI_y": 0.03, "KI_z": 0.03,
    "Kw_x": 0.00115, "Kw_y": 0.00115, "Kw_z": 0.002, "J_x": 16.571710e-6, "J_y": 16.655602e-6, "J_z": 29.261652e-6,
    "Kpos_Px": 7, "Kpos_Py": 7, "Kpos_Pz": 7, "Kpos_P_limit": 100, "Kpos_Dx": 4, "Kpos_Dy": 4, "Kpos_Dz": 4,
    "Kpos_D_limit": 100, "Kpos_Ix": 0, "Kpos_Iy": 0, "Kpos_Iz": 0, "Kpos_I_limit": 2, "mass": 0.029,
}  # fmt: skip
LOGS = [
    *("KR_x", "KR_y", "KR_z", "Kw_x", "Kw_y", "Kw_z", "Kpos_Px", "Kpos_Py", "Kpos_Pz", "Kpos_Dx", "Kpos_Dy"),
    *("Kpos_Dz", "thrustSi", "torquex", "torquey", "torquez", "rpyx", "rpyy", "rpyz", "rpydx", "rpydy", "rpydz"),
    *("error_posx", "error_posy", "error_posz", "error_velx", "error_vely", "error_velz"),
    *("omegax", "omegay", "omegaz", "omegarx", "omegary", "omegarz"),
]


class Flight:
    """A controller of a vehicle of 27 g, as the reference's tables have it, and the control it writes."""

    def __init__(self, mass=0.027):
        self.lee = ffi.new("controllerLee_t *")
        lib.controllerLeeInit(self.lee)
        self.lee.mass = mass
        self.control = ffi.new("control_t *")

    def step(self, setpoint, sensors, state, step=100):
        lib.controllerLee(self.lee, self.control, setpoint, sensors, state, step)
        return self.output()

    def output(self):
        return (self.control.thrustSi, *self.control.torque)


# ---- the inputs of the tables; each returns setpoint, sensors, state ----

TRACKING = {"position": (0.1, -0.2, 1.3), "velocity": (0.05, 0, 0), "acceleration": (0.2, -0.1, 0.3)}
BEHIND = {"position": (0, 0, 1), "velocity": (0, 0.1, -0.05)}


def l1():
    return make_setpoint(UPSTREAM_MODES, quat=ZERO), make_sensors(), make_state(quat=ZERO)


def l2():
    setpoint = make_setpoint(**TRACKING, jerk=(1, 2, 3), attitude=(0, 0, 20), rate=(0, 0, -15))
    return setpoint, make_sensors((10, -20, 30)), make_state(**BEHIND, quat=QA, yaw=QA_YAW)


def l3():
    setpoint = make_setpoint(MANUAL_MODES, attitude=(12, -7, 30), thrust=32000)
    return setpoint, make_sensors(), make_state()


def l4():
    q = lib.rpy2quat(lib.mkvec(0.3, -0.1, 0.8))
    setpoint = make_setpoint(QUAT_MODES, **TRACKING, jerk=(1, 2, 3), attitude=(0, 0, 20), quat=(q.x, q.y, q.z, q.w))
    return setpoint, make_sensors((10, -20, 30)), make_state(**BEHIND, quat=QA, yaw=QA_YAW)


def l5():
    setpoint = make_setpoint(YAW_RATE_MODES, **TRACKING, attitude=(0, 0, 30), rate=(0, 0, 45))
    return setpoint, make_sensors((10, -20, 5)), make_state(**BEHIND, quat=QA, yaw=QA_YAW)


# case, call, thrust [N], torque [N m]
CASES = [
    (l1, 1, 0.264870018, (0, 0, 0)),
    (l2, 1, 0.332375824, (-3.09400116e-06, 0.00204401044, -0.00286655501)),
    (l2, 2, 0.332375824, (4.41305929e-07, 0.00205631438, -0.00287694158)),
    (l3, 1, 0.219729915, (0.00115365931, 0.00116158451, 0.00388251618)),
    (l4, 1, 0.332375824, (3.61197861e-4, 0.00188717386, 0.00114378624)),
    (l5, 1, 0.332375824, (5.02111448e-4, 0.00175056071, 0.00113063678)),
]
NAMES = [f"{case.__name__}-call{call}" for case, call, *_ in CASES]


@pytest.mark.parametrize(("case", "call", "thrust", "torque"), CASES, ids=NAMES)
def test_table_of_commands(case, call, thrust, torque):
    flight = Flight()
    flight.lee.max_thrust = 0.45
    for _ in range(call):
        output = flight.step(*case())
    assert output[0] == pytest.approx(thrust, rel=1e-7)
    # an ulp of the largest terms, which may cancel
    assert output[1:] == pytest.approx(torque, rel=1e-6, abs=2e-10)
    assert unit_xyz(flight.lee.u) == output[1:]
    assert flight.control.controlMode == lib.controlModeForceTorque


@pytest.mark.parametrize(
    ("case", "error"),
    [
        (l2, (-0.0589217842, -0.205064654, 0.173110604)),
        (l3, (-0.163407817, -0.164530382, -0.481701732)),
        (l4, (-0.102128416, -0.186084062, -0.261965632)),
        (l5, (-0.0744262338, -0.200825661, 0.0255217701)),
    ],
)
def test_table_of_rotation_errors(case, error):
    flight = Flight()
    flight.step(*case())
    # the integral of the first call is the error, times dt
    assert [i / DT for i in unit_xyz(flight.lee.i_error_att)] == pytest.approx(error, rel=1e-6, abs=1e-8)


@pytest.mark.parametrize(
    ("case", "omega_r"),
    [
        (l2, (-0.187882543, 0.170424297, -0.212040409)),
        (l4, (-0.136358172, 0.150568962, 0.0397729687)),
        (l5, (0.154573083, -0.0595660135, 0.755440116)),
    ],
)
def test_table_of_desired_rates(case, omega_r):
    flight = Flight()
    flight.step(*case())
    assert unit_xyz(flight.lee.omega_r) == pytest.approx(omega_r, rel=1e-6, abs=3e-8)


def test_table_of_angles_and_integrals():
    flight = Flight()
    flight.step(*l2())
    assert unit_xyz(flight.lee.rpy_des) == pytest.approx((0.172533333, 0.0300075281, 0.354294211), rel=1e-6)
    assert unit_xyz(flight.lee.rpy) == pytest.approx((0.1, -0.2, 0.5), rel=1e-6)
    flight.step(*l2())
    integral = (-0.000235687141, -0.000820258632, 0.000692442467)
    assert unit_xyz(flight.lee.i_error_att) == pytest.approx(integral, rel=1e-6)


def test_upstream_hover_has_no_torque_at_all():
    assert Flight().step(*l1())[1:] == (0, 0, 0)


# ---- modes ----


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_one_absolute_axis_makes_it_follow_on_all(axis):
    setpoint, gyro, state = l2()
    everything = Flight().step(setpoint, gyro, state)
    for name in "xyz":
        setattr(setpoint.mode, name, ABS if name == axis else VELOCITY)
    assert Flight().step(setpoint, gyro, state) == everything


def test_velocities_alone_are_flown_by_attitude_and_thrust():
    setpoint = make_setpoint((VELOCITY,) * 3 + (ABS,) * 3 + (DISABLE,), velocity=(1, 1, 1), thrust=32000)
    flight = Flight()
    assert flight.step(setpoint, make_sensors(), make_state())[0] == pytest.approx(32000 / 65535 * 0.48, rel=1e-6)
    # with a mode for z, even a small thrust is flown
    setpoint.thrust = 500
    assert flight.step(setpoint, make_sensors(), make_state())[0] == pytest.approx(500 / 65535 * 0.48, rel=1e-6)


@pytest.mark.parametrize(("thrust", "flies"), [(0, False), (999, False), (1000, True)])
def test_a_pilot_below_the_least_thrust_stops_everything(thrust, flies):
    flight = Flight()
    setpoint, gyro, state = l3()
    flight.step(*l2())
    setpoint.thrust = thrust
    output = flight.step(setpoint, gyro, state)
    assert (output != (0, 0, 0, 0)) == flies
    assert flight.control.controlMode == lib.controlModeForceTorque
    assert (unit_xyz(flight.lee.i_error_att) != (0, 0, 0)) == flies
    assert (unit_xyz(flight.lee.i_error_pos) != (0, 0, 0)) == flies


def test_a_pilot_leaves_the_logged_thrust():
    flight = Flight()
    flight.step(*l2())
    logged = flight.lee.thrustSi
    flight.step(*l3())
    assert flight.lee.thrustSi == logged != flight.control.thrustSi


@given(st.floats(-60, 60), st.floats(-60, 60), st.floats(-180, 180))
def test_the_attitude_of_a_pilot_has_legacy_pitch(roll, pitch, yaw):
    flight = Flight()
    setpoint = make_setpoint(MANUAL_MODES, attitude=(roll, pitch, yaw), thrust=32000)
    flight.step(setpoint, make_sensors(), make_state())
    expected = Rotation.from_euler("ZYX", (yaw, -pitch, roll), degrees=True).as_matrix()
    assert np.array([list(row) for row in flight.lee.R_des.m]) == pytest.approx(expected, abs=1e-6)


def test_without_a_heading_it_looks_along_x():
    setpoint, gyro, state = l2()
    setpoint.mode.yaw = DISABLE
    north = make_setpoint(**TRACKING, jerk=(1, 2, 3), rate=(0, 0, -15))
    assert Flight().step(setpoint, gyro, state) == Flight().step(north, gyro, state)


def test_quirk_18_rates_come_from_the_jerk_and_not_from_the_setpoint():
    setpoint, gyro, state = l2()
    expected = Flight().step(setpoint, gyro, state)
    setpoint.attitudeRate.roll, setpoint.attitudeRate.pitch = 500, -700
    assert Flight().step(setpoint, gyro, state) == expected
    setpoint.jerk.x += 1
    assert Flight().step(setpoint, gyro, state) != expected


# ---- the force ----


def test_errors_are_limited_per_axis():
    flight = Flight()
    flight.lee.Kpos_P_limit = 0.5
    flight.lee.Kpos_D_limit = 0.25
    setpoint = make_setpoint(position=(9, -9, 0.25), velocity=(9, -9, 0.125))
    flight.step(setpoint, make_sensors(), make_state())
    assert unit_xyz(flight.lee.p_error) == (0.5, -0.5, 0.25)
    assert unit_xyz(flight.lee.v_error) == (0.25, -0.25, 0.125)


def test_the_limit_of_the_integral_has_no_effect():
    flight = Flight()
    setpoint = make_setpoint(position=(50, -50, 50))
    for step in range(0, 100, 2):
        flight.step(setpoint, make_sensors(), make_state(), step)
    assert unit_xyz(flight.lee.i_error_pos) == pytest.approx((5, -5, 5), rel=1e-5)


def test_the_position_integral_acts_through_its_gain():
    flight, without = Flight(), Flight()
    flight.lee.Kpos_I.z = 2.0
    setpoint = make_setpoint(position=(0, 0, 0.5))
    more = flight.step(setpoint, make_sensors(), make_state())[0]
    assert more - without.step(setpoint, make_sensors(), make_state())[0] == pytest.approx(
        0.027 * 2.0 * 0.5 * 0.002, rel=1e-2
    )


@pytest.mark.parametrize(("acceleration", "thrust"), [(-float32(9.81), 0.0), (-9.9, 0.027 * -0.09)])
def test_a_force_that_does_not_pull_keeps_the_vehicle_level(acceleration, thrust):
    flight = Flight()
    setpoint = make_setpoint(acceleration=(0, 0, acceleration), jerk=(1, 0, 0))
    flight.step(*l2())
    output = flight.step(setpoint, make_sensors(), make_state())
    assert output[0] == pytest.approx(thrust, rel=1e-4)
    assert np.array_equal([list(row) for row in flight.lee.R_des.m], np.eye(3))
    # they start over before the attitude is integrated
    assert unit_xyz(flight.lee.i_error_pos) == (0, 0, 0)
    assert unit_xyz(flight.lee.i_error_att) == (0, 0, 0)
    if thrust == 0.0:
        assert unit_xyz(flight.lee.omega_r) == (0, 0, 0)


def test_a_force_along_the_heading_has_some_y_axis():
    flight = Flight()
    # lying on its side, body z along world x, it is asked to pull along x
    setpoint = make_setpoint(acceleration=(10, 0, -float32(9.81)))
    output = flight.step(setpoint, make_sensors(), make_state(quat=(0, math.sqrt(0.5), 0, math.sqrt(0.5))))
    assert output[0] == pytest.approx(0.27, rel=1e-6)
    assert [list(row) for row in flight.lee.R_des.m] == [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]
    assert np.isfinite(output).all()


@pytest.mark.parametrize("counts", [1e-38, 1e-30, 1e-6, 1.0])
def test_next_to_no_thrust_the_rates_stay_finite(counts):
    flight = Flight()
    setpoint = make_setpoint((VELOCITY,) * 3 + (ABS,) * 3 + (DISABLE,), jerk=(5, 6, 7), thrust=counts)
    assert np.isfinite(flight.step(setpoint, make_sensors(), make_state())).all()


def test_a_turning_body_is_told_its_gyroscopic_torque():
    flight = Flight()
    for gain in ("Komega", "KR", "KI"):
        setattr(flight.lee, gain, lib.vzero())
    rates = (200.0, -300.0, 400.0)
    output = flight.step(make_setpoint(), make_sensors(rates), make_state())
    omega = np.radians(rates)
    J = np.array([16.571710e-6, 16.655602e-6, 29.261652e-6])
    assert output[1:] == pytest.approx(tuple(np.cross(omega, J * omega)), rel=1e-5)


# ---- rates of the loop ----


def test_odd_steps_leave_everything_as_it_is():
    flight = Flight()
    even = flight.step(*l2(), step=100)
    before = bytes(ffi.buffer(flight.lee))
    flight.control.controlMode = lib.controlModeLegacy
    assert flight.step(*l5(), step=101) == even
    assert flight.control.controlMode == lib.controlModeLegacy
    assert bytes(ffi.buffer(flight.lee)) == before


# ---- init ----


def test_init_writes_everything():
    lee, fresh = ffi.new("controllerLee_t *"), ffi.new("controllerLee_t *")
    ffi.memmove(lee, b"\xa5" * ffi.sizeof(lee[0]), ffi.sizeof(lee[0]))
    lib.controllerLeeInit(lee)
    lib.controllerLeeInit(fresh)
    assert bytes(ffi.buffer(lee)) == bytes(ffi.buffer(fresh))


@pytest.mark.parametrize(
    ("platform", "mass", "thrust"), [(lib.CF_PLATFORM_CF2, 0.029, 0.48), (lib.CF_PLATFORM_CF21BL, 0.0393, 0.8)]
)
def test_the_platform_sets_mass_and_thrust(platform, mass, thrust):
    lee = ffi.new("controllerLee_t *")
    assert lib.cf_controller_lee_init(lee, platform) == lib.CF_OK
    assert (lee.mass, lee.max_thrust) == (F(mass), F(thrust))


def test_an_unknown_platform_is_refused():
    lee = ffi.new("controllerLee_t *")
    assert lib.cf_controller_lee_init(lee, lib.CF_PLATFORM_COUNT) == lib.CF_ERR_UNKNOWN
    assert lee.KR.x == 0.0


# ---- tables of variables ----


def test_parameters_have_upstream_names_and_defaults():
    lee = ffi.new("controllerLee_t *")
    lib.controllerLeeInit(lee)
    table = lib.cf_controller_lee_parameters()
    assert variable_names(table) == [f"ctrlLee.{name}" for name in PARAMETERS]
    assert {name: variable(table, lee, name) for name in PARAMETERS} == {k: F(v) for k, v in PARAMETERS.items()}
    assert {table.rows[i].flags for i in range(table.count)} == {0}


def test_logs_show_errors_rates_and_torque():
    flight = Flight()
    output = flight.step(*l2())
    table = lib.cf_controller_lee_logs()
    assert variable_names(table) == [f"ctrlLee.{name}" for name in LOGS]
    assert {table.rows[i].flags for i in range(table.count)} == {0}
    logged = {name: variable(table, flight.lee, name) for name in LOGS}
    assert (logged["thrustSi"], logged["torquex"], logged["torquey"], logged["torquez"]) == output
    assert [logged[f"error_pos{i}"] for i in "xyz"] == pytest.approx([0.1, -0.2, 0.3], rel=1e-6)
    assert [logged[f"error_vel{i}"] for i in "xyz"] == pytest.approx([0.05, -0.1, 0.05], rel=1e-6)
    assert [logged[f"omega{i}"] for i in "xyz"] == [lib.radians(10), lib.radians(-20), lib.radians(30)]
    assert [logged[f"omegar{i}"] for i in "xyz"] == list(unit_xyz(flight.lee.omega_r))
    assert [logged[f"rpy{i}"] for i in "xyz"] == pytest.approx([0.1, -0.2, 0.5], rel=1e-6)
    assert [logged[f"rpyd{i}"] for i in "xyz"] == list(unit_xyz(flight.lee.rpy_des))
    gains = [("KR_", "KR"), ("Kw_", "Komega"), ("Kpos_P", "Kpos_P"), ("Kpos_D", "Kpos_D")]
    for name, member in gains:
        assert [logged[name + i] for i in "xyz"] == list(unit_xyz(getattr(flight.lee, member)))


# ---- through the provider ----


@pytest.mark.parametrize(("case", "call", "thrust", "torque"), CASES, ids=NAMES)
def test_the_provider_flies_it(case, call, thrust, torque):
    provider = Provider()
    provider.select(lib.ControllerTypeLee)
    provider.parameter("ctrlLee.mass")[0] = 0.027
    for _ in range(call):
        control = provider.fly(*case(), 100)
    if case is l3:  # 0.12 N per motor here, 0.1125 in the table
        thrust *= 0.48 / 0.45
    assert control.thrustSi == pytest.approx(thrust, rel=1e-6)
    assert tuple(control.torque) == pytest.approx(torque, rel=1e-6, abs=2e-10)


def test_selecting_it_again_resets_the_integrals_alone():
    provider = Provider()
    provider.select(lib.ControllerTypeLee)
    provider.parameter("ctrlLee.KR_x")[0] = 0.5
    provider.fly(*l2(), 2)
    used = ffi.new("controllerLee_t *")
    size = ffi.sizeof(used[0])
    start = ffi.cast("char *", provider.parameter("ctrlLee.mass"))
    ffi.memmove(used, start, size)
    assert unit_xyz(used.i_error_att) != (0, 0, 0)

    provider.select(lib.ControllerTypePID)
    provider.select(lib.ControllerTypeLee)
    lib.controllerLeeReset(used)
    assert unit_xyz(used.i_error_att) == unit_xyz(used.i_error_pos) == (0, 0, 0)
    assert used.KR.x == 0.5
    assert bytes(ffi.buffer(start, size)) == bytes(ffi.buffer(used))


def test_a_switch_between_two_controllers_takes_effect_on_the_next_even_step():
    provider = Provider()
    provider.select(lib.ControllerTypeMellinger)
    provider.fly(*l2(), 2)
    provider.select(lib.ControllerTypeLee)
    held = bytes(ffi.buffer(provider.control))
    provider.fly(*l2(), 3)
    assert bytes(ffi.buffer(provider.control)) == held
    assert provider.fly(*l2(), 4).controlMode == lib.controlModeForceTorque


def test_hover_thrust_becomes_four_equal_motors():
    provider = Provider()
    provider.select(lib.ControllerTypeLee)
    provider.fly(*l1(), 2)
    uncapped = ffi.new("motors_thrust_uncapped_t *")
    provider.table.power_distribution(provider.block, provider.control, uncapped)
    assert list(uncapped.list) == [int(0.029 * 9.81 / 4 / 0.12 * 65535)] * 4


@given(platforms, st.lists(st.tuples(setpoints, sensors, states), min_size=1, max_size=4))
def test_finite_inputs_give_finite_commands_and_valid_motors(platform, calls):
    provider = Provider(platform)
    provider.select(lib.ControllerTypeLee)
    for i, call in enumerate(calls):
        control = provider.fly(*call, 2 * i)
        assert control.controlMode == lib.controlModeForceTorque
        assert all(math.isfinite(value) for value in (control.thrustSi, *control.torque))
        assert all(0 <= motor <= 65535 for motor in provider.motors())
