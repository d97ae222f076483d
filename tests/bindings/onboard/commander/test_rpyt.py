"""The legacy command and its flight modes (docs/reference/planner-commander.md#10, #16 and #17.2)."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from setpoint_members import ABS, VELOCITY, garbage, members, modes

from crazychoir_fw._core import ffi, lib

CLIENT = lib.COMMANDER_PRIORITY_CRTP
FLIGHT_MODE = ["althold", "poshold", "posSet", "yawMode", "stabModeRoll", "stabModePitch", "stabModeYaw"]


@pytest.fixture
def rpyt():
    rpyt = ffi.new("cf_rpyt_t *")
    lib.cf_rpyt_init(rpyt)
    return rpyt


@pytest.fixture
def unlocked(rpyt):
    send(rpyt, 0.0, 0.0, 0.0, 0)
    return rpyt


def send(rpyt, roll, pitch, yaw, thrust, setpoint=None, priority=CLIENT):
    """Return the setpoint of an accepted command; by default what was before is null."""
    setpoint = setpoint or ffi.new("setpoint_t *")
    assert lib.cf_setpoint_rpyt(setpoint, rpyt, priority, roll, pitch, yaw, thrust) == lib.CF_OK
    return setpoint


ATTITUDE = {"attitude.roll": 1.0, "attitude.pitch": -2.0, "attitudeRate.yaw": -30.0}
ATTITUDE_MODES = modes(roll=ABS, pitch=ABS, yaw=VELOCITY)


# --- the thrust


def test_thrust_is_locked_until_zero_is_sent(rpyt) -> None:
    setpoint = send(rpyt, 1.0, -2.0, 30.0, 20000)
    assert members(setpoint) == ATTITUDE | ATTITUDE_MODES
    send(rpyt, 0.0, 0.0, 0.0, 0, setpoint)
    assert members(setpoint) == ATTITUDE_MODES
    send(rpyt, 1.0, -2.0, 30.0, 20000, setpoint)
    assert members(setpoint) == ATTITUDE | ATTITUDE_MODES | {"thrust": 20000.0}


@pytest.mark.parametrize(
    ("sent", "thrust"), [(999, 0.0), (1000, 1000.0), (59999, 59999.0), (60000, 60000.0), (65535, 60000.0)]
)
def test_thrust_is_limited(unlocked, sent: int, thrust: float) -> None:
    assert send(unlocked, 1.0, -2.0, 30.0, sent).thrust == thrust


def test_thrust_is_locked_again_while_nobody_commands(unlocked) -> None:
    assert send(unlocked, 0.0, 0.0, 0.0, 20000, priority=lib.COMMANDER_PRIORITY_DISABLE).thrust == 0.0
    assert send(unlocked, 0.0, 0.0, 0.0, 20000).thrust == 0.0
    # zero thrust unlocks even then
    send(unlocked, 0.0, 0.0, 0.0, 0, priority=lib.COMMANDER_PRIORITY_DISABLE)
    assert send(unlocked, 0.0, 0.0, 0.0, 20000).thrust == 20000.0


# --- flight modes


def test_plus_mode_turns_roll_and_pitch_by_45_degrees(unlocked) -> None:
    unlocked.yawMode = lib.CF_YAW_MODE_PLUS
    setpoint = send(unlocked, 1.0, -2.0, 30.0, 20000)
    expected = {"attitude.roll": 2.1213202, "attitude.pitch": -0.70710677, "attitudeRate.yaw": -30, "thrust": 20000}
    assert members(setpoint) == pytest.approx(expected | ATTITUDE_MODES, rel=1e-7)


@pytest.mark.parametrize("number", [lib.CF_YAW_MODE_X, 3, 255])
def test_any_other_yaw_mode_is_the_x_mode(unlocked, number: int) -> None:
    unlocked.yawMode = number
    assert members(send(unlocked, 1.0, -2.0, 30.0, 20000)) == ATTITUDE | ATTITUDE_MODES | {"thrust": 20000.0}


def test_carefree_mode_is_refused_where_the_yaw_is_a_rate(unlocked) -> None:
    unlocked.yawMode = lib.CF_YAW_MODE_CAREFREE
    setpoint = garbage()
    assert lib.cf_setpoint_rpyt(setpoint, unlocked, CLIENT, 0.0, 0.0, 0.0, 20000) == lib.CF_ERR_STATE
    assert bytes(ffi.buffer(setpoint)) == bytes(ffi.buffer(garbage()))
    unlocked.stabModeYaw = lib.CF_STABILIZE_ANGLE
    assert send(unlocked, 0.0, 0.0, 0.0, 20000).thrust == 20000.0


def test_althold_makes_the_thrust_a_climb_rate(unlocked) -> None:
    unlocked.althold = 1
    setpoint = send(unlocked, 0.0, 0.0, 0.0, 40000)
    assert members(setpoint) == pytest.approx(ATTITUDE_MODES | modes(z=VELOCITY) | {"velocity.z": 0.22074038}, rel=1e-7)


@pytest.mark.parametrize(("thrust", "climb"), [(0, -1.0), (32767, 0.0), (65535, 32768 / 32767)])
def test_climb_rate_covers_the_range_of_the_thrust(unlocked, thrust: int, climb: float) -> None:
    unlocked.althold = 1
    setpoint = send(unlocked, 0.0, 0.0, 0.0, thrust)
    assert setpoint.velocity.z == pytest.approx(climb, rel=1e-7)
    assert setpoint.thrust == 0.0


def test_althold_begins_with_its_first_command_and_ends_with_the_first_without(unlocked) -> None:
    held = []
    for althold in [0, 1, 1, 0, 1]:
        unlocked.althold = althold
        setpoint = send(unlocked, 0.0, 0.0, 0.0, 40000)
        held.append(unlocked.is_holding_altitude)
        assert setpoint.mode.z == (VELOCITY if althold else lib.modeDisable)
    assert held == [False, True, True, False, True]


def test_poshold_makes_pitch_and_roll_velocities(unlocked) -> None:
    unlocked.poshold = 1
    setpoint = send(unlocked, 15.0, -30.0, 0.0, 20000)
    expected = {"velocity.x": -1.0, "velocity.y": 0.5, "thrust": 20000} | modes(x=VELOCITY, y=VELOCITY, yaw=VELOCITY)
    assert members(setpoint) == expected


def test_poshold_keeps_no_angle_of_an_earlier_command(unlocked) -> None:
    setpoint = send(unlocked, 10.0, 20.0, 0.0, 20000)
    unlocked.poshold = 1
    send(unlocked, 0.0, 0.0, 0.0, 20000, setpoint)
    assert [setpoint.attitude.roll, setpoint.attitude.pitch] == [0.0, 0.0]
    assert [setpoint.mode.roll, setpoint.mode.pitch] == [lib.modeDisable] * 2


def test_pos_set_makes_the_command_a_position(unlocked) -> None:
    unlocked.posSet = 1
    setpoint = send(unlocked, 0.5, -1.5, 90.0, 1500)
    expected = {"position.x": 1.5, "position.y": 0.5, "position.z": 1.5, "attitude.yaw": 90.0}
    assert members(setpoint) == expected | modes(x=ABS, y=ABS, z=ABS, yaw=ABS)


def test_pos_set_knows_neither_lock_nor_limits_of_the_thrust(rpyt) -> None:
    rpyt.posSet = 1
    assert rpyt.thrust_is_locked
    assert send(rpyt, 0.0, 0.0, 0.0, 999).position.z == pytest.approx(0.999)
    assert send(rpyt, 0.0, 0.0, 0.0, 65535).position.z == pytest.approx(65.535)


def test_pos_set_overrides_the_height_of_althold(unlocked) -> None:
    unlocked.posSet = unlocked.althold = 1
    assert send(unlocked, 0.0, 0.0, 0.0, 1500).mode.z == ABS


def test_pos_set_without_thrust_is_an_attitude_without_a_new_yaw(unlocked) -> None:
    before = send(unlocked, 0.0, 0.0, 25.0, 20000)
    unlocked.posSet = 1
    setpoint = send(unlocked, 1.0, -2.0, 90.0, 0, before)
    assert members(setpoint) == {"attitude.roll": 1, "attitude.pitch": -2, "attitudeRate.yaw": -25} | ATTITUDE_MODES


def test_poshold_wins_over_pos_set(unlocked) -> None:
    unlocked.poshold = unlocked.posSet = 1
    setpoint = send(unlocked, 15.0, -30.0, 90.0, 1500)
    # the yaw belongs to posSet and is left alone
    assert members(setpoint) == {"velocity.x": -1.0, "velocity.y": 0.5, "thrust": 1500} | modes(x=VELOCITY, y=VELOCITY)


def test_roll_and_pitch_may_be_rates(unlocked) -> None:
    unlocked.stabModeRoll = lib.CF_STABILIZE_RATE
    setpoint = send(unlocked, 1.0, -2.0, 30.0, 20000)
    expected = {"attitudeRate.roll": 1.0, "attitude.pitch": -2.0, "attitudeRate.yaw": -30.0, "thrust": 20000.0}
    assert members(setpoint) == expected | modes(roll=VELOCITY, pitch=ABS, yaw=VELOCITY)

    unlocked.stabModeRoll, unlocked.stabModePitch = lib.CF_STABILIZE_ANGLE, lib.CF_STABILIZE_RATE
    send(unlocked, 1.0, -2.0, 30.0, 20000, setpoint)
    expected = {"attitude.roll": 1.0, "attitudeRate.pitch": -2.0, "attitudeRate.yaw": -30.0, "thrust": 20000.0}
    assert members(setpoint) == expected | modes(roll=ABS, pitch=VELOCITY, yaw=VELOCITY)


def test_yaw_may_be_an_angle_positive_to_the_left(unlocked) -> None:
    before = send(unlocked, 0.0, 0.0, 25.0, 20000)
    unlocked.stabModeYaw = lib.CF_STABILIZE_ANGLE
    setpoint = send(unlocked, 0.0, 0.0, 90.0, 20000, before)
    assert members(setpoint) == {"attitude.yaw": 90.0, "thrust": 20000} | modes(roll=ABS, pitch=ABS, yaw=ABS)


def test_plus_mode_needs_a_yaw_rate(unlocked) -> None:
    unlocked.yawMode, unlocked.stabModeYaw = lib.CF_YAW_MODE_PLUS, lib.CF_STABILIZE_ANGLE
    setpoint = send(unlocked, 1.0, -2.0, 0.0, 20000)
    assert [setpoint.attitude.roll, setpoint.attitude.pitch] == [1.0, -2.0]


# --- what it keeps, what it refuses


def test_members_that_rpyt_does_not_name_are_kept(unlocked) -> None:
    """docs/reference/planner-commander.md#10.3: a full-state setpoint leaves its attitude mode behind."""
    setpoint = ffi.new("setpoint_t *", {"position": {"x": 1.0}, "velocity": {"x": 2.0, "y": 3.0, "z": 4.0}})
    setpoint.mode.quat = setpoint.mode.x = setpoint.mode.y = setpoint.mode.z = ABS
    setpoint.jerk.y, setpoint.velocity_body = 5.0, True
    send(unlocked, 1.0, -2.0, 30.0, 20000, setpoint)
    kept = {"position.x": 1.0, "velocity.z": 4.0, "jerk.y": 5.0, "velocity_body": True} | modes(quat=ABS)
    assert members(setpoint) == ATTITUDE | ATTITUDE_MODES | {"thrust": 20000.0} | kept


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("argument", range(3))
@pytest.mark.parametrize("mode", [{}, {"posSet": 1}, {"poshold": 1}, {"stabModeRoll": 0, "stabModeYaw": 1}])
def test_rpyt_that_is_not_finite_changes_neither_setpoint_nor_lock(rpyt, mode, argument: int, value: float) -> None:
    for name, number in mode.items():
        setattr(rpyt, name, number)
    setpoint = garbage()
    arguments = [0.0, 0.0, 0.0]
    arguments[argument] = value
    assert lib.cf_setpoint_rpyt(setpoint, rpyt, CLIENT, *arguments, 0) == lib.CF_ERR_VALUE
    assert rpyt.thrust_is_locked
    assert bytes(ffi.buffer(setpoint)) == bytes(ffi.buffer(garbage()))


