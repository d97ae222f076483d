"""How far two providers may be apart, per class of signals, and why: the one table of this comparison.

A sample is within tolerance when it is near enough by one of the measures: units in the last place, absolutely, or
relative to the largest magnitude of its signal.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np

FULL_TURN_DEG = 360.0
FULL_TURN_RAD = 2.0 * math.pi


@dataclass(frozen=True)
class Tolerance:
    """One class of signals."""

    name: str
    """Name of the class, as reports show it."""
    patterns: tuple[str, ...]
    """Names of signals that belong to it; a star stands for anything."""
    reason: str
    """Why that much, in one sentence."""
    absolute: float = 0.0
    """In the unit of the signal."""
    unit: str = ""
    """That unit, for people."""
    ulps: int = 0
    """Units in the last place of float32; means nothing to whole numbers."""
    relative: float = 0.0
    """Share of the largest magnitude of the reference's signal."""
    turn: float = 0.0
    """Angles: what a full turn is, so that both sides of the wrap are neighbors; 0 for other signals."""
    is_judged: bool = True
    """False: measured and shown, but without a say in the verdict."""


_ROUNDING = "float32 rounding of another order of operations, or another libm, "

REPLAY: tuple[Tolerance, ...] = (
    Tolerance(
        "position",
        ("*position.?", "*.pos.?", "log.*state[XYZ]", "log.*.target[XYZ]"),
        _ROUNDING + "fed back through the filter's covariance; a tenth of the best positioning system's noise",
        absolute=1e-4,
        unit="m",
        ulps=16,
    ),
    Tolerance(
        "velocity",
        ("*velocity.?", "*.vel.?", "log.*stateP[XYZ]"),
        _ROUNDING + "fed back through the filter's covariance; a hundredth of the noise of a hover",
        absolute=5e-4,
        unit="m/s",
        ulps=16,
    ),
    Tolerance(
        "acceleration of the estimate",
        ("estimate.acc.?",),
        _ROUNDING + "of a rotation matrix times one sample; the sensor counts in steps of 7e-4 g",
        absolute=1e-5,
        unit="g",
        ulps=16,
    ),
    Tolerance(
        "acceleration and jerk of a plan",
        ("goal.acc.?", "goal.jerk.?", "setpoint.acceleration.?", "setpoint.jerk.?"),
        _ROUNDING + "in polynomials of degree 7, whose terms are far larger than their sum",
        absolute=1e-3,
        unit="m/s^2, m/s^3",
        ulps=64,
        relative=1e-5,
    ),
    Tolerance(
        "body rates of a plan",
        ("goal.omega.?",),
        _ROUNDING + "in a quotient by thrust, which amplifies what its numerator lost",
        absolute=1e-4,
        unit="rad/s",
        ulps=64,
    ),
    Tolerance(
        "yaw of a plan",
        ("goal.yaw",),
        _ROUNDING + "of one polynomial",
        absolute=1e-5,
        unit="rad",
        ulps=16,
        turn=FULL_TURN_RAD,
    ),
    Tolerance(
        "attitude",
        ("*attitude.roll", "*attitude.pitch", "*attitude.yaw", "log.stateEstimate.roll", "log.stateEstimate.yaw"),
        _ROUNDING + "through a filter and an arc function; a hundredth of what a motion-capture system resolves",
        absolute=1e-3,
        unit="deg",
        ulps=16,
        turn=FULL_TURN_DEG,
    ),
    Tolerance(
        "attitude, as a quaternion",
        ("*attitudeQuaternion.?", "log.kalman.q?", "log.kalman.stateD?"),
        "the same as the attitude in degrees",
        absolute=1e-5,
        ulps=16,
    ),
    Tolerance(
        "thrust in counts",
        ("control.thrust", "log.*.cmd_thrust", "log.controller.actuatorThrust"),
        "less than one of 65535 counts, which is all that a motor can see",
        absolute=0.9,
        unit="counts",
        ulps=16,
    ),
    Tolerance(
        "thrust",
        ("control.thrustSi",),
        "one of 65535 counts of four motors",
        absolute=8e-6,
        unit="N",
        ulps=16,
    ),
    Tolerance(
        "torque",
        ("control.torque?",),
        "eight of 65535 counts of the motors, times the arm: attitude errors are small differences of unit vectors",
        absolute=2e-6,
        unit="N m",
        ulps=16,
    ),
    Tolerance(
        "normalized force",
        ("control.normalizedForces.?",),
        "one of 65535 counts of a motor",
        absolute=1.5e-5,
        ulps=16,
    ),
    Tolerance(
        "moments in counts",
        ("control.roll", "control.pitch", "control.yaw", "log.*.cmd_roll", "log.*.cmd_pitch", "log.*.cmd_yaw"),
        "one count: a fraction is cut, and the last bit may lie on either side of a whole number",
        absolute=1,
        unit="counts",
    ),
    Tolerance(
        "motor in counts",
        ("uncapped.list.?", "compensated.list.?", "pwm.list.?", "idle"),
        "one count: a fraction is cut, and the last bit may lie on either side of a whole number",
        absolute=1,
        unit="counts",
    ),
    Tolerance(
        "derivative",
        ("log.ctrlLee.rpyd?", "log.ctrlINDI.rate_d*", "log.*_outD"),
        "the difference of two neighbors, divided by their 1 or 2 ms, is 500 times the rounding or more",
        absolute=1e-3,
        unit="rad/s, counts",
        ulps=16,
        relative=1e-3,
    ),
    Tolerance(
        "other log variable",
        ("log.*",),
        _ROUNDING + "carried along by integrators and filters; relative, because every variable has its own unit",
        ulps=16,
        relative=5e-5,
    ),
    Tolerance(
        "other number",
        ("*",),
        _ROUNDING + "in a single formula",
        ulps=16,
        relative=1e-6,
    ),
)
"""Both providers on the same recorded inputs: nothing feeds a deviation back but the state of the function itself."""

