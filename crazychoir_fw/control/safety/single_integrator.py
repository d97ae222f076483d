r"""Safety filter of velocities (docs/reference/crazychoir.md#9).

Barrier of two agents, with :math:`\Delta p` from the other to this one: :math:`h = |\Delta p|^2 - d^2` (m^2). Each of
the two keeps its half of :math:`\dot h \ge -2 \gamma h^3`, that is :math:`-2 \Delta p^T u \le \gamma h^3`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.control.safety.barrier_filter import BarrierFilter, positive, unit
from crazychoir_fw.control.safety.half_planes import HalfPlanes
from crazychoir_fw.control.safety.planar_program import nearest
from crazychoir_fw.control.safety.relative_motion import RelativeMotion

Array = NDArray[np.float64]

_TOO_NEAR = 1.2  # times the distance, within which an agent backs off rather than asks for its input
_SEEN = 1.5  # times the distance, within which others count for the direction


class SingleIntegratorCBF(BarrierFilter):
    """Keeps agents apart that follow velocities. An input at its limit is a solution like any other.

    An agent within 1.2 times the distance of its nearest neighbor backs off from it. The barriers towards all its
    neighbors hold meanwhile.
    """

    filters = "velocity"
    _needs_velocity = False

    def __init__(
        self,
        distance: float = 0.4,
        gamma: float = 5.0,
        max_velocity: float = 0.2,
        max_braking_velocity: float = 0.4,
        *,
        keep_right: float = 0.0,
    ) -> None:
        """Choose it.

        Args:
            distance: Least distance of two agents (m).
            gamma: How fast a barrier may fall (1/(m^4 s)): higher brakes later.
            max_velocity: Largest velocity along x and along y (m/s).
            max_braking_velocity: Speed at which an agent backs off (m/s).
            keep_right: Which part of what is taken away of a velocity goes to its right, see `BarrierFilter`.

        Raises:
            RangeError: If one is not above zero.
        """
        super().__init__(distance, keep_right)
        self.gamma = positive("gamma", gamma, "1/(m^4 s)")
        self.max_velocity = positive("max_velocity", max_velocity, "m/s")
        self.max_braking_velocity = positive("max_braking_velocity", max_braking_velocity, "m/s")

    @property
    def limit(self) -> float:
        """See `BarrierFilter`."""
        return self.max_velocity

    def barriers(self, offset: Array) -> Array:
        """Return the barriers (m^2), shape (...), of offsets from others to the own position (m), shape (..., 2)."""
        return np.sum(offset**2, axis=-1) - self.distance**2

    def rows(self, offset: Array) -> tuple[Array, Array]:
        """Return normals (..., 2) and right sides (...) of the half-planes of velocities that are safe (m/s)."""
        known = np.isfinite(offset).all(axis=-1)
        h = np.where(known, self.barriers(offset), np.inf)
        # agents that are too near already must not approach, but need not separate at once: u = 0 is always a solution
        return np.where(known[..., None], -2.0 * offset, 0.0), self.gamma * np.maximum(h, 0.0) ** 3

    def _half_planes(self, motion: RelativeMotion) -> HalfPlanes:
        return HalfPlanes(*self.rows(motion.offset), self.barriers(motion.offset))

    def _safe(self, desired: Array, motion: RelativeMotion, planes: HalfPlanes) -> tuple[Array, NDArray[np.bool_]]:
        offset = motion.offset
        length = np.hypot(offset[..., 0], offset[..., 1])
        braking = (length <= _TOO_NEAR * self.distance).any(axis=1)
        wish = desired
        if braking.any():
            closest = np.argmin(length, axis=1)[:, None, None]
            away = unit(np.take_along_axis(offset, closest, axis=1)[:, 0])
            wish = np.where(braking[:, None], self.max_braking_velocity * away, desired)
        limit = np.where(braking, self.max_braking_velocity, self.max_velocity)
        safe, found = nearest(wish, planes.normals, planes.sides, limit)
        return np.where(found[:, None], safe, 0.0), braking
