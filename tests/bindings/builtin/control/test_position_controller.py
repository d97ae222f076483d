"""Position and velocity loops (docs/reference/control-pid.md#10 and #17)."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

LOOPS = ("x", "y", "z", "vx", "vy", "vz")
ABS, VELOCITY = lib.modeAbs, lib.modeVelocity

PARAMETERS = [
    *[
        (f"velCtlPid.{axis}{gain}", lib.CF_TYPE_FLOAT)
        for axis in ("vx", "vy", "vz")
        for gain in ("Kp", "Ki", "Kd", "KFF")
    ],
    *[(f"posCtlPid.{axis}{gain}", lib.CF_TYPE_FLOAT) for axis in ("x", "y", "z") for gain in ("Kp", "Ki", "Kd", "Kff")],
    ("posCtlPid.thrustBase", lib.CF_TYPE_UINT16),
    ("posCtlPid.thrustMin", lib.CF_TYPE_UINT16),
    *[(f"posCtlPid.{name}", lib.CF_TYPE_FLOAT) for name in ("rLimit", "pLimit", "xVelMax", "yVelMax", "zVelMax")],
]
LOGS = [
    *[f"posCtl.{name}" for name in ("targetVX", "targetVY", "targetVZ", "targetX", "targetY", "targetZ")],
    *[f"posCtl.{name}" for name in ("bodyVX", "bodyVY", "bodyX", "bodyY")],
    *[f"posCtl.{axis}{term}" for axis in ("X", "Y", "Z", "VX", "VY", "VZ") for term in ("p", "i", "d", "ff")],
]


def make_position(platform=lib.CF_PLATFORM_CF2):
    controller = ffi.new("cf_position_controller_t *")
    lib.cf_position_controller_init(controller, lib.cf_platform_defaults(platform))
    return controller


@pytest.fixture
def position():
    return make_position()


def make_setpoint(position=(0, 0, 0), velocity=(0, 0, 0), mode=ABS, velocity_body=False):
    xyz = "xyz"
    return ffi.new(
        "setpoint_t *",
        {
            "position": dict(zip(xyz, position, strict=True)),
            "velocity": dict(zip(xyz, velocity, strict=True)),
            "mode": dict.fromkeys(xyz, mode),
            "velocity_body": velocity_body,
        },
    )


def make_state(position=(0, 0, 0), velocity=(0, 0, 0), yaw=0.0):
    xyz = "xyz"
    return ffi.new(
        "state_t *",
        {
            "position": dict(zip(xyz, position, strict=True)),
            "velocity": dict(zip(xyz, velocity, strict=True)),
            "attitude": {"yaw": yaw},
        },
    )


def update(controller, setpoint, state):
    thrust, attitude = ffi.new("float *"), ffi.new("attitude_t *")
    lib.cf_position_controller_update(controller, thrust, attitude, setpoint, state)
    return attitude.roll, attitude.pitch, thrust[0]


def rows(table):
    return [table.rows[i] for i in range(table.count)]


def full_name(row):
    return f"{ffi.string(row.group).decode()}.{ffi.string(row.name).decode()}"


def test_boot_sets_period_limits_and_filters(position):
    for loop in LOOPS:
        pid = getattr(position, loop)
        assert pid.dt == pytest.approx(0.01)
        assert (pid.iLimit, pid.outputLimit, pid.enableDFilter) == (5000.0, 0.0, True)
        assert pid.dFilter.b0 == pytest.approx(0.20657209, rel=1e-6)


def test_hover_on_the_spot_asks_for_the_base_thrust(position):
    assert update(position, make_setpoint(), make_state()) == (0.0, 0.0, 36000.0)


def test_the_brushless_platform_starts_lower():
    assert update(make_position(lib.CF_PLATFORM_CF21BL), make_setpoint(), make_state()) == (0.0, 0.0, 30000.0)


def test_forward_and_left_lean_by_the_legacy_signs(position):
    roll, pitch, _ = update(position, make_setpoint(position=(0.1, 0.1, 0)), make_state())
    assert pitch < 0.0
    assert roll < 0.0


def test_lean_is_limited_to_the_parameter(position):
    position.roll_max, position.pitch_max = 15.0, 10.0
    roll, pitch, _ = update(position, make_setpoint(position=(-10, -10, 0)), make_state())
    assert (roll, pitch) == (15.0, 10.0)
    assert (position.vx.outputLimit, position.vy.outputLimit) == pytest.approx((11.0, 16.5))


def test_position_loops_ask_for_at_most_the_limits_and_a_tenth(position):
    position.velocity_z_max = 0.1
    update(position, make_setpoint(position=(10, 10, 10)), make_state())
    assert position.vx.desired == pytest.approx(1.1)
    assert position.vy.desired == pytest.approx(1.1)
    assert position.vz.desired == pytest.approx(0.55)  # never below 0.5 m/s and a tenth


@pytest.mark.parametrize(("climb", "thrust"), [(10.0, 65535.0), (-10.0, 20000.0)])
def test_thrust_stays_between_minimum_and_full(position, climb, thrust):
    setpoint = make_setpoint(velocity=(0, 0, climb), mode=VELOCITY)
    assert update(position, setpoint, make_state())[2] == thrust


def test_vertical_output_is_limited(position):
    position.thrust_base = 0
    position.thrust_min = 0
    assert update(position, make_setpoint(velocity=(0, 0, 10), mode=VELOCITY), make_state())[2] == pytest.approx(
        32767.0, rel=1e-6
    )


@given(
    yaw=st.floats(-180, 180, width=32),
    vx=st.floats(-1, 1, width=32),
    vy=st.floats(-1, 1, width=32),
)
def test_world_velocity_is_turned_into_the_yaw_aligned_frame(yaw, vx, vy):
    controller = make_position()
    update(controller, make_setpoint(velocity=(vx, vy, 0), mode=VELOCITY), make_state(velocity=(vx, vy, 0), yaw=yaw))
    c, s = math.cos(math.radians(yaw)), math.sin(math.radians(yaw))
    expected = pytest.approx((vx * c + vy * s, vy * c - vx * s), abs=1e-6)
    assert (controller.vx.desired, controller.vy.desired) == expected
    assert (controller.body_vx, controller.body_vy) == expected


def test_body_velocity_is_taken_as_it_is(position):
    update(position, make_setpoint(velocity=(0.3, -0.2, 0), mode=VELOCITY, velocity_body=True), make_state(yaw=90))
    assert (position.vx.desired, position.vy.desired) == pytest.approx((0.3, -0.2))


@given(yaw=st.floats(-180, 180, width=32), x=st.floats(-2, 2, width=32), y=st.floats(-2, 2, width=32))
def test_goal_and_position_are_turned_alike(yaw, x, y):
    controller = make_position()
    update(controller, make_setpoint(position=(x, y, 0)), make_state(position=(x, y, 0), yaw=yaw))
    c, s = math.cos(math.radians(yaw)), math.sin(math.radians(yaw))
    assert (controller.body_x, controller.body_y) == pytest.approx((x * c + y * s, y * c - x * s), abs=1e-6)
    assert (controller.vx.desired, controller.vy.desired) == (0.0, 0.0)


def test_setpoint_velocity_does_not_help_in_position_mode(position):
    with_velocity = update(make_position(), make_setpoint(velocity=(0.5, 0.5, 0.5)), make_state())
    assert with_velocity == update(position, make_setpoint(), make_state())


def test_a_disabled_axis_still_runs_its_velocity_loop(position):
    update(position, make_setpoint(velocity=(0.5, 0, 0), mode=lib.modeDisable), make_state())
    assert position.vx.integ == pytest.approx(0.005)
    assert position.x.integ == 0.0


def test_velocity_loop_alone_equals_the_whole_in_body_velocity_mode(position):
    state = make_state(velocity=(0.1, 0.2, 0.3), yaw=30)
    whole = update(make_position(), make_setpoint((0, 0, 0), (0.3, 0.2, 0.1), VELOCITY, velocity_body=True), state)
    thrust, attitude = ffi.new("float *"), ffi.new("attitude_t *")
    velocity = ffi.new("Axis3f *", {"axis": (0.3, 0.2, 0.1)})
    lib.cf_position_controller_update_velocity(position, thrust, attitude, velocity, state)
    assert (attitude.roll, attitude.pitch, thrust[0]) == whole


def test_reset_sets_the_last_measurements(position):
    update(position, make_setpoint(position=(1, 1, 1)), make_state(velocity=(1, 2, 3)))
    lib.cf_position_controller_reset(position, 4.0, 5.0, 6.0)
    assert [getattr(position, loop).prevMeasured for loop in LOOPS] == [4, 5, 6, 0, 0, 0]
    assert [getattr(position, loop).integ for loop in LOOPS] == [0] * 6


def test_filter_reset_equals_a_full_filter_reset_of_each_loop(position):
    twin = make_position()
    for controller in (position, twin):
        for height in (0.1, 0.3):
            state = make_state(position=(0.5, 0.25, height), velocity=(1, 2, 3))
            update(controller, make_setpoint(position=(1, 1, 1)), state)
    assert position.vx.dFilter.delay_element_1 != 0.0
    assert position.vx.dFilter.delay_element_2 != 0.0
    lib.cf_position_controller_reset_filters(position)
    for loop in LOOPS:
        lib.filterReset(ffi.addressof(twin, loop), 100.0, 20.0, True)
    assert bytes(ffi.buffer(position)) == bytes(ffi.buffer(twin))


def test_reinit_forgets_but_keeps_the_gains_set_now(position):
    position.x.kp, position.vz.ki = 3.0, 7.0
    update(position, make_setpoint(position=(1, 1, 1)), make_state(velocity=(1, 2, 3)))
    lib.cf_position_controller_reinit(position)
    assert (position.x.kp, position.vz.ki) == (3.0, 7.0)
    for loop in LOOPS:
        pid = getattr(position, loop)
        assert (pid.integ, pid.prevMeasured, pid.dFilter.delay_element_1, pid.outputLimit) == (0, 0, 0, 0)


def test_parameter_table_lists_names_and_types_in_order():
    table = rows(lib.cf_position_controller_parameters())
    assert [(full_name(row), row.type) for row in table] == PARAMETERS
    assert {row.flags for row in table} == {lib.CF_PERSISTENT}


def test_log_table_lists_names_in_order():
    table = rows(lib.cf_position_controller_logs())
    assert [full_name(row) for row in table] == LOGS
    assert {(row.type, row.flags) for row in table} == {(lib.CF_TYPE_FLOAT, 0)}


@pytest.mark.parametrize(
    ("name", "ctype", "value"),
    [
        ("velCtlPid.vzKi", "float", 15.0),
        ("posCtlPid.zKi", "float", 0.5),
        ("posCtlPid.thrustBase", "uint16_t", 36000),
        ("posCtlPid.thrustMin", "uint16_t", 20000),
        ("posCtlPid.rLimit", "float", 20.0),
        ("posCtlPid.zVelMax", "float", 1.0),
    ],
)
def test_parameters_read_their_defaults(position, name, ctype, value):
    row = next(row for row in rows(lib.cf_position_controller_parameters()) if full_name(row) == name)
    assert ffi.cast(f"{ctype} *", ffi.cast("char *", position) + row.offset)[0] == value
