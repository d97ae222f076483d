"""What a drone can fly, and what a curve asks of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.onboard.core import platform_names
from crazychoir_fw.onboard.thrust import platform_max_thrust
from crazychoir_fw.planning.curves import Polynomial

Array = NDArray[np.float64]

GRAVITY = 9.81  # [m/s^2]
_SAMPLES = 32  # of a piece, before the highest place is looked at more closely
_CLOSER = 17
_ROUNDING = 1.0 + 1e-6  # peaks are found by sampling
_THRUST_SHARE = 0.8  # of the full thrust; the rest is for control
_TILT = math.radians(20.0)  # what the onboard PID position controller asks for at most
_BODY_RATE = math.radians(200.0)  # roll and pitch together: a choice, well within all onboard rate loops


@dataclass(frozen=True)
class Limits:
    """What a curve may ask of a drone; None is no limit.

    Thrust, tilt and body rates follow from acceleration and jerk, because a quadrotor is differentially flat: it pushes
    along f = acceleration + gravity and turns with the change of f's direction. Drag is neglected.
    """

    speed: float | None = None
    """Magnitude of the velocity (m/s)."""
    acceleration: float | None = None
    """Magnitude of the acceleration, without gravity (m/s^2)."""
    jerk: float | None = None
    """Magnitude of the jerk (m/s^3)."""
    thrust: float | None = None
    """Thrust of all rotors together (N); needs `mass`."""
    least_thrust: float | None = None
    """Thrust that is never gone below (N); needs `mass`."""
    tilt: float | None = None
    """Angle between body z and the vertical (rad)."""
    body_rate: float | None = None
    """Magnitude of roll and pitch rate together (rad/s)."""
    mass: float | None = None
    """Mass of the drone (kg)."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None and not 0.0 < value < math.inf:
                raise RangeError(f"Limits: {field.name} is {value}, allowed: a number above 0")
        if self.mass is None and not (self.thrust is None and self.least_thrust is None):
            raise RangeError("Limits: limits of thrust need the mass")
        hover = None if self.mass is None else self.mass * GRAVITY
        # by standing nearly still every limit can be met, if these can
        if (self.thrust or math.inf) <= (hover or 0.0) or (self.least_thrust or 0.0) >= (hover or math.inf):
            raise RangeError(f"Limits: a thrust of {hover:.3g} N, to hover, must be between least_thrust and thrust")

    @classmethod
    def of_platform(
        cls,
        platform: str = "cf2",
        *,
        speed: float | None = 1.0,
        acceleration: float | None = 2.0,
        jerk: float | None = None,
        tilt: float | None = _TILT,
        body_rate: float | None = _BODY_RATE,
        mass: float | None = None,
    ) -> Limits:
        """Return what an airframe can fly.

        Thrust is 80 % of its full thrust, and no less than its rotors give when they idle. 2 m/s^2 is
        what the authors of CrazyChoir tell users (docs/reference/crazychoir.md#22, number 7), 20 deg the largest tilt
        that the onboard PID controller asks for; 1 m/s and 200 deg/s are choices.

        Args:
            platform: ``cf2`` or ``cf21bl``.
            speed: See the attributes, as for the next ones.
            acceleration: m/s^2.
            jerk: m/s^3.
            tilt: rad.
            body_rate: rad/s.
            mass: kg, where it is not that of the platform, for instance with decks.

        Raises:
            UnknownNameError: If there is no such platform.
        """
        full = platform_max_thrust(platform)
        facts = lib.cf_platform_facts(platform_names().index(platform))
        return cls(
            speed=speed,
            acceleration=acceleration,
            jerk=jerk,
            thrust=_THRUST_SHARE * full,
            least_thrust=4.0 * float(facts.thrust.thrust_min),
            tilt=tilt,
            body_rate=body_rate,
            mass=float(facts.mass) if mass is None else mass,
        )


GENTLE = Limits(speed=1.0, acceleration=2.0)
"""What every Crazyflie follows with ease."""


@dataclass(frozen=True)
class Load:
    """Peak demand of a curve on one limited quantity."""

    name: str
    """Name of the limit."""
    peak: float
    """The highest value (for ``least_thrust``, the lowest), in the unit of the limit."""
    allowed: float
    """The limit."""
    time: float
    """When that is (s)."""

    @property
    def share(self) -> float:
        """Part of the limit that is used; 1 is all of it."""
        if self.name == "least_thrust":
            return self.allowed / max(self.peak, 1e-9)
        return self.peak / self.allowed


@dataclass(frozen=True)
class LimitReport:
    """What a curve asks for of everything that is limited."""

    loads: tuple[Load, ...]

    @property
    def holds(self) -> bool:
        """Whether the curve keeps within all limits."""
        return all(load.share <= _ROUNDING for load in self.loads)

    @property
    def binding(self) -> Load | None:
        """The limit that is used most; None where nothing is limited."""
        return max(self.loads, key=lambda load: load.share, default=None)

    def __str__(self) -> str:
        lines = (f"{x.name}: {x.peak:.3g} of {x.allowed:.3g} ({x.share:.0%}) at {x.time:.2f} s" for x in self.loads)
        return "\n".join(lines)


