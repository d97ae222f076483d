"""Equal controllers of several drones as one object, which computes all of them at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Pose, Reference, Twist
from crazychoir_fw.flight.agent import Agent
from crazychoir_fw.flight.backend import some_of
from crazychoir_fw.flight.swarm_references import SwarmReferences

Array = NDArray[np.float64]


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
        self._rows = np.flatnonzero(~is_accelerated)
        self._references = SwarmReferences(len(self._members))
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
        self._references.update(
            [
                agents[i].reference if is_up else None
                for i, is_up in zip(self._members, up[self._rows].tolist(), strict=True)
            ]
        )
        if len(self._rows) == len(self.indices):
            return Reference(**self._references.arrays(own.position))
        # those who follow accelerations stay where they are, at rest
        parts = {"position": own.position.copy(), "velocity": np.zeros(own.position.shape)}
        parts["acceleration"] = accelerations * (self._is_accelerated & up[:, None])
        for name, values in self._references.arrays(own.position[self._rows]).items():
            if name not in parts:
                parts[name] = np.zeros((len(up), *values.shape[1:]))
            parts[name][self._rows] = values
        return Reference(**parts)