WHOLE = Tolerance(
    "decision",
    ("*",),
    "a state, a mode, a count or a yes or no is the same or it is not",
)
"""Whole numbers that no other class names."""

DEFAULTS = Tolerance(
    "factory value",
    ("*",),
    "a factory value is a number that was written down: rounding has no part in it",
)

_FREE = "in a flight a deviation is fed back at every tick and grows like one of the noise; "

FLIGHT: tuple[Tolerance, ...] = (
    Tolerance(
        "true position",
        ("true.x", "true.y", "true.z"),
        _FREE + "1 cm is what two flights of one real drone never reach",
        absolute=0.01,
        unit="m",
    ),
    Tolerance(
        "true attitude",
        ("true.roll", "true.pitch", "true.yaw"),
        _FREE + "3 deg is less than a gust does",
        absolute=3.0,
        unit="deg",
        turn=FULL_TURN_DEG,
    ),
    Tolerance(
        "estimated position",
        ("stateEstimate.x", "stateEstimate.y", "stateEstimate.z"),
        _FREE + "as far as the true position",
        absolute=0.01,
        unit="m",
    ),
    Tolerance(
        "estimated attitude",
        ("stateEstimate.roll", "stateEstimate.pitch", "stateEstimate.yaw"),
        _FREE + "as far as the true attitude",
        absolute=3.0,
        unit="deg",
        turn=FULL_TURN_DEG,
    ),
    Tolerance(
        "refused commands",
        ("refused commands",),
        "a command that one drone takes and the other refuses makes another flight",
    ),
    Tolerance(
        "outcome of a test",
        ("outcome of *",),
        "a test that was made, and what it passed, is known when the flight ends, whenever the test began",
    ),
    Tolerance(
        "motors and everything else on board",
        ("*",),
        _FREE + "motion is what counts, so these are measured and not judged",
        is_judged=False,
    ),
)
"""Whole flights, each provider in its own loop."""


_LOOP = "a loop of another order starts the motors a step earlier or later, at another charge of the battery; "

OWN_LOOP: tuple[Tolerance, ...] = (
    Tolerance(
        "true position",
        ("true.x", "true.y", "true.z"),
        _LOOP + "5 cm is how far a drone falls while the supervisor decides once more",
        absolute=0.05,
        unit="m",
    ),
    Tolerance(
        "estimated position",
        ("stateEstimate.x", "stateEstimate.y", "stateEstimate.z"),
        _LOOP + "as far as the true position",
        absolute=0.05,
        unit="m",
    ),
    Tolerance(
        "attitude",
        ("true.roll", "true.pitch", "true.yaw", "stateEstimate.roll", "stateEstimate.pitch", "stateEstimate.yaw"),
        _LOOP + "and a turn through 180 deg loses a few degrees for a moment, more or less by chance",
        absolute=10.0,
        unit="deg",
        turn=FULL_TURN_DEG,
    ),
    *FLIGHT[-3:],
)
"""Whole flights of a candidate that brings its own stabilizer loop, from take-off on."""


def tolerance_of(signal: str, dtype: np.dtype, table: Sequence[Tolerance] = REPLAY) -> Tolerance:
    """Return the class of a signal.

    Args:
        signal: Its name.
        dtype: Its type; whole numbers of a replay that no class names must be equal.
        table: `REPLAY` or `FLIGHT`, both of which end with a class for everything.
    """
    found = next(row for row in table if any(fnmatchcase(signal, pattern) for pattern in row.patterns))
    catches_all = found.patterns in (("*",), ("log.*",))
    return WHOLE if table is REPLAY and catches_all and np.dtype(dtype).kind in "biu" else found