def check_limits(curve: Polynomial, limits: Limits) -> LimitReport:
    """Return what *curve* (x, y, z) asks for of each thing that is limited."""
    ends = np.concatenate(
        [np.linspace(a, b, _SAMPLES, endpoint=False) for a, b in zip(curve.knots[:-1], curve.knots[1:], strict=True)]
    )
    times = np.append(ends, curve.duration)
    coarse = _Motion(curve, times)
    loads = []
    for name, measure in _MEASURES.items():
        allowed = getattr(limits, name)
        if allowed is None:
            continue
        sign = -1.0 if name == "least_thrust" else 1.0
        at, values = times, measure(coarse, limits)
        for _ in range(2):
            k = int(np.argmax(sign * values))
            at = np.linspace(at[max(k - 1, 0)], at[min(k + 1, len(at) - 1)], _CLOSER)
            values = measure(_Motion(curve, at), limits)
        best = int(np.argmax(sign * values))
        loads.append(Load(name, float(values[best]), float(allowed), float(at[best])))
    return LimitReport(tuple(loads))


class _Motion:
    """Velocity, acceleration and jerk of a curve, and where the drone pushes, at times."""

    def __init__(self, curve: Polynomial, times: Array) -> None:
        self.velocity, self.acceleration, self.jerk = (curve.at(times, order) for order in (1, 2, 3))
        self.push = self.acceleration + np.array([0.0, 0.0, GRAVITY])
        self.size = np.linalg.norm(self.push, axis=-1)


def _body_rate(motion: _Motion, _: Limits) -> Array:
    size = np.maximum(motion.size, 1e-9)[:, None]
    z = motion.push / size
    across = motion.jerk - (motion.jerk * z).sum(axis=-1, keepdims=True) * z
    return np.linalg.norm(across / size, axis=-1)


_MEASURES: dict[str, Callable[[_Motion, Limits], Array]] = {
    "speed": lambda motion, _: np.linalg.norm(motion.velocity, axis=-1),
    "acceleration": lambda motion, _: np.linalg.norm(motion.acceleration, axis=-1),
    "jerk": lambda motion, _: np.linalg.norm(motion.jerk, axis=-1),
    "thrust": lambda motion, limits: limits.mass * motion.size,
    "least_thrust": lambda motion, limits: limits.mass * motion.size,
    "tilt": lambda motion, _: np.arctan2(np.hypot(*motion.push[:, :2].T), motion.push[:, 2]),
    "body_rate": _body_rate,
}

_POWERS = {"speed": 1.0, "jerk": 3.0, "body_rate": 3.0}
"""With which power of the duration a load falls, at rest at both ends; others with the second, or nearly."""


def fit_duration(
    plan: Callable[[float], Polynomial], limits: Limits, *, may_shrink: bool = False
) -> tuple[Polynomial, float, LimitReport]:
    """Find how slowly a curve must be flown.

    Args:
        plan: Returns the curve whose times are stretched by a factor. From rest to rest that is `Polynomial.stretched`;
            a curve that begins in flight is planned again, because its begin must not change.
        limits: What must hold.
        may_shrink: Fly it faster, too, as long as all limits hold.

    Returns:
        The curve, the factor, and its report. Where a curve begins beyond a limit, nothing holds: then it is the
        shortest of those that are nearly the least beyond.
    """
    factor = 1.0
    fails, good, bad = 0.0, None, []
    for _ in range(40):
        curve = plan(factor)
        report = check_limits(curve, limits)
        if report.holds:
            good = (factor, curve, report)
            if factor <= fails * 1.001 or (not may_shrink and factor <= 1.0):
                break
            wished = factor * min(max(_wish(report, limits), 0.5), 0.9995)
            # below what is known to fail there is nothing to find
            factor = math.sqrt(fails * factor) if wished <= fails else wished
            factor = factor if may_shrink else max(factor, 1.0)
        else:
            fails = max(fails, factor)
            bad.append((factor, curve, report))
            wished = factor * min(max(_wish(report, limits), 1.0005), 2.0)
            if good is not None:
                if good[0] <= fails * 1.001:
                    break
                wished = min(wished, math.sqrt(fails * good[0]))
            factor = wished
    if good is None:
        least = min(found[2].binding.share for found in bad)
        good = min((found for found in bad if found[2].binding.share <= 1.02 * least), key=lambda found: found[0])
    factor, curve, report = good
    return curve, factor, report


def _wish(report: LimitReport, limits: Limits) -> float:
    """Return the factor by which the duration should grow, judged by how loads fall with it."""
    # only what thrust is above or below that of hovering changes with time
    hover = {"thrust", "least_thrust"}
    rest = (limits.mass or 0.0) * GRAVITY
    shares = {
        load.name: max((load.peak - rest) / (load.allowed - rest), 0.0) if load.name in hover else load.share
        for load in report.loads
    }
    return max((share ** (1.0 / _POWERS.get(name, 2.0)) for name, share in shares.items()), default=1.0)
