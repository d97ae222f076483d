"""Log variables of the motors, and the value of full duty."""

MOTORS = ("motor.m1", "motor.m2", "motor.m3", "motor.m4")

FULL_DUTY = 65535.0
"""Value of `MOTORS` at full duty (counts)."""
