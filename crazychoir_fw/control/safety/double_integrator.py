r"""Safety filter of accelerations (docs/reference/crazychoir.md#9).

Barrier of two agents, with :math:`\Delta p, \Delta v` from the other to this one and
:math:`D = |\Delta p| - d`: they can still stop in time while

.. math:: h = \frac{\Delta p^T \Delta v}{|\Delta p|} + \sqrt{2 a \kappa D} \ge 0 \quad (m/s)

Each keeps its half of :math:`\dot h \ge -\gamma h^3`:

.. math::
    -\Delta p^T u \le \frac{1}{2} \left( \gamma h^3 |\Delta p| + |\Delta v|^2
    - \frac{(\Delta p^T \Delta v)^2}{|\Delta p|^2} + \frac{2 a \kappa \, \Delta p^T \Delta v}{2 \sqrt{2 a \kappa D}}
    \right)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.control.safety.barrier_filter import BarrierFilter, positive, unit
from crazychoir_fw.control.safety.planar_program import nearest

Array = NDArray[np.float64]

_AT_REST = 1e-5  # [m/s]


class DoubleIntegratorCBF(BarrierFilter):
    """Keeps agents apart that follow accelerations. An input at its limit is a solution like any other.

    An agent that can no longer keep all barriers brakes against its velocity. An agent that is within the distance, but
    does not approach, may use every acceleration without a component towards its neighbor.
    """

    filters = "acceleration"
    _needs_velocity = True

    def __init__(
        self,
        distance: float = 0.4,
        gamma: float = 0.1,
        kappa: float = 1.0,
        max_acceleration: float = 0.1,
        max_braking_acceleration: float = 0.2,
        *,
        keep_right: float = 0.0,
        legacy: bool = False,
    ) -> None:
        """Choose it.

        Args:
            distance: Least distance of two agents (m).
            gamma: How fast a barrier may fall (s/m^2): higher brakes later.
            kappa: Share of the braking of both, 2 a, that the barrier counts on, above 0; 2 is all there is.
            max_acceleration: Largest acceleration along x and along y, a (m/s^2): not a force.
            max_braking_acceleration: Deceleration of a braking agent (m/s^2).
            keep_right: Which part of what is taken away of an acceleration goes to its right, see `BarrierFilter`.
            legacy: The last term as the original has it, larger by the square root of 2: not quite the derivative of h.

        Raises:
            RangeError: If a number is not above zero.
        """
        super().__init__(distance, keep_right)
        self.gamma = positive("gamma", gamma, "s/m^2")
        self.kappa = positive("kappa", kappa, "")
        self.max_acceleration = positive("max_acceleration", max_acceleration, "m/s^2")
        self.max_braking_acceleration = positive("max_braking_acceleration", max_braking_acceleration, "m/s^2")
        self.legacy = legacy

    @property
    def limit(self) -> float:
        """See `BarrierFilter`."""
        return self.max_acceleration

    def barriers(self, offset: Array, closing: Array) -> Array:
        """Return the barriers (m/s), shape (...).

        Args:
            offset: From others to the own position (m), shape (..., 2).
            closing: Velocity relative to others (m/s), shape (..., 2).
        """
        length, _, approach = _geometry(offset, closing)
        return self._barriers(length, approach)

    def _barriers(self, length: Array, approach: Array) -> Array:
        return approach + np.sqrt(2.0 * self.max_acceleration * self.kappa * np.maximum(length - self.distance, 0.0))

    def rows(self, offset: Array, closing: Array) -> tuple[Array, Array]:
        """Return normals (..., 2) and right sides (...) of the half-planes of accelerations that are safe (m/s^2)."""
        return self._rows(closing, *_geometry(offset, closing))[:2]

    def _rows(self, closing: Array, length: Array, away: Array, approach: Array) -> tuple[Array, Array, Array]:
        """Return normals, right sides and barriers of neighbors, see `_geometry`."""
        known = np.isfinite(length)
        h = self._barriers(length, approach)
        vx, vy = closing[..., 0], closing[..., 1]
        brake = 2.0 * self.max_acceleration * self.kappa
        with np.errstate(divide="ignore", invalid="ignore"):
            across = (vx * vx + vy * vy - approach**2) / length
            slowing = brake * approach / (2.0 * np.sqrt(brake * (length - self.distance)))
            if self.legacy:
                slowing = slowing * np.sqrt(2.0)
            b = 0.5 * (self.gamma * h**3 + across + slowing)
        too_near = length <= self.distance
        # divided by the distance: normals of length 1 and right sides in m/s^2
        return -away, np.where(known, np.where(too_near, 0.0, b), np.inf), h

    def _safe(
        self, desired: Array, velocity: Array, offset: Array, closing: Array
    ) -> tuple[Array, NDArray[np.bool_], Array]:
        A, b, h = self._rows(closing, *_geometry(offset, closing))
        safe, found = nearest(desired, A, b, self.max_acceleration)
        # within the distance, h < 0 says that they come nearer; beyond it, that they may no longer be able to stop
        braking = np.any(h < 0.0, axis=1) | ~found
        speed = np.linalg.norm(velocity, axis=-1, keepdims=True)
        brake = np.where(speed > _AT_REST, -self.max_braking_acceleration * unit(velocity), 0.0)
        return np.where(braking[:, None], brake, safe), braking, h


def _geometry(offset: Array, closing: Array) -> tuple[Array, Array, Array]:
    """Return distances (m), directions away from others and how fast distances grow (m/s).

    Component by component: reductions over two numbers take most of the time of a filter of ten drones.

    Args:
        offset: From others to the own position (m), shape (..., 2); infinite for padding.
        closing: Velocity relative to others (m/s), shape (..., 2).

    Returns:
        Shapes (...), (..., 2) and (...).
    """
    x, y = offset[..., 0], offset[..., 1]
    length = np.sqrt(x * x + y * y)
    is_direction = (length > 0.0) & np.isfinite(length)
    with np.errstate(invalid="ignore", divide="ignore"):
        away = np.where(is_direction[..., None], offset / length[..., None], 0.0)
    return length, away, away[..., 0] * closing[..., 0] + away[..., 1] * closing[..., 1]
