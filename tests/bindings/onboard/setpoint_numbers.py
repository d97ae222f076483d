"""Every number of a setpoint, for tests that ask whether all are finite."""


def setpoint_numbers(setpoint) -> list[float]:
    """Return attitude, rates, quaternion, thrust, position, velocity, acceleration and jerk."""
    parts = [getattr(setpoint, name) for name in ("position", "velocity", "acceleration", "jerk")]
    angles = [setpoint.attitude, setpoint.attitudeRate]
    q = setpoint.attitudeQuaternion
    return [
        *(getattr(part, axis) for part in parts for axis in "xyz"),
        *(getattr(part, axis) for part in angles for axis in ("roll", "pitch", "yaw")),
        *(q.x, q.y, q.z, q.w, setpoint.thrust),
    ]
