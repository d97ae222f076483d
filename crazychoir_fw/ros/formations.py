"""Formations by distances, containment and model predictive control as ROS 2 nodes, with ChoiRbot's class names.

What goes out on ``fullstate`` is a reference with position and velocity, which the controllers of this package follow;
what ChoiRbot's nodes publish, the velocity alone (`geometry_msgs/Vector3`), goes out beside it on ``velocity``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from geometry_msgs.msg import Vector3
from numpy.typing import NDArray

from crazychoir_fw import guidance as plain
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.guidance import Outputs
from crazychoir_fw.guidance.schemes import mpc
from crazychoir_fw.ros.guidance_node import GuidanceNode
from crazychoir_fw.ros.names import qos


class DistributedControlGuidance(GuidanceNode):
    """Velocities from the poses of neighbors: override `evaluate_input`."""

    def __init__(
        self,
        update_frequency: float = 100.0,
        pose_handler: str | None = "pubsub",
        pose_topic: str | None = "odom",
        pose_callback: Callable[[], None] | None = None,
        input_topic: str = "velocity",
        *,
        law: Mapping[str, Any] | None = None,
        **options: Any,
    ) -> None:
        """Make the node; parameters ``N``, ``in_neigh``, ``out_neigh``, ``init_pos``, ``weights``, ``is_leader``.

        Args:
            update_frequency: Rounds per second (Hz).
            pose_handler: Where poses come from.
            pose_topic: Topic of the pose.
            pose_callback: Called after each pose.
            input_topic: Where velocities go.
            law: Further arguments of the plain class, such as ``{"k": 0.3, "max_speed": 1.0}``.
            options: Of `GuidanceNode`.
        """
        self._law = dict(law or {})
        super().__init__(
            self._build,
            update_frequency=update_frequency,
            pose_handler=pose_handler,
            pose_topic=pose_topic,
            pose_callback=pose_callback,
            **options,
        )
        self._velocity = self.create_publisher(Vector3, input_topic, qos(1))

    def _build(self, node: GuidanceNode) -> Any:
        self.weights = self.declare("weights", None, "weights of the neighbors, or distances (m)", list[float])
        leads = self.declare("is_leader", False, "whether it follows its own trajectory")
        communicator = self.declare_communicator()
        return self._plain(communicator)(
            self.agent_id,
            communicator,
            init_pos=self.declare_start(),
            update_frequency=node.update_frequency,
            is_leader=leads,
            **self._law,
        )

    def _plain(self, communicator: Any) -> Callable[..., Any]:
        """Return what makes the plain guidance."""
        node = self

        class Feedback(plain.VelocityFeedback):
            def evaluate_input(self, neigh_data: dict[int, Pose]) -> NDArray[np.float64]:
                return node.evaluate_input(neigh_data)

        return Feedback

    def evaluate_input(self, neigh_data: dict[int, Pose]) -> NDArray[np.float64]:
        """Return the velocity (m/s, world), shape (3,), given the poses of neighbors."""
        return self.guidance.evaluate_input(neigh_data)

    def _send(self, outputs: Outputs) -> None:
        super()._send(outputs)
        reference = outputs.reference
        if reference is not None and reference.velocity is not None:
            x, y, z = (float(value) for value in reference.velocity)
            self._velocity.publish(Vector3(x=x, y=y, z=z))


class FormationControlGuidance(DistributedControlGuidance):
    """Formation by distances; parameter ``weights``: the distances to all agents (m), zero for itself and strangers."""

    def _plain(self, communicator: Any) -> Callable[..., Any]:
        if self.weights is not None:
            self._law.setdefault("weights", self.weights)
        return plain.FormationControl


class ContainmentGuidance(DistributedControlGuidance):
    """Followers gather among leaders."""

    def _plain(self, communicator: Any) -> Callable[..., Any]:
        return plain.Containment


class TimeVaryingContainmentGuidance(DistributedControlGuidance):
    """Containment over random edges; both ends of an edge draw with the same seed, parameter ``seed``."""

    def _plain(self, communicator: Any) -> Callable[..., Any]:
        self._law.setdefault("seed", self.declare("seed", 0, "of the draws, the same for all agents", low=0))
        # of the graph only the own edges matter, and the draws of all pairs, which the complete graph has
        self._law.setdefault("graph", plain.Graph.complete(communicator.size))

        def make(*arguments: Any, **options: Any) -> plain.TimeVaryingContainment:
            made = plain.TimeVaryingContainment(*arguments, **options)
            made.schedule = _OwnEdges(made.schedule, communicator)
            return made

        return make


class _OwnEdges:
    """Of the neighbors that a schedule has, those that a communicator knows."""

    def __init__(self, schedule: Any, communicator: Any) -> None:
        self._schedule, self._communicator = schedule, communicator

    def neighbors_at(self, agent: int, now: float, label: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
        heard, hearers = self._schedule.neighbors_at(agent, now, label)
        known = self._communicator
        return (
            tuple(one for one in heard if one in known.in_neighbors),
            tuple(one for one in hearers if one in known.out_neighbors),
        )


class MPCGuidance(DistributedControlGuidance):
    """Distributed model predictive control; see `crazychoir_fw.guidance.schemes.MPCGuidance` for what `law` takes."""

    def __init__(self, sampling_period: float = 1.0, *args: Any, law: Mapping[str, Any] | None = None, **options: Any):
        """Make the node.

        Args:
            sampling_period: Length of a period (s).
            args: Of `DistributedControlGuidance`.
            law: Further arguments of the plain class.
            options: Of `DistributedControlGuidance`.
        """
        super().__init__(*args, law={"sampling_period": sampling_period, **(law or {})}, **options)

    def _plain(self, communicator: Any) -> Callable[..., Any]:
        return mpc.MPCGuidance


class SimpleDIControl(GuidanceNode):
    """Flies to a goal as a double integrator; parameters ``init_pos`` and ``goal``."""

    _plain: Any = staticmethod(plain.SimpleDIControl)

    def __init__(
        self, update_frequency: float = 100.0, *, law: Mapping[str, Any] | None = None, **options: Any
    ) -> None:
        """Make the node.

        Args:
            update_frequency: Steps per second (Hz).
            law: Further arguments of the plain class.
            options: Of `GuidanceNode`.
        """

        def build(node: GuidanceNode) -> Any:
            goal = node.declare("goal", None, "where to fly (m, world)", list[float], length=3)
            return plain.SimpleDIControl(
                agent_id=node.agent_id,
                init_pos=node.declare_start(),
                update_frequency=update_frequency,
                goal=goal,
                **(law or {}),
            )

        super().__init__(build, update_frequency=update_frequency, **options)


class TargetListGuidance(GuidanceNode):
    """Flies to targets one after the other (ChoiRbot's `SimpleGuidance`); parameters ``init_pos`` and ``goals``."""

    def __init__(self, update_frequency: float = 20.0, *, law: Mapping[str, Any] | None = None, **options: Any) -> None:
        """Make the node; ``goals`` are x, y, z, x, y, z, … (m).

        Args:
            update_frequency: Steps per second (Hz).
            law: Further arguments of the plain class.
            options: Of `GuidanceNode`.
        """

        def build(node: GuidanceNode) -> Any:
            flat = node.declare("goals", [], "targets: x, y, z of each (m, world)", list[float]) or []
            return plain.TargetListGuidance(
                agent_id=node.agent_id,
                init_pos=node.declare_start(),
                update_frequency=update_frequency,
                goals=np.reshape(flat, (-1, 3)) if len(flat) % 3 == 0 else flat,
                **(law or {}),
            )

        super().__init__(build, update_frequency=update_frequency, **options)
