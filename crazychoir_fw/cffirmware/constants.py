"""Enumerations and numeric macros of the module."""

from __future__ import annotations

from typing import Any

_TEXT = """
modeDisable modeAbs modeVelocity
controlModeLegacy controlModeForceTorque controlModeForce controlModePWM
MeasurementSourceLocationService MeasurementSourceLighthouse
TRAJECTORY_STATE_IDLE TRAJECTORY_STATE_FLYING TRAJECTORY_STATE_LANDING TRAJECTORY_STATE_DISABLED
TRAJECTORY_TYPE_PIECEWISE TRAJECTORY_TYPE_PIECEWISE_COMPRESSED
KC_STATE_X KC_STATE_Y KC_STATE_Z KC_STATE_PX KC_STATE_PY KC_STATE_PZ KC_STATE_D0 KC_STATE_D1 KC_STATE_D2 KC_STATE_DIM
STABILIZER_NR_OF_MOTORS
RATE_1000_HZ RATE_500_HZ RATE_250_HZ RATE_100_HZ RATE_50_HZ RATE_25_HZ
RATE_MAIN_LOOP ATTITUDE_RATE POSITION_RATE RATE_HL_COMMANDER RATE_SUPERVISOR
PP_DEGREE PP_SIZE
"""
NAMES = tuple(_TEXT.split())
"""Constants of upstream's module; a provider has those that its headers declare."""

# the same in every release
_FIXED = {
    "M_PI_F": 3.14159265358979323846,
    "M_1_PI_F": 0.31830988618379067154,
    "M_PI_2_F": 1.57079632679,
    "vec3d_size": 3,
}


def constants(lib: Any) -> dict[str, int | float]:
    """Return the constants of a provider by name; those that it lacks are left out."""
    return _FIXED | {name: getattr(lib, name) for name in NAMES if hasattr(lib, name)}
