"""Controllers that keep drones apart: groups that receive nearby drones, and filters behind velocity controllers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Pose, Reference, Twist
from crazychoir_fw.control import SafeFlatnessPositionCtrl
from crazychoir_fw.control.periodic_timer import PeriodicTimer
from crazychoir_fw.control.safety import SingleIntegratorCollisionAvoidance
from crazychoir_fw.flight.agent import Agent
from crazychoir_fw.flight.control_group import ControlGroup
from crazychoir_fw.flight.mixed_reference_ctrl import MixedReferenceCtrl
from crazychoir_fw.flight.sensing import Sensing

Array = NDArray[np.float64]


class SafeControlGroup(ControlGroup):
    """A group whose controller receives the poses of nearby drones each round."""

    def __init__(self, sensing: Sensing, *arguments: Any) -> None:
        """Take what all groups see by, and the arguments of `ControlGroup`."""
        super().__init__(*arguments)
        self._sensing = sensing

    def step(
        self, agents: Sequence[Agent], accelerations: Array, turning: NDArray[np.bool_], poses: Pose, now: float
    ) -> tuple[Array, Twist] | None:
        """See `ControlGroup`."""
        self._sensing.look(now, poses, turning)
        self.controller.set_closest(self._sensing.near(self.indices))
        return super().step(agents, accelerations, turning, poses, now)


class FilteredController:
    """A velocity controller and the filter behind it, each at its rate, as one controller."""

    def __init__(self, controller: Any, avoidance: SingleIntegratorCollisionAvoidance, rate: float) -> None:
        """Join them.

        Args:
            controller: See `crazychoir_fw.control.VelocityController`.
            avoidance: The filter.
            rate: How often it filters the latest desired velocity (Hz).
        """
        self.controller = controller
        self.avoidance = avoidance
        self._schedule = PeriodicTimer(rate)

    @property
    def periods(self) -> tuple[float, ...]:
        """Of both (s)."""
        return (*self.controller.periods, self._schedule.period)

    def set_pose(self, pose: Pose) -> None:
        """See `CrazyflieController`."""
        self.controller.set_pose(pose)
        self.avoidance.set_pose(pose)

    def set_reference(self, reference: Reference) -> None:
        """See `CrazyflieController`."""
        self.controller.set_reference(reference)

    def clear_reference(self) -> None:
        """See `CrazyflieController`."""
        self.controller.clear_reference()

    def set_closest(self, closest: Pose) -> None:
        """See `SafeHierarchicalController`."""
        self.avoidance.set_closest(closest)

    def step(self, now: float) -> Twist | None:
        """See `CrazyflieController`."""
        desired = self.controller.step(now)
        if desired is not None:
            self.avoidance.set_desired(desired)
        return self.avoidance.step() if self._schedule.is_due(now) else None


class SafeBothFlatnessLaws(SafeFlatnessPositionCtrl, MixedReferenceCtrl):
    """`MixedReferenceCtrl` behind a filter of accelerations."""

    def __init__(self, is_accelerated: NDArray[np.bool_], safety_filter: Any, **arguments: Any) -> None:
        """See `MixedReferenceCtrl` and `SafeFlatnessPositionCtrl`."""
        MixedReferenceCtrl.__init__(self, is_accelerated, **arguments)
        self.make_safe(safety_filter, None)
