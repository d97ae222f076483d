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

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.control.safety.barrier_filter import BarrierFilter, positive, unit
from crazychoir_fw.control.safety.half_planes import HalfPlanes
from crazychoir_fw.control.safety.planar_program import nearest
from crazychoir_fw.control.safety.relative_motion import RelativeMotion
from crazychoir_fw.onboard.arrays import doubles, filled_by_core

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
        return self._planes(offset, closing).barriers

    def rows(self, offset: Array, closing: Array) -> tuple[Array, Array]:
        """Return normals (..., 2) and right sides (...) of the half-planes of accelerations that are safe (m/s^2).

        Normals have length 1; at infinity they are zero, and the right side is infinite.
        """
        return self._planes(offset, closing)[:2]

    def _planes(self, offset: Array, closing: Array) -> HalfPlanes:
        offset = np.asarray(offset, float)
        lead = offset.shape[:-1]
        planes = HalfPlanes(np.empty((*lead, 2)), np.empty(lead), np.empty(lead))
        braking = 2.0 * self.max_acceleration * self.kappa
        lib.cf_acceleration_barriers(
            planes.sides.size,
            doubles(offset, (*lead, 2)),
            doubles(closing, (*lead, 2)),
            ffi.new(
                "cf_acceleration_barrier_t *", (self.distance, self.gamma, braking, 2.0**0.5 if self.legacy else 1.0)
            ),
            *map(filled_by_core, planes),
        )
        return planes

    def _half_planes(self, motion: RelativeMotion) -> HalfPlanes:
        return self._planes(motion.offset, motion.closing)

    def _safe(self, desired: Array, motion: RelativeMotion, planes: HalfPlanes) -> tuple[Array, NDArray[np.bool_]]:
        safe, found = nearest(desired, planes.normals, planes.sides, self.max_acceleration)
        # within the distance, h < 0 says that they come nearer; beyond it, that they may no longer be able to stop
        braking = (planes.barriers < 0.0).any(axis=1) | ~found
        if braking.any():
            velocity = motion.velocity[braking]
            speed = np.hypot(velocity[:, 0], velocity[:, 1])[:, None]
            safe[braking] = np.where(speed > _AT_REST, -self.max_braking_acceleration * unit(velocity), 0.0)
        return safe, braking
