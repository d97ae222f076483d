"""Guidance as ROS 2 nodes, with the class names and arguments of the paper's listings.

What a round is and who is silent: see `crazychoir_fw.ros.guidance_node`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw import guidance as plain
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.ros.guidance_node import GuidanceNode

__all__ = [
    "BearingFormation",
    "CFDistributedFeedback",
    "CFGuidance",
    "GoToGuidance",
    "GuidanceNode",
    "SimpleGuidance",
]


class CFGuidance(GuidanceNode):
    """Take-off and landing, and nothing in between."""

    _plain: Any = staticmethod(plain.CFGuidance)

    def __init__(
        self,
        pose_handler: str | None = "pubsub",
        pose_topic: str | None = "odom",
        pose_callback: Callable[[], None] | None = None,
        takeoff_time: float = 5.0,
        height: float = 1.0,
        **options: Any,
    ) -> None:
        """Make the node; parameter ``init_pos``.

        Args:
            pose_handler: Where poses come from.
            pose_topic: Topic of the pose.
            pose_callback: Called after each pose.
            takeoff_time: How long take-off and landing last (s).
            height: Height of the take-off (m).
            options: Of `GuidanceNode`, such as ``update_frequency``.
        """
        self._phases = {"takeoff_time": takeoff_time, "height": height}
        super().__init__(
            self._build, pose_handler=pose_handler, pose_topic=pose_topic, pose_callback=pose_callback, **options
        )

    def _build(self, node: GuidanceNode) -> Any:
        return self._plain(
            agent_id=node.agent_id,
            init_pos=node.declare_start(),
            update_frequency=node.update_frequency,
            **self._phases,
        )


class SimpleGuidance(CFGuidance):
    """Take-off and landing as go-tos on ``traj_params``."""

    _plain: Any = staticmethod(plain.SimpleGuidance)

    def __init__(self, *args: Any, node_name: str = "simple_guidance", **options: Any) -> None:
        """Make the node; arguments as of `CFGuidance`."""
        super().__init__(*args, node_name=node_name, **options)


class GoToGuidance(GuidanceNode):
    """A list of go-tos, one after the other, from the button start on."""

    def __init__(
        self,
        pose_handler: str | None = "pubsub",
        pose_topic: str | None = "odom",
        pose_callback: Callable[[], None] | None = None,
        takeoff_time: float = 5.0,
        **options: Any,
    ) -> None:
        """Make the node; parameters ``N``, ``init_pos``, ``goals``: t, x, y, z, t, x, y, z, … (s, m).

        Args are those of `CFGuidance`, without the height.
        """
        self._takeoff_time = takeoff_time
        super().__init__(
            self._build,
            node_name="goto_guidance",
            pose_handler=pose_handler,
            pose_topic=pose_topic,
            pose_callback=pose_callback,
            **options,
        )

    def _build(self, node: GuidanceNode) -> Any:
        node.declare("N", 1, "number of agents", low=1)
        flat = node.declare("goals", [], "goals: t, x, y, z of each (s; m, world)", list[float]) or []
        if len(flat) % 4:
            raise RangeError(f"{node.get_fully_qualified_name()}: goals has {len(flat)} numbers, allowed: 4 per goal")
        return plain.GoToGuidance(
            agent_id=node.agent_id,
            init_pos=node.declare_start(),
            takeoff_time=self._takeoff_time,
            goals=[tuple(flat[k : k + 4]) for k in range(0, len(flat), 4)],
            update_frequency=node.update_frequency,
        )


class CFDistributedFeedback(GuidanceNode):
    """Feedback from the poses of neighbors: override `evaluate_input`."""

    def __init__(
        self,
        update_frequency: float = 100.0,
        pose_handler: str | None = "pubsub",
        pose_topic: str | None = "odom",
        pose_callback: Callable[[], None] | None = None,
        input_topic: str = "acceleration",
        **options: Any,
    ) -> None:
        """Make the node; parameters ``N``, ``in_neigh``, ``out_neigh``, ``init_pos``, ``weights``.

        Args:
            update_frequency: Rounds per second (Hz).
            pose_handler: Where poses come from.
            pose_topic: Topic of the pose.
            pose_callback: Called after each pose.
            input_topic: Where the acceleration goes.
            options: Of `GuidanceNode`.
        """
        super().__init__(
            self._build,
            update_frequency=update_frequency,
            pose_handler=pose_handler,
            pose_topic=pose_topic,
            pose_callback=pose_callback,
            input_topic=input_topic,
            **options,
        )

    def _build(self, node: GuidanceNode) -> Any:
        self.weights = self.declare("weights", None, "weights of the neighbors", list[float])
        law = _feedback_of(self)
        return law(
            self.agent_id,
            self.declare_communicator(),
            init_pos=self.declare_start(),
            update_frequency=node.update_frequency,
        )

    def evaluate_input(self, neigh_data: dict[int, Pose]) -> NDArray[np.float64]:
        """Return the acceleration (m/s^2, world), shape (3,), given the poses of neighbors."""
        raise NotImplementedError


def _feedback_of(node: CFDistributedFeedback) -> type:
    class Feedback(plain.CFDistributedFeedback):
        def evaluate_input(self, neigh_data: dict[int, Pose]) -> NDArray[np.float64]:
            return node.evaluate_input(neigh_data)

    return Feedback


class BearingFormation(CFDistributedFeedback):
    """The paper's bearing-based formation."""

    def __init__(
        self, *args: Any, gains: Any = None, height: float = 1.0, takeoff_time: float = 5.0, **options: Any
    ) -> None:
        """Make the node; parameters of `CFDistributedFeedback`, and ``is_leader``, ``dd``, ``ort_proj``, ``vicon``.

        Args:
            args: As of `CFDistributedFeedback`, in its order.
            gains: Set of gains, by name or as a dataclass; None: ``vicon`` if that parameter is set, else ``webots``.
            height: Height of the take-off (m).
            takeoff_time: How long the take-off lasts (s).
            options: Of `CFDistributedFeedback` and `GuidanceNode`.
        """
        self._gains, self._height, self._takeoff_time = gains, height, takeoff_time
        super().__init__(*args, **options)

    def _build(self, node: GuidanceNode) -> Any:
        communicator = self.declare_communicator()
        size = communicator.size
        leads = self.declare("is_leader", False, "whether it follows its own trajectory and not the formation")
        flat = self.declare("ort_proj", None, "rows of projections, 3 x 3 N, by rows", list[float], length=9 * size)
        self.declare("dd", None, "spatial dimension, for compatibility: always 3", int)
        vicon = self.declare("vicon", False, "whether the gains are those for motion capture")
        return plain.BearingFormation(
            self.agent_id,
            communicator,
            init_pos=self.declare_start(),
            update_frequency=node.update_frequency,
            is_leader=leads,
            ort_proj=None if flat is None else np.reshape(flat, (3, 3 * size)),
            gains=self._gains or ("vicon" if vicon else "webots"),
            height=self._height,
            takeoff_time=self._takeoff_time,
        )

    def evaluate_input(self, neigh_data: dict[int, Pose]) -> NDArray[np.float64]:
        """Return the acceleration (m/s^2, world), shape (3,), given the poses of neighbors."""
        return self.guidance.evaluate_input(neigh_data)
