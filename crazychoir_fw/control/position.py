"""Flatness laws: a force, and the thrust and attitude that make it (features dossier 4.3)."""

from __future__ import annotations

import math
from abc import abstractmethod

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.control.components import (
    Component,
    cosine_and_sine,
    join,
    larger,
    scalar,
    smaller,
    split,
    sqrt,
    up_axis,
)
from crazychoir_fw.control.gains import POSITION_GAINS, PositionGains, chosen_gains
from crazychoir_fw.control.strategies import PositionCtrlStrategy
from crazychoir_fw.errors import RangeError
from crazychoir_fw.messages import Pose, Reference

Array = NDArray[np.float64]

DEFAULT_MASS = 0.038
"""Mass of the vehicle (kg) that the original believes in."""
STANDARD_GRAVITY = 9.80665
"""Acceleration of gravity (m/s^2) of the original."""


class FlatnessCtrl(PositionCtrlStrategy):
    """What the flatness laws share: a force decides on the thrust axis, the reference's yaw on the heading.

    With z along the force, x and y follow from the heading. When the reference has a jerk or a yaw rate,
    `desired_rates` are those at which this attitude turns: F' = m jerk makes p = -y.F'/|F| and q = x.F'/|F|, and r is
    what keeps y level (features dossier 4.3; Mellinger and Kumar 2011).
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
        self._least_lift = scalar(self.gains.least_lift * self.mass * self.gravity)
        self._max_slope = math.tan(self.gains.max_tilt) if self.gains.max_tilt < math.pi / 2.0 else None

    @abstractmethod
    def force(self, current_pose: Pose, desired_reference: Reference) -> Array:
        """Return the force of the rotors that is wanted (N, world), shape (..., 3), before it is limited."""

    def control(self, current_pose: Pose, desired_reference: Reference) -> tuple[Array, Array]:
        """See `PositionCtrlStrategy`."""
        fx, fy, fz = self._limited(*split(self.force(current_pose, desired_reference)))
        size = sqrt(fx * fx + fy * fy + fz * fz)
        zx, zy, zz = fx / size, fy / size, fz / size

        # y = z x heading, which lies in the ground plane; z always points up a little, so that it has a length
        yaw = desired_reference.yaw
        c, s = (1.0, 0.0) if yaw is None else cosine_and_sine(scalar(yaw))
        level = zx * s - zy * c
        length = sqrt(zz * zz + level * level)
        yx, yy, yz = -zz * s / length, zz * c / length, level / length
        xx, xy, xz = yy * zz - yz * zy, yz * zx - yx * zz, yx * zy - yy * zx

        bx, by, bz = up_axis(np.asarray(current_pose.orientation))
        thrust = larger(fx * bx + fy * by + fz * bz, 0.0)
        shape = np.shape(thrust)
        attitude = join((xx, yx, zx, xy, yy, zy, xz, yz, zz), shape).reshape(*shape, 3, 3)

        self.desired_rates = None
        if desired_reference.jerk is not None or desired_reference.yaw_rate is not None:
            p = q = 0.0
            if desired_reference.jerk is not None:
                jx, jy, jz = split(self._mass * np.asarray(desired_reference.jerk))
                p = -(yx * jx + yy * jy + yz * jz) / size
                q = (xx * jx + xy * jy + xz * jz) / size
            turn = 0.0 if desired_reference.yaw_rate is None else scalar(desired_reference.yaw_rate)
            r = (p * (zx * c + zy * s) + turn * (yy * c - yx * s)) / length
            self.desired_rates = join((p, q, r), shape)
        return np.asarray(thrust), attitude

    def _limited(self, fx: Component, fy: Component, fz: Component) -> tuple[Component, Component, Component]:
        """Return a force that points upwards, and not too far aside."""
        fz = larger(fz, self._least_lift)
        if self._max_slope is not None:
            aside = sqrt(fx * fx + fy * fy) + 1e-12
            scale = smaller(fz * self._max_slope / aside, 1.0)
            fx, fy = fx * scale, fy * scale
        return fx, fy, fz


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
