"""Flatness laws: a force, and the thrust and attitude that make it (docs/reference/crazychoir.md#4.3)."""

from __future__ import annotations

import math
from abc import abstractmethod

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.control.gains import POSITION_GAINS, PositionGains, chosen_gains
from crazychoir_fw.control.strategies import PositionCtrlStrategy

Array = NDArray[np.float64]

DEFAULT_MASS = 0.038
"""Mass of the vehicle (kg) that the original believes in."""
STANDARD_GRAVITY = 9.80665
"""Acceleration of gravity (m/s^2) of the original."""

_TINY = 1e-300  # keeps a force that points straight up from dividing by zero


class FlatnessCtrl(PositionCtrlStrategy):
    """What the flatness laws share: a force decides on the thrust axis, the reference's yaw on the heading.

    With z along the force, x and y follow from the heading. When the reference has a jerk or a yaw rate,
    `desired_rates` are those at which this attitude turns: F' = m jerk makes p = -y.F'/|F| and q = x.F'/|F|, and r is
    what keeps y level (docs/reference/crazychoir.md#4.3; Mellinger and Kumar 2011).
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
        self._least_lift = (self.gains.least_lift * self.mass * self.gravity).T
        self._max_slope = math.tan(self.gains.max_tilt) if self.gains.max_tilt < math.pi / 2.0 else None

    @abstractmethod
    def force(self, current_pose: Pose, desired_reference: Reference) -> Array:
        """Return the force of the rotors that is wanted (N, world), shape (..., 3), before it is limited."""

    def control(self, current_pose: Pose, desired_reference: Reference) -> tuple[Array, Array]:
        """See `PositionCtrlStrategy`."""
        # axes first and drones last, so that one text serves one drone and many
        force = self._limited(self.force(current_pose, desired_reference).T)
        size = np.sqrt(np.add.reduce(force * force))
        axes = np.empty((3, *force.shape))
        x, y, z = axes
        np.divide(force, size, out=z)

        # y = z x heading, which lies in the ground plane; z always points up a little, so that it has a length.
        # In the frame of the heading y is (0, zz, -side) / length and x = y x z = (length, beside, yz -ahead)
        yaw = _unless_zero(desired_reference.yaw)
        ahead, side = z[0], z[1]
        if yaw is not None:
            c, s = np.cos(yaw).T, np.sin(yaw).T
            ahead, side = ahead * c + side * s, side * c - ahead * s
        length = np.hypot(z[2], side)
        level = z[2] / length
        np.divide(-side, length, out=y[2, ...])
        beside = y[2] * ahead
        np.multiply(level, -ahead, out=x[2, ...])
        if yaw is None:
            x[0], x[1], y[0], y[1] = length, beside, 0.0, level
        else:
            x[0], x[1] = length * c - beside * s, length * s + beside * c
            y[0], y[1] = -level * s, level * c

        up = current_pose.rotation[..., 2].T
        thrust = np.maximum(np.einsum("i...,i...->...", force, up), 0.0)
        self.desired_rates = self._rates(desired_reference, axes, size, ahead, length)
        attitude = axes.T
        if attitude.ndim < thrust.ndim + 2:
            attitude = np.tile(attitude, (*np.shape(thrust), 1, 1))  # one reference for many poses
        return thrust.T, attitude

    def _rates(self, reference: Reference, axes: Array, size: Array, ahead: Array, length: Array) -> Array | None:
        """Return the rates at which the attitude turns (rad/s), shape (..., 3), if it does.

        Args:
            reference: Its jerk makes p and q, its yaw rate r.
            axes: x, y and z of the attitude, shape (3, 3, ...).
            size: Of the force (N), shape (...).
            ahead: How much z leans ahead.
            length: Of z x heading.
        """
        given, turning = _unless_zero(reference.jerk), _unless_zero(reference.yaw_rate)
        if given is None and turning is None:
            return None
        rates = np.zeros((3, *size.shape))
        if given is not None:
            jerk = (self._mass * given).T
            across = np.einsum("ki...,i...->k...", axes[:2], jerk) / size
            np.negative(across[1], out=rates[0, ...])
            rates[1] = across[0]
            rates[2] = rates[0] * (ahead / length)
        if turning is not None:
            level = axes[2, 2] / length  # as y is
            rates[2] += turning.T * (level / length)
        return rates.T

    def _limited(self, force: Array) -> Array:
        """Return a force, shape (3, ...), that points upwards, and not too far aside."""
        limited = np.array(force, order="C")
        np.maximum(limited[2], self._least_lift, out=limited[2, ...])
        if self._max_slope is not None:
            aside, widest = np.hypot(limited[0], limited[1]), limited[2] * self._max_slope
            if (aside > widest).any():
                limited[:2] *= np.minimum(widest / np.maximum(aside, _TINY), 1.0)
        return limited


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
