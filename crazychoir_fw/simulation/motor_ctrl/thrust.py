"""From newtons to the thrust of a setpoint."""

_FULL_THRUST = 65535.0


def thrust_counts(newtons: float, max_thrust: float) -> float:
    """Return the thrust of a setpoint, in [0, 65535], for a thrust of all rotors together.

    The mixer hands it to every motor, and the battery compensation inverts the thrust curve of the platform, so that
    full scale is the full thrust of a motor whatever the charge.

    Args:
        newtons: Thrust (N).
        max_thrust: Thrust at full command (N).
    """
    return min(max(newtons / max_thrust, 0.0), 1.0) * _FULL_THRUST
