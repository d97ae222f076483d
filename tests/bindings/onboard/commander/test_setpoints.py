"""Setpoints that the decoders make (docs/reference/planner-commander.md#9 and #17.2)."""

import math

import pytest
from setpoint_members import ABS, VELOCITY, garbage, members, modes

from crazychoir_fw._core import ffi, lib

FULL_STATE = [
    {"x": 1, "y": 2, "z": 3},
    {"x": 0.1, "y": 0.2, "z": 0.3},
    {"x": 0.4, "y": 0.5, "z": 0.6},
    {"x": 0.09963, "y": 0.20065, "z": 0.30028, "w": 0.92717},
    {"x": 10, "y": 20, "z": 30},
]


def full_state(values=FULL_STATE):
    """Return a cf_full_state_t."""
    state = ffi.new("cf_full_state_t *")
    for group, named in zip(["position", "velocity", "acceleration", "attitude", "body_rates"], values, strict=True):
        for name, value in named.items():
            setattr(getattr(state, group), name, value)
    return state


# docs/reference/planner-commander.md#17.2, decoders of port 7: builder, arguments, members of the setpoint
CASES = [
    pytest.param(
        lib.cf_setpoint_velocity_world,
        [0.1, 0.2, 0.3, 40.0],
        {"velocity.x": 0.1, "velocity.y": 0.2, "velocity.z": 0.3, "attitudeRate.yaw": 40.0}
        | modes(x=VELOCITY, y=VELOCITY, z=VELOCITY, yaw=VELOCITY),
        id="velocity_world, type 8",
    ),
    pytest.param(
        lib.cf_setpoint_zdistance,
        [1.0, 2.0, 30.0, 0.5],
        {"attitude.roll": 1.0, "attitude.pitch": 2.0, "attitudeRate.yaw": 30.0, "position.z": 0.5}
        | modes(roll=ABS, pitch=ABS, yaw=VELOCITY, z=ABS),
        id="zdistance, type 9",
    ),
    pytest.param(
        lib.cf_setpoint_altitude_hold,
        [1.0, 2.0, 30.0, 0.25],
        {"attitude.roll": 1.0, "attitude.pitch": 2.0, "attitudeRate.yaw": 30.0, "velocity.z": 0.25}
        | modes(roll=ABS, pitch=ABS, yaw=VELOCITY, z=VELOCITY),
        id="altitude_hold, type 4",
    ),
    pytest.param(
        lib.cf_setpoint_hover,
        [0.1, 0.2, 30.0, 0.5],
        {"velocity.x": 0.1, "velocity.y": 0.2, "velocity_body": True, "attitudeRate.yaw": 30.0, "position.z": 0.5}
        | modes(x=VELOCITY, y=VELOCITY, yaw=VELOCITY, z=ABS),
        id="hover, type 10",
    ),
    pytest.param(
        lib.cf_setpoint_full_state,
        [full_state()],
        {"position.x": 1, "position.y": 2, "position.z": 3}
        | {"velocity.x": 0.1, "velocity.y": 0.2, "velocity.z": 0.3}
        | {"acceleration.x": 0.4, "acceleration.y": 0.5, "acceleration.z": 0.6}
        | {"attitudeQuaternion.x": 0.09963, "attitudeQuaternion.y": 0.20065}
        | {"attitudeQuaternion.z": 0.30028, "attitudeQuaternion.w": 0.92717}
        | {"attitudeRate.roll": 572.95776, "attitudeRate.pitch": 1145.91553, "attitudeRate.yaw": 1718.87329}
        | modes(x=ABS, y=ABS, z=ABS, quat=ABS),
        id="full_state, type 6",
    ),
    pytest.param(
        lib.cf_setpoint_position,
        [1.0, 2.0, 3.0, 45.0],
        {"position.x": 1.0, "position.y": 2.0, "position.z": 3.0, "attitude.yaw": 45.0}
        | modes(x=ABS, y=ABS, z=ABS, yaw=ABS),
        id="position, type 7",
    ),
    pytest.param(
        lib.cf_setpoint_manual,
        [1.0, -2.0, 30.0, 35000, True],
        {"attitudeRate.roll": 1.0, "attitudeRate.pitch": -2.0, "attitudeRate.yaw": 30.0, "thrust": 35000.0}
        | modes(roll=VELOCITY, pitch=VELOCITY, yaw=VELOCITY),
        id="manual rates, type 11",
    ),
    pytest.param(
        lib.cf_setpoint_manual,
        [1.0, -2.0, 30.0, 35000, False],
        {"attitude.roll": 1.0, "attitude.pitch": -2.0, "attitudeRate.yaw": 30.0, "thrust": 35000.0}
        | modes(roll=ABS, pitch=ABS, yaw=VELOCITY),
        id="manual angles, type 11",
    ),
]


@pytest.mark.parametrize(("build", "arguments", "expected"), CASES)
def test_setpoint_has_exactly_the_expected_members(build, arguments, expected) -> None:
    setpoint = garbage()
    assert build(setpoint, *arguments) == lib.CF_OK
    assert members(setpoint) == pytest.approx(expected, rel=1e-7)


def test_stop_is_the_null_setpoint() -> None:
    setpoint = garbage()
    lib.cf_setpoint_stop(setpoint)
    assert not any(bytes(ffi.buffer(setpoint)))


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(("build", "arguments", "expected"), [case for case in CASES if "full" not in case.id])
def test_value_that_is_not_finite_leaves_the_setpoint_alone(build, arguments, expected, value: float) -> None:
    floats = [i for i, argument in enumerate(arguments) if isinstance(argument, float)]
    assert floats
    for i in floats:
        setpoint = garbage()
        bad = [*arguments[:i], value, *arguments[i + 1 :]]
        assert build(setpoint, *bad) == lib.CF_ERR_VALUE
        assert bytes(ffi.buffer(setpoint)) == bytes(ffi.buffer(garbage()))


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(("group", "name"), [(g, n) for g, named in enumerate(FULL_STATE) for n in named])
def test_full_state_that_is_not_finite_leaves_the_setpoint_alone(group: int, name: str, value: float) -> None:
    values = [dict(named) for named in FULL_STATE]
    values[group][name] = value
    setpoint = garbage()
    assert lib.cf_setpoint_full_state(setpoint, full_state(values)) == lib.CF_ERR_VALUE
    assert bytes(ffi.buffer(setpoint)) == bytes(ffi.buffer(garbage()))


def test_rates_that_overflow_in_degrees_are_refused() -> None:
    setpoint = garbage()
    values = [*FULL_STATE[:4], {"x": 1e37, "y": 0, "z": 0}]
    assert lib.cf_setpoint_full_state(setpoint, full_state(values)) == lib.CF_ERR_VALUE
    assert bytes(ffi.buffer(setpoint)) == bytes(ffi.buffer(garbage()))


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(
    ("group", "name"),
    [
        (group, name)
        for group in ["attitude", "attitudeRate", "attitudeQuaternion", "position", "velocity", "acceleration", "jerk"]
        for name in {"attitude": ["roll", "pitch", "yaw"], "attitudeRate": ["roll", "pitch", "yaw"]}.get(
            group, list("xyzw" if group == "attitudeQuaternion" else "xyz")
        )
    ]
    + [(None, "thrust")],
)
def test_every_number_of_a_setpoint_is_looked_at(group: str | None, name: str, value: float) -> None:
    setpoint = garbage()
    assert lib.cf_setpoint_is_finite(setpoint)
    setattr(getattr(setpoint, group) if group else setpoint, name, value)
    assert not lib.cf_setpoint_is_finite(setpoint)
