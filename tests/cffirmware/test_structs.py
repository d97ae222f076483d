"""Structs as SWIG presents them, and what goes beyond (docs/reference/cffirmware-api.md#3)."""

import copy
import pickle

import numpy as np
import pytest


def test_nested_structs_are_live_views(firm):
    setpoint = firm.setpoint_t()
    position = setpoint.position
    position.x = 1.5
    setpoint.mode.z = firm.modeAbs
    assert setpoint.position.x == 1.5
    assert setpoint.mode.z == 1
    setpoint.position.x = 2.5
    assert position.x == 2.5


def test_assigning_a_struct_copies_it(firm):
    setpoint, other = firm.setpoint_t(), firm.vec3_s()
    other.x, other.timestamp = 1.0, 7
    setpoint.position = other
    other.x = 9.0
    assert (setpoint.position.x, setpoint.position.timestamp) == (1.0, 7)
    state = firm.state_t()
    state.position = setpoint.position
    setpoint.position.x = 5.0
    assert state.position.x == 1.0


def test_members_of_unnamed_unions_are_hoisted(firm):
    control, quaternion, tdoa = firm.control_t(), firm.quaternion_t(), firm.tdoaMeasurement_t()
    control.thrustSi = 1.0
    assert control.normalizedForces[0] == 1.0
    control.torqueY = 0.25
    assert control.torque[1] == 0.25
    quaternion.w = 0.5
    assert quaternion.q3 == 0.5
    tdoa.anchorIdB = 200
    assert list(tdoa.anchorIds) == [0, 200]
    tdoa.anchorPositionB.y = 3.0
    assert tdoa.anchorPositions[1].y == 3.0


def test_unknown_attribute_is_one_of_python(firm):
    setpoint = firm.setpoint_t()
    before = bytes(setpoint._ffi.buffer(setpoint.this))
    setpoint.trust = 3.0
    assert setpoint.trust == 3.0
    assert bytes(setpoint._ffi.buffer(setpoint.this)) == before
    with pytest.raises(AttributeError):
        _ = setpoint.unknown


@pytest.mark.parametrize("value", [1.0, "1", None, np.float32(1)])
def test_integers_take_no_fractions(firm, value):
    setpoint, thrust, control = firm.setpoint_t(), firm.motors_thrust_uncapped_t(), firm.control_t()
    with pytest.raises(TypeError):
        setpoint.timestamp = value
    with pytest.raises(TypeError):
        thrust.motors.m1 = value
    with pytest.raises(TypeError):
        control.controlMode = value


def test_numbers_of_numpy_are_numbers(firm):
    setpoint = firm.setpoint_t()
    setpoint.timestamp = np.int64(7)
    setpoint.thrust = np.float32(0.5)
    setpoint.velocity_body = np.bool_(True)
    assert (setpoint.timestamp, setpoint.thrust, setpoint.velocity_body) == (7, 0.5, True)


@pytest.mark.parametrize(("member", "value"), [("timestamp", -1), ("timestamp", 2**32)])
def test_integer_out_of_range_is_an_overflow(firm, member, value):
    with pytest.raises(OverflowError):
        setattr(firm.setpoint_t(), member, value)


def test_truth_values_are_bool_or_int(firm):
    setpoint = firm.setpoint_t()
    setpoint.velocity_body = 1
    assert setpoint.velocity_body is True
    for wrong in ("yes", 1.0, None):
        with pytest.raises(TypeError):
            setpoint.velocity_body = wrong


def test_float_takes_an_int_and_rounds_to_float32(firm):
    setpoint = firm.setpoint_t()
    setpoint.thrust = 3
    assert isinstance(setpoint.thrust, float)
    setpoint.thrust = 0.1
    assert setpoint.thrust == float(np.float32(0.1))
    with pytest.raises(TypeError):
        setpoint.thrust = "0.1"


@pytest.mark.parametrize("value", [None, 1.0, (1, 2, 3)])
def test_struct_member_takes_its_own_kind_only(firm, value):
    setpoint = firm.setpoint_t()
    with pytest.raises(TypeError, match="position must be vec3_s"):
        setpoint.position = value
    with pytest.raises(TypeError, match="position must be vec3_s"):
        setpoint.position = firm.vzero()


def test_constructors_take_nothing_but_copies_where_upstream_declares_them(firm):
    with pytest.raises(TypeError):
        firm.setpoint_t(firm.setpoint_t())
    original = firm.mkvec(1, 2, 3)
    copied = firm.vec(original)
    original.x = 9
    assert list(copied) == [1, 2, 3]
    evaluation = firm.traj_eval_zero()
    evaluation.yaw = 2
    assert firm.traj_eval(evaluation).yaw == 2
    with pytest.raises(TypeError):
        firm.vec(firm.meye())
    with pytest.raises(TypeError):
        firm.vec(original, original)


def test_arrays_are_views(firm):
    pwm, core = firm.motors_thrust_pwm_t(), firm.kalmanCoreData_t()
    pwm.list[2] = 4000
    assert pwm.motors.m3 == 4000
    pwm.list = [1, 2, 3, 4]
    assert (pwm.motors.m1, pwm.motors.m4) == (1, 4)
    core.P[3, 4] = 2.0
    assert core.P[3][4] == 2.0
    assert core.P.shape == (9, 9)
    matrix = firm.mdiag(1, 2, 3)
    assert np.array_equal(matrix.m, np.diag([1, 2, 3]))


@pytest.mark.parametrize(
    ("value", "error"),
    [([1, 2, 3], ValueError), ([1.5, 2, 3, 4], TypeError), ([70000, 0, 0, 0], OverflowError), ("1234", TypeError)],
)
def test_wrong_array_is_refused(firm, value, error):
    pwm = firm.motors_thrust_pwm_t()
    with pytest.raises(error):
        pwm.list = value


def test_swig_attributes(firm):
    setpoint = firm.setpoint_t()
    assert setpoint.thisown
    assert not setpoint.position.thisown
    assert firm.mkvec(1, 2, 3).thisown
    assert setpoint.this
    setpoint.thisown = False  # memory stays Python's all the same
    assert setpoint.position.x == 0


def test_equality_is_identity(firm):
    assert firm.mkvec(1, 2, 3) != firm.mkvec(1, 2, 3)
    one = firm.control_t()
    assert one == one
    assert len({firm.vzero(), firm.vzero()}) == 2


def test_copies_have_their_own_memory(firm):
    setpoint = firm.setpoint_t()
    setpoint.position.x = 1.0
    setpoint.note = "mine"
    for other in (copy.copy(setpoint), copy.deepcopy(setpoint)):
        other.position.x = 2.0
        assert (setpoint.position.x, other.note) == (1.0, "mine")
    with pytest.raises(TypeError, match="cannot pickle"):
        pickle.dumps(setpoint)


def test_struct_shows_its_members(firm):
    attitude = firm.attitude_t()
    attitude.yaw = 2.5
    assert repr(attitude) == "attitude_t(timestamp=0, roll=0.0, pitch=0.0, yaw=2.5)"
