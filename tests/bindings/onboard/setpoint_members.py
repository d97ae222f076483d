"""Setpoints as dictionaries, for the tests of modules that make setpoints."""

from crazychoir_fw._core import ffi, lib

ABS, VELOCITY = lib.modeAbs, lib.modeVelocity
GROUPS = ["attitude", "attitudeRate", "position", "velocity", "acceleration", "jerk", "mode"]


def members(setpoint) -> dict[str, float]:
    """Return the members that are not 0, by their path."""
    values = {"thrust": setpoint.thrust, "velocity_body": setpoint.velocity_body, "timestamp": setpoint.timestamp}
    for group in GROUPS:
        for name, _ in ffi.typeof(getattr(setpoint, group)).fields:
            values[f"{group}.{name}"] = getattr(getattr(setpoint, group), name)
    for name in "xyzw":
        values[f"attitudeQuaternion.{name}"] = getattr(setpoint.attitudeQuaternion, name)
    return {path: value for path, value in values.items() if value != 0}


def garbage():
    """Return a setpoint with something in every member."""
    setpoint = ffi.new("setpoint_t *")
    ffi.memmove(setpoint, b"\x01" * ffi.sizeof("setpoint_t"), ffi.sizeof("setpoint_t"))
    return setpoint


def modes(**named: int) -> dict[str, int]:
    return {f"mode.{axis}": mode for axis, mode in named.items()}
