"""Numbers that are part of the firmware's C API: sizes, places, enumerators, rates.

docs/reference/control-pid.md#2, #3, #5 and #7, docs/reference/planner-commander.md#4.1, #5.1, #6.1, #7.6, #8.1 and
#12.1. Places are those of a host with enumerations of 4 bytes.
"""

import pytest

from crazychoir_fw._core import ffi, lib

# type: size; member: place
LAYOUTS = {
    "setpoint_t": (
        152,
        {
            "timestamp": 0,
            "attitude": 4,
            "attitudeRate": 20,
            "attitudeQuaternion": 36,
            "thrust": 52,
            "position": 56,
            "velocity": 72,
            "acceleration": 88,
            "jerk": 104,
            "velocity_body": 120,
            "mode": 124,
        },
    ),
    "state_t": (80, {"attitude": 0, "attitudeQuaternion": 16, "position": 32, "velocity": 48, "acc": 64}),
    "sensorData_t": (56, {"acc": 0, "gyro": 12, "mag": 24, "baro": 36, "interruptTimestamp": 48}),
    "control_t": (
        20,
        {
            "roll": 0,
            "pitch": 2,
            "yaw": 4,
            "thrust": 8,
            "thrustSi": 0,
            "torque": 4,
            "torqueX": 4,
            "torqueY": 8,
            "torqueZ": 12,
            "normalizedForces": 0,
            "controlMode": 16,
        },
    ),
    "Axis3f": (12, {"x": 0, "y": 4, "z": 8, "axis": 0}),
    "quaternion_t": (16, {"q0": 0, "q3": 12, "x": 0, "y": 4, "z": 8, "w": 12}),
    "attitude_t": (16, {"timestamp": 0, "roll": 4, "pitch": 8, "yaw": 12}),
    "struct poly4d": (132, {"p": 0, "duration": 128}),
}

# sections of docs/reference/control-pid.md, unless another page is named
NUMBERS = {
    # 2
    "STABILIZER_NR_OF_MOTORS": 4,
    # 3
    "RATE_1000_HZ": 1000,
    "RATE_500_HZ": 500,
    "RATE_250_HZ": 250,
    "RATE_100_HZ": 100,
    "RATE_50_HZ": 50,
    "RATE_25_HZ": 25,
    "RATE_MAIN_LOOP": 1000,
    "ATTITUDE_RATE": 500,
    "POSITION_RATE": 100,
    "RATE_HL_COMMANDER": 100,
    "RATE_SUPERVISOR": 25,
    # 7
    "IIR_SHIFT": 8,
    # docs/reference/planner-commander.md#4.1
    "PP_DEGREE": 7,
    "PP_SIZE": 8,
    # docs/reference/planner-commander.md#5.1
    "PPTRAJ_STORAGE_CONSTANT": 0,
    "PPTRAJ_STORAGE_LINEAR": 1,
    "PPTRAJ_STORAGE_BEZIER": 2,
    "PPTRAJ_STORAGE_FULL": 3,
    # docs/reference/planner-commander.md#6.1
    "TRAJECTORY_STATE_IDLE": 0,
    "TRAJECTORY_STATE_FLYING": 1,
    "TRAJECTORY_STATE_LANDING": 3,
    "TRAJECTORY_STATE_DISABLED": 4,
    # docs/reference/planner-commander.md#7.6
    "CF_TRAJECTORY_MEMORY_BYTES": 4096,
    "CF_TRAJECTORY_DEFINITIONS": 31,
    "CF_TRAJECTORY_PIECES": 31,
    "CF_TRAJECTORY_LOCATION_INVALID": 0,
    "CF_TRAJECTORY_LOCATION_MEMORY": 1,
    "CF_TRAJECTORY_TYPE_POLY4D": 0,
    "CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED": 1,
    # docs/reference/planner-commander.md#8.1
    "COMMANDER_PRIORITY_DISABLE": 0,
    "COMMANDER_PRIORITY_LOWEST": 1,
    "COMMANDER_PRIORITY_HIGHLEVEL": 1,
    "COMMANDER_PRIORITY_CRTP": 2,
    "COMMANDER_PRIORITY_EXTRX": 3,
    # docs/reference/planner-commander.md#10.1
    "CF_STABILIZE_RATE": 0,
    "CF_STABILIZE_ANGLE": 1,
    "CF_YAW_MODE_CAREFREE": 0,
    "CF_YAW_MODE_PLUS": 1,
    "CF_YAW_MODE_X": 2,
    # docs/reference/planner-commander.md#13
    "PEER_LOCALIZATION_MAX_NEIGHBORS": 10,
}


@pytest.mark.parametrize(("type", "size", "members"), [(name, *layout) for name, layout in LAYOUTS.items()])
def test_type_has_the_size_and_the_places_of_the_reference(type, size, members):
    """docs/reference/control-pid.md#2, docs/reference/planner-commander.md#4.1."""
    assert ffi.sizeof(type) == size
    assert {name: ffi.offsetof(type, name) for name in members} == members


@pytest.mark.parametrize(("name", "number"), NUMBERS.items())
def test_number_has_the_value_of_the_reference(name, number):
    assert getattr(lib, name) == number


def test_modes_of_a_setpoint_stand_in_the_order_of_the_firmware():
    """docs/reference/control-pid.md#2."""
    modes = [name for name, _ in ffi.typeof("setpoint_mode_t").fields]
    assert modes == ["x", "y", "z", "roll", "pitch", "yaw", "quat"]


def test_members_of_a_pid_and_of_its_filter_stand_in_the_order_of_the_firmware():
    """docs/reference/control-pid.md#6 and #7."""
    pid = "desired error prevMeasured integ deriv kp ki kd kff outP outI outD outFF iLimit outputLimit dt dFilter"
    assert [name for name, _ in ffi.typeof("PidObject").fields] == [*pid.split(), "enableDFilter"]
    low_pass = "a1 a2 b0 b1 b2 delay_element_1 delay_element_2"
    assert [name for name, _ in ffi.typeof("lpf2pData").fields] == low_pass.split()


def test_a_logged_thrust_shares_its_place_with_a_torque():
    """docs/reference/control-pid.md#2: the views overlap."""
    control = ffi.new("control_t *", {"torqueY": 0.25})
    assert control.thrust == 0.25
