"""The flatness laws of positions and of accelerations as one, for swarms where some follow this and others that."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.control import FlatnessAccelerationCtrl, FlatnessPositionCtrl, HierarchicalController

if TYPE_CHECKING:
    from crazychoir_fw.mission.layers import ControlLayer

Array = NDArray[np.float64]


class MixedReferenceCtrl(FlatnessPositionCtrl):
    """Tracks positions, but for the drones whose reference is an acceleration; what costs time is done once for all."""

    @staticmethod
    def replaces(layer: ControlLayer) -> bool:
        """Return whether the laws of a control layer are those that it puts together."""
        return (layer.kind, layer.position, layer.acceleration) == (
            HierarchicalController.__name__,
            FlatnessPositionCtrl.__name__,
            FlatnessAccelerationCtrl.__name__,
        )

    def __init__(self, is_accelerated: NDArray[np.bool_], **arguments: Any) -> None:
        """Choose which drones follow accelerations.

        Args:
            is_accelerated: Whether each drone follows accelerations, shape (N,).
            arguments: Those of both laws.
        """
        super().__init__(**arguments)
        # nothing but its reference's acceleration moves a drone without gains: that is `FlatnessAccelerationCtrl`
        tracks = ~is_accelerated[:, None]
        self._k_p, self._k_v, self._k_i, self._drag = (
            tracks * gains for gains in (self._k_p, self._k_v, self._k_i, self._drag)
        )
