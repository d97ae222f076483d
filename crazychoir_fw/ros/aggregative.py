"""Target surveillance as ROS 2 nodes, with the class names and arguments of the original.

docs/reference/crazychoir.md#8.3.

Take-off and landing go to the trajectory handler; references of the flight go straight to the topic ``position``, as in
the original, or to the handler as well. Rounds never wait in a callback; see `crazychoir_fw.ros.guidance_node`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import Vector3

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance import BestEffortCommunicator, TimeVaryingCommunicator, schemes
from crazychoir_fw.guidance.schemes.aggregative import OPTIMIZERS
from crazychoir_fw.ros.guidance_node import GuidanceNode


class AggregativeGuidance(GuidanceNode):
    """Defends a target against an intruder, together with its neighbors."""

    plain_class: Any = schemes.AggregativeGuidance

    def __init__(
        self,
        optimizer: str | type = OPTIMIZERS[0],
        height: float = 1.0,
        freq_reference: float = 10.0,
        pose_handler: str | None = "pubsub",
        pose_topic: str | None = "odom",
        pose_callback: Callable[[], None] | None = None,
        msg_topic: str = "position",
        msg_type: type = Vector3,
        seed: int = 5,
        *,
        takeoff_time: float = 3.0,
        stepsize: float = 1e-3,
        iterations_per_second: float = 100.0,
        references: str = "position",
        update_frequency: float = 100.0,
        node_name: str = "aggregative_guidance",
        **options: Any,
    ) -> None:
        """Make the node.

        Parameters: ``N``, ``in_neigh``, ``out_neigh``, ``init_pos``, ``weights``, ``target``, ``intruder``,
        ``asynchronous``.

        Args:
            optimizer: One of `crazychoir_fw.guidance.schemes.aggregative.OPTIMIZERS`, or a class.
            height: At which it flies (m).
            freq_reference: References per second (Hz).
            pose_handler: Where poses come from.
            pose_topic: Topic of the pose.
            pose_callback: Called after each pose.
            msg_topic: Where references go.
            msg_type: Their type: `geometry_msgs/Vector3`.
            seed: Without effect: nothing here is random.
            takeoff_time: Of take-off and landing (s).
            stepsize: The step alpha.
            iterations_per_second: Pace of the iterations (1/s).
            references: ``position``, or ``trajectory`` for short go-tos on ``traj_params``.
            update_frequency: Rounds per second (Hz).
            node_name: Name of the node.
            options: Of `GuidanceNode`.

        Raises:
            RangeError: If the type is another one, or a number outside its range.
        """
        del seed
        if msg_type is not Vector3:
            raise RangeError(f"{node_name}: msg_type is {msg_type.__name__}, allowed: Vector3")

        def build(node: GuidanceNode) -> Any:
            is_asynchronous = node.declare("asynchronous", False, "whether rounds take what has come")
            communicator = node.declare_communicator(
                BestEffortCommunicator if is_asynchronous else TimeVaryingCommunicator
            )
            return self.plain_class(
                node.agent_id,
                communicator,
                optimizer=optimizer,
                stepsize=stepsize,
                iterations_per_second=iterations_per_second,
                freq_reference=freq_reference,
                references=references,
                target=node.declare("target", None, "what is guarded (m, world)", list[float]),
                weights=node.declare("weights", None, "row of the weights of all agents", list[float]),
                init_pos=node.declare_start(),
                height=height,
                takeoff_time=takeoff_time,
                update_frequency=update_frequency,
                **self._intruder(node, communicator.size),
            )

        super().__init__(
            build,
            node_name=node_name,
            update_frequency=update_frequency,
            pose_handler=pose_handler,
            pose_topic=pose_topic,
            pose_callback=pose_callback,
            input_topic=msg_topic,
            **options,
        )

    def _intruder(self, node: GuidanceNode, size: int) -> dict[str, Any]:
        """Return what the plain guidance is told of the intruder."""
        del size
        return {"intruder": node.declare("intruder", None, "where the intruder is (m, world)", list[float])}


class AggregativeGuidanceCrazyflie(AggregativeGuidance):
    """The intruder stands still, at the parameter ``intruder``."""

    plain_class = schemes.AggregativeGuidanceCrazyflie


class AggregativeGuidanceCrazyflieMovingIntruder(AggregativeGuidance):
    """The intruder is another drone: the parameter ``intruder_id``, by default ``agent_id`` + ``N``, heard on odom."""

    plain_class = schemes.AggregativeGuidanceCrazyflieMovingIntruder

    def _intruder(self, node: GuidanceNode, size: int) -> dict[str, Any]:
        number = node.agent_id + size
        return {"intruder_id": node.declare("intruder_id", number, "number of the drone that is the intruder", low=0)}
