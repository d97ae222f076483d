"""Flatness laws: a force, and the thrust and attitude that make it (docs/reference/crazychoir.md#4.3)."""

from __future__ import annotations

import math
from abc import abstractmethod

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.control.gains import POSITION_GAINS, PositionGains, chosen_gains
from crazychoir_fw.control.strategies import PositionCtrlStrategy
from crazychoir_fw.onboard.arrays import doubles, filled_by_core

Array = NDArray[np.float64]

DEFAULT_MASS = 0.038
"""Mass of the vehicle (kg) that the original believes in."""
STANDARD_GRAVITY = 9.80665
"""Acceleration of gravity (m/s^2) of the original."""


class FlatnessCtrl(PositionCtrlStrategy):
    """What the flatness laws share: a force decides on the thrust axis, the reference's yaw on the heading.

    With z along the force, x and y follow from the heading (``bindings/laws/flatness.c``). Where the reference has jerk
    or yaw rate, `desired_rates` are those at which this attitude turns: F' = m jerk makes p = -y.F'/|F| and
    q = x.F'/|F|, and r is what keeps y level (docs/reference/crazychoir.md#4.3; Mellinger and Kumar 2011).
    """

    def __init__(
        self,
        update_frequency: float = 100.0,
        vicon: bool = False,
        *,
        gains: str | PositionGains | None = None,
        mass: ArrayLike = DEFAULT_MASS,
        gravity: float = STANDARD_GRAVITY,
    ) -> None:
        """Choose gains and vehicle.

        Args:
            update_frequency: How often `control` is called (Hz): the integral counts these periods.
            vicon: Short for ``gains="vicon"``.
            gains: ``webots`` (default), ``vicon``, ``mujoco`` or gains of your own.
            mass: Mass of the vehicle (kg), a number or shape (...): thrust is in newtons, so a wrong mass becomes a
                wrong height.
            gravity: Acceleration of gravity (m/s^2).

        Raises:
            RangeError: If a number is outside its range.
            UnknownNameError: If there is no such gain set.
        """
        super().__init__(update_frequency)
        who = type(self).__name__
        self.gains = chosen_gains(who, POSITION_GAINS, gains, vicon)
        self.mass = np.asarray(mass, float)
        self.gravity = float(gravity)
        if not (np.all(self.mass > 0.0) and np.all(np.isfinite(self.mass))):
            raise RangeError(f"{who}: mass is {mass}, allowed: above 0 kg")
        if not 0.0 < self.gravity < math.inf:
            raise RangeError(f"{who}: gravity is {gravity}, allowed: above 0 m/s^2")
        # one mass for each drone must line up with vectors of shape (..., 3)
        self._mass = self.mass[..., None] if self.mass.ndim else float(self.mass)
        self._weight = self._mass * np.array([0.0, 0.0, self.gravity])
        self._least_lift = self.gains.least_lift * self.mass * self.gravity
        self._max_slope = math.tan(self.gains.max_tilt) if self.gains.max_tilt < math.pi / 2.0 else math.inf

    @abstractmethod
    def force(self, current_pose: Pose, desired_reference: Reference) -> Array:
        """Return the force of the rotors that is wanted (N, world), shape (..., 3), before it is limited."""

    def control(self, current_pose: Pose, desired_reference: Reference) -> tuple[Array, Array]:
        """See `PositionCtrlStrategy`."""
        force, orientation = self.force(current_pose, desired_reference), np.asarray(current_pose.orientation, float)
        lead = orientation.shape[:-1]
        if lead != force.shape[:-1]:
            lead = np.broadcast_shapes(lead, force.shape[:-1])  # one reference for many poses
        jerk, yaw_rate = _unless_zero(desired_reference.jerk), _unless_zero(desired_reference.yaw_rate)
        yaw = _unless_zero(desired_reference.yaw)
        parts = (
            doubles(force, (*lead, 3)),
            doubles(orientation, (*lead, 4)),
            doubles(self._least_lift, lead),
            self._max_slope,
            ffi.NULL if yaw is None else doubles(yaw, lead),
            ffi.NULL if jerk is None else doubles(self._mass * jerk, (*lead, 3)),
            ffi.NULL if yaw_rate is None else doubles(yaw_rate, lead),
        )
        thrust, attitude, rates = np.empty(lead), np.empty((*lead, 3, 3)), np.empty((*lead, 3))
        wanted = ffi.new("cf_flatness_t *", parts)  # refers to the parts, and does not keep them
        lib.cf_flatness(thrust.size, wanted, filled_by_core(thrust), filled_by_core(attitude), filled_by_core(rates))
        self.desired_rates = None if jerk is None and yaw_rate is None else rates
        return thrust, attitude


