"""What a controller keeps of the references that it receives (docs/reference/crazychoir.md#6)."""

from __future__ import annotations

import numpy as np

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.finite import are_finite
from crazychoir_fw.common.messages import Reference

KINDS = ("position", "acceleration", "fullstate")


class TrajHandlerStrategy:
    """Holds the last reference of one topic.

    Attributes:
        kind: "position", "acceleration" (both Vector3 on the wire) or "fullstate" (MultiDOFJointTrajectoryPoint).
        topic: Topic on which it comes.
    """

    def __init__(self, kind: str, topic: str) -> None:
        if kind not in KINDS:
            raise RangeError(f"{type(self).__name__}: kind is {kind!r}, allowed: {', '.join(KINDS)}")
        self.kind = kind
        self.topic = topic
        self._reference: Reference | None = None

    def update(self, reference: Reference) -> None:
        """Take a new reference; the parts that this kind does not carry are dropped.

        Raises:
            RangeError: If it lacks what this kind stands for, or holds numbers that are not finite. The last good one
                stays.
        """
        wanted = reference.acceleration if self.kind == "acceleration" else reference.position
        name = "acceleration" if self.kind == "acceleration" else "position"
        if wanted is None or np.shape(wanted)[-1:] != (3,):
            raise RangeError(f"{self.topic}: {name} has shape {np.shape(wanted)}, allowed: (..., 3)")
        parts = (reference.position, reference.velocity, reference.acceleration, reference.jerk)
        parts += (reference.yaw, reference.yaw_rate)
        if not are_finite(*(np.asarray(part, float) for part in parts if part is not None)):
            raise RangeError(f"{self.topic}: the reference holds numbers that are not finite")
        if self.kind == "fullstate":
            self._reference = Reference(*parts)  # another object, whatever the sender does with its own
        else:
            self._reference = Reference(**{name: wanted})

    def get_desired_reference(self) -> Reference | None:
        """Return the last reference, or None before the first."""
        return self._reference


class PositionTraj(TrajHandlerStrategy):
    """References are positions."""

    def __init__(self, topic: str = "position") -> None:
        super().__init__("position", topic)


class AccelerationTraj(TrajHandlerStrategy):
    """References are accelerations."""

    def __init__(self, topic: str = "acceleration") -> None:
        super().__init__("acceleration", topic)


class FullStateTraj(TrajHandlerStrategy):
    """References are position, velocity, acceleration and yaw, and jerk and yaw rate where they are known."""

    def __init__(self, topic: str = "fullstate") -> None:
        super().__init__("fullstate", topic)
