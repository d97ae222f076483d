"""Equal controllers of several drones as one object, which computes all of them at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.experiment.agent import Agent
from crazychoir_fw.experiment.backend import some_of
from crazychoir_fw.messages import Pose, Reference, Twist

Array = NDArray[np.float64]

_VECTORS = ("position", "velocity", "acceleration", "jerk")
_SCALARS = ("yaw", "yaw_rate")


class ControlGroup:
    """A controller of N drones, and which they are.

    Drones whose motors do not turn are computed as well, as if they were to stay where they are: their integrals stay
    empty, and what comes out is sent to nobody.
    """

    def __init__(self, controller: Any, indices: Sequence[int], kind: str, follows: str) -> None:
        """Take a controller.

        Args:
            controller: See `crazychoir_fw.control.CrazyflieController`.
            indices: Numbers of the drones.
            kind: What it commands, ``fpqr``, ``frpy`` or ``vel``.
            follows: What references consist of, ``acceleration``, ``position`` or ``fullstate``.
        """
        self.controller = controller
        self.indices = np.array(indices)
        self.kind = kind
        self.follows = follows

    def step(self, agents: Sequence[Agent], poses: Pose, now: float) -> tuple[Array, Twist] | None:
        """Return whom to send which commands, arrays of shape (n, 3), or None.

        Args:
            agents: All agents.
            poses: Poses of all drones, without NaN.
            now: Time (s).
        """
        own = some_of(poses, self.indices)
        self.controller.set_pose(own)
        members = [agents[i] for i in self.indices]
        self.controller.set_reference(self._reference(members, own))
        twist = self.controller.step(now)
        up = [k for k, agent in enumerate(members) if agent.is_up]
        if twist is None or not up:
            return None
        if len(up) == len(members):
            return self.indices, twist
        return self.indices[up], Twist(twist.linear[up], twist.angular[up])

    def _reference(self, members: Sequence[Agent], own: Pose) -> Reference:
        """Return the references of all, arrays of shape (N, 3); where one has none it stays where it is."""
        references = [agent.reference if agent.is_up else None for agent in members]
        if self.follows == "acceleration":
            wanted = np.zeros((len(members), 3))
            for k, reference in enumerate(references):
                if reference is not None and reference.acceleration is not None:
                    wanted[k] = reference.acceleration
            return Reference(acceleration=wanted)
        parts: dict[str, Array] = {"position": own.position.copy()}
        for k, reference in enumerate(references):
            if reference is None:
                continue
            for name in _VECTORS:
                value = getattr(reference, name)
                if value is not None:
                    if name not in parts:
                        parts[name] = np.zeros((len(members), 3))
                    parts[name][k] = value
            for name in _SCALARS:
                value = getattr(reference, name)
                if value is not None:
                    if name not in parts:
                        parts[name] = np.zeros(len(members))
                    parts[name][k] = value
        return Reference(**parts)  # type: ignore[arg-type]