def _unless_zero(values: ArrayLike | None) -> Array | None:
    """Return what a reference says, or None where it says nothing or zero: most drones fly straight at yaw 0."""
    if values is None:
        return None
    given = np.asarray(values, float)
    return given if np.count_nonzero(given) else None


class FlatnessPositionCtrl(FlatnessCtrl):
    """Tracks position, velocity, acceleration and yaw.

    F = m (g e3 + a_d) - k_p (p - p_d) - k_v (v - v_d) - k_i times the integral of (p - p_d)

    What the reference lacks: without position nothing pulls back, without velocity the drone is to stand still, without
    acceleration and yaw they are zero.
    """

    _integral: Array | float = 0.0

    def __init__(
        self,
        update_frequency: float = 100.0,
        vicon: bool = False,
        *,
        gains: str | PositionGains | None = None,
        mass: ArrayLike = DEFAULT_MASS,
        gravity: float = STANDARD_GRAVITY,
    ) -> None:
        """See `FlatnessCtrl`."""
        super().__init__(update_frequency, vicon, gains=gains, mass=mass, gravity=gravity)
        scale = self._mass if self.gains.per_kilogram else 1.0
        g = self.gains
        self._k_p, self._k_v, self._k_i, self._drag = (scale * np.array(k) for k in (g.k_p, g.k_v, g.k_i, g.drag))
        self._has_integral, self._has_drag = any(g.k_i), any(g.drag)

    def force(self, current_pose: Pose, desired_reference: Reference) -> Array:
        """See `FlatnessCtrl`."""
        force = self._weight
        if desired_reference.acceleration is not None:
            force = force + self._mass * np.asarray(desired_reference.acceleration)
        if desired_reference.position is not None:
            error = current_pose.position - np.asarray(desired_reference.position)
            if self._has_integral:
                force = force - self._k_i * self._integrated(error)
            limit = self.gains.error_limit
            if limit < math.inf:
                error = np.minimum(np.maximum(error, -limit), limit)
            force = force - self._k_p * error
        velocity = current_pose.velocity
        if desired_reference.velocity is not None:
            wanted = np.asarray(desired_reference.velocity)
            velocity = velocity - wanted
            if self._has_drag:
                force = force + self._drag * wanted
        return force - self._k_v * velocity

    def _integrated(self, error: Array) -> Array:
        """Return the integral of the position error (m s) after another period."""
        zone, limit = self.gains.integral_zone, self.gains.integral_limit
        if zone < math.inf:
            error = np.where(np.abs(error) < zone, error, 0.0)
        integral = self._integral + error / self.update_frequency
        self._integral = np.minimum(np.maximum(integral, -limit), limit)
        return self._integral

    def reset(self) -> None:
        """Forget the integral."""
        self._integral = 0.0


class FlatnessAccelerationCtrl(FlatnessCtrl):
    """Makes an acceleration: F = m (g e3 + a_d). Without one the drone is to hover; nothing holds it in place."""

    follows_position = False

    def force(self, current_pose: Pose, desired_reference: Reference) -> Array:
        """See `FlatnessCtrl`."""
        if desired_reference.acceleration is None:
            return self._weight
        return self._weight + self._mass * np.asarray(desired_reference.acceleration)
