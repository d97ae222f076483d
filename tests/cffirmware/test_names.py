"""Every name of upstream's module is there (docs/reference/cffirmware-api.md#4 to #7 and #9.4)."""

import inspect
import math
import re
from pathlib import Path

import numpy as np

from crazychoir_fw.cffirmware.function_table import EXTRA, FUNCTIONS

CLASSES = """attitude_t vec3_s quaternion_t Axis3f baro_t sensorData_t state_t control_t motors_thrust_uncapped_t
motors_thrust_pwm_t setpoint_t tdoaMeasurement_t positionMeasurement_t poseMeasurement_t distanceMeasurement_t
flowMeasurement_t tofMeasurement_t heightMeasurement_t yawErrorMeasurement_t sweepAngleMeasurement_t
gyroscopeMeasurement_t accelerationMeasurement_t barometerMeasurement_t vec mat33 quat poly4d traj_eval piecewise_traj
planner collision_avoidance_params_t collision_avoidance_state_t controllerMellinger_t controllerLee_t
Axis3fSubSampler_t OutlierFilterTdoaState_t kalmanCoreData_t kalmanCoreParams_t lpf2pData setpoint_t_mode"""
# not in the miniature checkout
SMALL_CLASSES = "zDistance_t estimate_t setpointZ_t"

CONSTANTS = {
    "modeDisable": 0,
    "modeAbs": 1,
    "modeVelocity": 2,
    "controlModeLegacy": 0,
    "controlModeForceTorque": 1,
    "controlModeForce": 2,
    "controlModePWM": 3,
    "MeasurementSourceLocationService": 0,
    "MeasurementSourceLighthouse": 1,
    "TRAJECTORY_STATE_IDLE": 0,
    "TRAJECTORY_STATE_FLYING": 1,
    "TRAJECTORY_STATE_LANDING": 3,
    "TRAJECTORY_STATE_DISABLED": 4,
    "TRAJECTORY_TYPE_PIECEWISE": 0,
    "TRAJECTORY_TYPE_PIECEWISE_COMPRESSED": 1,
    **{f"KC_STATE_{name}": i for i, name in enumerate(("X", "Y", "Z", "PX", "PY", "PZ", "D0", "D1", "D2", "DIM"))},
    "STABILIZER_NR_OF_MOTORS": 4,
    "vec3d_size": 3,
    **{f"RATE_{rate}_HZ": rate for rate in (1000, 500, 250, 100, 50, 25)},
    "RATE_MAIN_LOOP": 1000,
    "ATTITUDE_RATE": 500,
    "POSITION_RATE": 100,
    "RATE_HL_COMMANDER": 100,
    "RATE_SUPERVISOR": 25,
    "PP_DEGREE": 7,
    "PP_SIZE": 8,
    "M_PI_F": math.pi,
    "M_1_PI_F": 1 / math.pi,
    "M_PI_2_F": 1.57079632679,
}

ADDITIONS = """piecewise_get poly4d_set poly4d_get poly4d_malloc poly4d_free vec2svec svec2vec
collisionAvoidanceUpdateSetpointWrap assertFail"""

PYCFFIRMWARE = """lpf2pInit lpf2pApply crtpCommanderHighLevelInit crtpCommanderHighLevelTellState
crtpCommanderHighLevelUpdateTime crtpCommanderHighLevelGetSetpoint crtpCommanderHighLevelStop
crtpCommanderHighLevelTakeoff crtpCommanderHighLevelTakeoffYaw crtpCommanderHighLevelTakeoffWithVelocity
crtpCommanderHighLevelLand crtpCommanderHighLevelLandYaw crtpCommanderHighLevelLandWithVelocity
crtpCommanderHighLevelGoTo"""


def test_classes_are_zero_when_made(firm):
    names = CLASSES.split() + (SMALL_CLASSES.split() if firm.provider == "builtin" else [])
    for name in names:
        cls = getattr(firm, name)
        assert cls.__name__ == name or name == "setpoint_t_mode"
        made = cls()
        assert bytes(cls._ffi.buffer(made.this)) == bytes(cls._size), name


def test_constants(firm):
    assert {name: getattr(firm, name) for name in CONSTANTS} == CONSTANTS


def test_functions(firm):
    upstream = [function.name for function in FUNCTIONS if function.name not in EXTRA]
    models = [name for name in EXTRA if name.startswith("kalmanCoreUpdateWith") and not name.endswith("Unfiltered")]
    names = [*upstream, *models, *ADDITIONS.split(), *PYCFFIRMWARE.split()]
    assert len(upstream) > 170
    assert [name for name in names if not callable(getattr(firm, name, None))] == []
    assert firm.np is np


def test_every_function_says_what_it_does_and_takes(firm):
    for name in firm.__all__:
        function = getattr(firm, name)
        if inspect.isfunction(function):
            assert function.__doc__, name
            assert inspect.signature(function), name
    signature = inspect.signature(firm.plan_go_to)
    assert list(signature.parameters) == ["p", "relative", "linear", "hover_pos", "hover_yaw", "duration", "t"]
    assert signature.parameters["hover_pos"].annotation is firm.vec
    assert signature.return_annotation is int


def test_star_import_takes_everything():
    names = {}
    exec("from crazychoir_fw.cffirmware import *", names)
    assert {"np", "mkvec", "setpoint_t", "provider", "over", "instance", "modeAbs"} <= names.keys()


def test_old_release_lacks_what_came_later(old_firm):
    assert old_firm.provider == "bitcraze"
    missing = ["plan_spiral", "plan_spiral_from", "controllerLee", "controllerLee_t", "controlModePWM"]
    assert [name for name in missing if hasattr(old_firm, name)] == []
    assert not hasattr(old_firm.setpoint_t, "jerk")
    assert not hasattr(old_firm.piecewise_traj, "shift_yaw")


def test_page_lists_every_name_that_is_an_extra(firm):
    page = (Path(__file__).resolve().parents[2] / "docs" / "cffirmware.md").read_text()
    named = set(re.findall(r"`(\w+)[`(*]", page))
    assert [name for name in EXTRA if name not in named and not name.startswith("kalmanCoreUpdateWith")] == []
