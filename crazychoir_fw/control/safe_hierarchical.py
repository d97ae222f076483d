"""`SafeHierarchicalController`: its position law knows who is near (docs/reference/crazychoir.md#4.1, #9)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.control.hierarchical import HierarchicalController
from crazychoir_fw.control.strategies import PositionCtrlStrategy

Array = NDArray[np.float64]


class SafeHierarchicalController(HierarchicalController):
    """A `HierarchicalController` whose position law is given those nearby as a third argument.

    Laws: `SafeFlatnessPositionCtrl`, `SafeFlatnessAccelerationCtrl`, or your own with
    ``control(current_pose, desired_reference, closest)``.
    """

    closest: Pose | Mapping[int, Pose] | None = None
    """Who is near: arrays of shape (..., K, 3), nan where nobody is, or poses by number for a single drone."""

    position_strategy: PositionCtrlStrategy

    def set_closest(self, closest: Pose | Mapping[int, Pose]) -> None:
        """Take those nearby, as `crazychoir_fw.control.safety.ClosestRobotGetter` finds them."""
        self.closest = closest

    def _position_law(self, pose: Pose, reference: Reference) -> tuple[Array, Array]:
        return self.position_strategy.control(pose, reference, self.closest)  # type: ignore[call-arg]
