"""Gains of the control laws, by name: those of the original and one for our plant.

docs/reference/crazychoir.md#4.3 to #4.5.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

from crazychoir_fw.common.errors import RangeError, UnknownNameError

Three = tuple[float, float, float]


def _check_three(gains: object, name: str) -> None:
    """Check three gains; one number stands for all."""
    value = getattr(gains, name)
    try:
        three = (float(value),) * 3 if isinstance(value, int | float) else tuple(float(k) for k in value)
    except (TypeError, ValueError):
        three = ()
    _check(
        gains, name, len(three) == 3 and all(0.0 <= k < math.inf for k in three), "three finite numbers, not below 0"
    )
    object.__setattr__(gains, name, three)


def _check(gains: object, name: str, is_allowed: bool, allowed: str) -> None:
    assert dataclasses.is_dataclass(gains)
    if not is_allowed:
        raise RangeError(f"{type(gains).__name__}: {name} is {getattr(gains, name)}, allowed: {allowed}")


@dataclass(frozen=True)
class PositionGains:
    """Gains of the flatness laws, along world x, y, z."""

    k_p: Three
    """Force per position error (N/m)."""
    k_v: Three
    """Force per velocity error (N s/m)."""
    k_i: Three = (0.0, 0.0, 0.0)
    """Force per integral of the position error (N/(m s))."""
    per_kilogram: bool = False
    """Whether the gains are per kilogram of the vehicle, so that they fit every mass (1/s^2, 1/s, 1/s^3)."""
    error_limit: float = math.inf
    """Largest position error that counts (m), per axis: far from its goal a drone flies at k_p / k_v times this."""
    integral_limit: float = 1.0
    """Largest integral of the position error (m s), per axis: it cannot wind up."""
    integral_zone: float = math.inf
    """Position errors beyond it (m), per axis, are no matter of the integral: those of a flight to a far goal."""
    drag: Three = (0.0, 0.0, 0.0)
    """Force per velocity of the reference (N s/m, or 1/s per kilogram), against the drag of the air."""
    max_tilt: float = math.inf
    """Largest tilt that is asked for (rad); above a right angle there is no limit."""
    least_lift: float = 0.1
    """Least upward force, as a part of the weight, in [0.001, 1]: thrust never points down or sideways."""

    def __post_init__(self) -> None:
        for name in ("k_p", "k_v", "k_i", "drag"):
            _check_three(self, name)
        for name in ("error_limit", "integral_limit", "integral_zone", "max_tilt"):
            _check(self, name, getattr(self, name) > 0.0, "above 0")
        _check(self, "least_lift", 0.001 <= self.least_lift <= 1.0, "0.001 to 1")


@dataclass(frozen=True)
class AttitudeGains:
    """Gains of the geometric attitude law, about body x, y, z."""

    k_r: Three
    """Body rate per attitude error (1/s)."""
    k_w: Three
    """Body rate per error of the body rate."""

    def __post_init__(self) -> None:
        for name in ("k_r", "k_w"):
            _check_three(self, name)


@dataclass(frozen=True)
class VelocityGains:
    """Gains of the velocity law, along world x, y, z."""

    k_p: Three
    """Velocity per position error (1/s)."""
    k_v: Three
    """Velocity per velocity error."""
    feed_forward: float = 0.0
    """Part of the reference's velocity that is commanded besides, in [0, 1]."""
    k_yaw: float = 1.0
    """Yaw rate per error of the heading (1/s), where the reference has a heading."""

    def __post_init__(self) -> None:
        for name in ("k_p", "k_v"):
            _check_three(self, name)
        _check(self, "feed_forward", 0.0 <= self.feed_forward <= 1.0, "0 to 1")
        _check(self, "k_yaw", 0.0 <= self.k_yaw < math.inf, "0 or more, and finite")


POSITION_GAINS: Mapping[str, PositionGains] = {
    "webots": PositionGains(k_p=(0.400, 0.400, 1.250), k_v=(0.200, 0.200, 0.400)),
    "vicon": PositionGains(k_p=(0.720, 0.720, 1.500), k_v=(0.120, 0.120, 0.400)),
    "mujoco": PositionGains(
        k_p=(10.0, 10.0, 12.0),
        k_v=(5.0, 5.0, 6.0),
        k_i=(0.5, 0.5, 0.5),
        per_kilogram=True,
        error_limit=1.0,
        integral_zone=0.2,
        drag=(0.46, 0.46, 0.46),
        max_tilt=math.radians(40.0),
        least_lift=0.3,
    ),
}
"""Gain sets of `FlatnessPositionCtrl` and `FlatnessAccelerationCtrl`."""

ATTITUDE_GAINS: Mapping[str, AttitudeGains] = {
    "webots": AttitudeGains(k_r=(16.0, 16.0, 0.2), k_w=(0.56, 0.56, 0.07)),
    "vicon": AttitudeGains(k_r=(12.0, 12.0, 8.0), k_w=(0.10, 0.10, 0.08)),
    "mujoco": AttitudeGains(k_r=(9.0, 9.0, 2.0), k_w=(0.0, 0.0, 0.0)),
}
"""Gain sets of `GeometryAttitudeCtrl`."""

VELOCITY_GAINS: Mapping[str, VelocityGains] = {
    "webots": VelocityGains(k_p=(0.4, 0.4, 0.4), k_v=(0.01, 0.01, 0.01)),
    "vicon": VelocityGains(k_p=(0.4, 0.4, 0.4), k_v=(0.01, 0.01, 0.01)),
    "mujoco": VelocityGains(k_p=(1.0, 1.0, 1.0), k_v=(0.0, 0.0, 0.0), feed_forward=1.0),
}
"""Gain sets of `VelocityCtrlStrategy`."""

Gains = TypeVar("Gains", PositionGains, AttitudeGains, VelocityGains)


def chosen_gains(who: str, sets: Mapping[str, Gains], gains: str | Gains | None, vicon: bool = False) -> Gains:
    """Return a gain set: the one of that name, the gains themselves, or by default that of `vicon`.

    Raises:
        UnknownNameError: If there is no such set.
        RangeError: If it is the gains of another law.
    """
    if gains is None:
        gains = "vicon" if vicon else "webots"
    if isinstance(gains, str):
        if gains not in sets:
            raise UnknownNameError(f"{who}: gains is '{gains}', allowed: {', '.join(sets)}")
        return sets[gains]
    kind = type(next(iter(sets.values())))
    if not isinstance(gains, kind):
        raise RangeError(f"{who}: gains is {type(gains).__name__}, allowed: {', '.join(sets)} or {kind.__name__}")
    return gains