def test_rotation_that_overflows_is_refused_and_changes_nothing(rpyt) -> None:
    rpyt.yawMode = lib.CF_YAW_MODE_PLUS
    rpyt.althold = 1
    setpoint = garbage()
    assert lib.cf_setpoint_rpyt(setpoint, rpyt, CLIENT, 3e38, 3e38, 0.0, 0) == lib.CF_ERR_VALUE
    assert [rpyt.thrust_is_locked, rpyt.is_holding_altitude] == [True, False]
    assert bytes(ffi.buffer(setpoint)) == bytes(ffi.buffer(garbage()))


NUMBERS = st.floats(width=32)
BYTE = st.integers(0, 255)


@given(NUMBERS, NUMBERS, NUMBERS, st.integers(0, 65535), st.tuples(*[st.one_of(st.integers(0, 2), BYTE)] * 7))
def test_accepted_setpoint_is_finite_in_every_flight_mode(roll, pitch, yaw, thrust, mode) -> None:
    rpyt = ffi.new("cf_rpyt_t *", dict(zip(FLIGHT_MODE, mode, strict=True)))
    setpoint = garbage()
    status = lib.cf_setpoint_rpyt(setpoint, rpyt, CLIENT, roll, pitch, yaw, thrust)
    if status == lib.CF_OK:
        assert lib.cf_setpoint_is_finite(setpoint)
        assert 0.0 <= setpoint.thrust <= 60000.0
    else:
        assert bytes(ffi.buffer(setpoint)) == bytes(ffi.buffer(garbage()))


# --- parameters

# docs/reference/planner-commander.md#16: name, default, flags
PARAMETERS = [
    ("althold", 0, lib.CF_CORE),
    ("poshold", 0, lib.CF_CORE),
    ("posSet", 0, lib.CF_CORE),
    ("yawMode", 2, 0),
    ("stabModeRoll", 1, lib.CF_CORE),
    ("stabModePitch", 1, lib.CF_CORE),
    ("stabModeYaw", 0, lib.CF_CORE),
]


def test_parameters_have_name_type_flags_and_default(rpyt) -> None:
    table = lib.cf_rpyt_parameters()
    found = []
    for row in table.rows[0 : table.count]:
        assert ffi.string(row.group) == b"flightmode"
        assert row.type == lib.CF_TYPE_UINT8
        value = ffi.cast("uint8_t *", rpyt)[row.offset]
        found.append((ffi.string(row.name).decode(), value, row.flags))
    assert found == PARAMETERS
