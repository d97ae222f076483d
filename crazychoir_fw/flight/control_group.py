"""Equal controllers of several drones as one object, which computes all of them at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Pose, Reference, Twist
from crazychoir_fw.flight.agent import Agent
from crazychoir_fw.flight.backend import some_of

Array = NDArray[np.float64]

_SHAPES = {**dict.fromkeys(("position", "velocity", "acceleration", "jerk"), (3,)), "yaw": (), "yaw_rate": ()}
"""What a reference consists of, for one drone."""


class ControlGroup:
    """A controller of N drones, and which they are.

    Drones whose motors do not turn are computed as well, as if they were to stay where they are: their integrals stay
    empty, and their output is discarded.
    """

    def __init__(
        self, controller: Any, indices: Sequence[int], kind: str, follows: str, accelerated: Sequence[int] = ()
    ) -> None:
        """Take a controller.

        Args:
            controller: See `crazychoir_fw.control.CrazyflieController`.
            indices: Numbers of the drones.
            kind: What it commands, ``fpqr``, ``frpy`` or ``vel``.
            follows: What references consist of, ``acceleration``, ``position`` or ``fullstate``.
            accelerated: Drones that follow accelerations instead of full states, see `MixedReferenceCtrl`; the
                reference positions of these are their measured ones.
        """
        self.controller = controller
        self.of_one: Callable[[int], ControlGroup] | None = None
        """Makes the same for one drone alone, by its number."""
        self.indices = np.array(indices)
        self.kind = kind
        self.follows = follows
        is_accelerated = np.isin(self.indices, accelerated)
        self._members = [int(i) for i in self.indices[~is_accelerated]]
        self._rows = [int(k) for k in np.flatnonzero(~is_accelerated)]
        self._is_accelerated = is_accelerated[:, None]
        self._is_everybody = np.array_equal(self.indices, np.arange(len(self.indices)))

    def step(
        self, agents: Sequence[Agent], accelerations: Array, turning: NDArray[np.bool_], poses: Pose, now: float
    ) -> tuple[Array, Twist] | None:
        """Return the numbers of drones and their commands, arrays of shape (n, 3), or None.

        Args:
            agents: All agents.
            accelerations: What guidance asks for (m/s^2), shape (N, 3).
            turning: Whose motors turn, shape (N,).
            poses: Poses of all drones, without NaN.
            now: Time (s).
        """
        controller = self.controller
        if self._is_everybody and len(turning) == len(self.indices):
            own, up, asked = poses, turning, accelerations  # nothing has to be picked out
        else:
            own, up, asked = some_of(poses, self.indices), turning[self.indices], accelerations[self.indices]
        controller.set_pose(own)
        if self.follows == "acceleration":
            # drones whose motors are off get the reference of a hover; their output is discarded
            controller.set_reference(Reference(acceleration=asked * up[:, None]))
        else:
            controller.set_reference(self._reference(agents, asked, up, own))
        twist = controller.step(now)
        if twist is None:
            return None
        if up.all():
            return self.indices, twist
        if not up.any():
            return None
        return self.indices[up], Twist(twist.linear[up], twist.angular[up])

    def _reference(self, agents: Sequence[Agent], accelerations: Array, up: NDArray[np.bool_], own: Pose) -> Reference:
        """Return the references of all, arrays of shape (N, 3); where one has none it stays where it is."""
        parts: dict[str, Array] = {"position": own.position.copy()}
        if len(self._rows) < len(self.indices):
            parts["velocity"] = np.zeros(own.position.shape)
            parts["acceleration"] = accelerations * (self._is_accelerated & up[:, None])
        for k, i in zip(self._rows, self._members, strict=True):
            reference = agents[i].reference
            if reference is None or not up[k]:
                continue
            for name, shape in _SHAPES.items():
                value = getattr(reference, name)
                if value is not None:
                    if name not in parts:
                        parts[name] = np.zeros((len(up), *shape))
                    parts[name][k] = value
        return Reference(**parts)  # type: ignore[arg-type]
