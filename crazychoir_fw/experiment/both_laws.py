"""The flatness laws of positions and of accelerations as one, for swarms where some follow this and others that."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.control import FlatnessAccelerationCtrl, FlatnessPositionCtrl
from crazychoir_fw.messages import Pose, Reference

Array = NDArray[np.float64]


class BothFlatnessLaws(FlatnessPositionCtrl):
    """Tracks positions, but for the drones whose reference is an acceleration; what costs time is done once for all."""

    def __init__(self, is_accelerated: NDArray[np.bool_], **arguments: Any) -> None:
        """Choose who is who.

        Args:
            is_accelerated: Who follows accelerations, shape (N,).
            arguments: Those of both laws.
        """
        super().__init__(**arguments)
        self._accelerations = FlatnessAccelerationCtrl(**arguments)
        self._is_accelerated = is_accelerated[:, None]

    def force(self, current_pose: Pose, desired_reference: Reference) -> Array:
        """See `FlatnessCtrl`."""
        tracking = super().force(current_pose, desired_reference)
        return np.where(self._is_accelerated, self._accelerations.force(current_pose, desired_reference), tracking)
