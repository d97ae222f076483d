"""Motion capture as ROS 2 nodes: a simulated system, and odometry out of its poses."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from rclpy.context import Context

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.mocap import Estimator, MocapConfig, SimulatedMocap
from crazychoir_fw.ros.conversions import pose_to_odometry, pose_to_pose_stamped
from crazychoir_fw.ros.names import MOCAP_POSE, NAMESPACE_PATTERN, ODOM
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.pose_sources import pose_subscribe
from crazychoir_fw.ros.pose_watch import PoseWatch

_UNITS = {
    "rate": "frames per second (Hz)",
    "latency": "time from a frame to its arrival (s)",
    "position_noise": "standard deviation per axis (m)",
    "attitude_noise": "standard deviation per axis (rad)",
    "dropout": "probability that a drone is missing in a frame",
    "outlier": "probability that a wrong marker is taken",
    "outlier_size": "outliers are off by a quarter of it to all of it (m)",
}


class MocapSimulator(LayerNode):
    """Node ``mocap`` of the whole swarm: odometry of all drones in, poses as motion capture would publish them out.

    Time is that of the stamps of the odometry, so that simulations may run at any speed. Dropouts are not published.
    """

    def __init__(
        self,
        agents: Sequence[int] | None = None,
        config: MocapConfig | None = None,
        *,
        pose_topic: str = "odom",
        topic: str = MOCAP_POSE.name,
        namespace_pattern: str = NAMESPACE_PATTERN,
        parameters: Mapping[str, Any] | None = None,
        context: Context | None = None,
    ) -> None:
        """Make the node.

        Args:
            agents: Numbers of the drones; None is 0 to the parameter ``N``.
            config: Defaults of the parameters; None takes those of the vehicle model.
            pose_topic: Topic of the odometry, in the namespace of each drone.
            topic: Where poses go, with {d} for the number of a drone.
            namespace_pattern: Namespace of drone i.
            parameters: Values of parameters: ``N``, ``seed``, and those of `MocapConfig`.
            context: Context of rclpy.
        """
        super().__init__(
            "mocap", swarm_wide=True, namespace_pattern=namespace_pattern, parameters=parameters, context=context
        )
        count = self.declare("N", 1, "number of drones", low=1)
        seed = self.declare("seed", 0, "seed of the noise", low=0)
        config = MocapConfig.default() if config is None else config
        values = {f.name: self.declare(f.name, float(getattr(config, f.name)), _UNITS[f.name]) for f in fields(config)}
        self.systems = {i: SimulatedMocap(MocapConfig(**values), seed=seed, first=i) for i in agents or range(count)}
        """Simulated motion capture of each drone, by its number."""
        for i, system in self.systems.items():
            publisher = self.announce(MOCAP_POSE, topic.format(d=i))
            pose_subscribe("pubsub", self.topic_of(i, pose_topic), self, self._taker(system, publisher))
        self.when_time_jumps_back(lambda now: [system.reset() for system in self.systems.values()])

    def _taker(self, system: SimulatedMocap, publisher: Any) -> Callable[[Pose], None]:
        def take(truth: Pose) -> None:
            for pose in system.step(truth.time, truth):  # type: ignore[arg-type]
                if np.isfinite(pose.position).all():
                    publisher.publish(pose_to_pose_stamped(pose))

        return take


class MocapOdometry(LayerNode):
    """Node ``mocap_odometry`` of one drone: poses of motion capture in, ``odom`` with velocities out.

    While the drone is lost, the node publishes nothing, and logs the loss.
    """

    def __init__(
        self,
        pose_handler: str = "vicon",
        pose_topic: str | None = None,
        estimator: Estimator | None = None,
        *,
        agent_id: int | None = None,
        parameters: Mapping[str, Any] | None = None,
        context: Context | None = None,
    ) -> None:
        """Make the node.

        Args:
            pose_handler: Kind of the messages, see `crazychoir_fw.ros.pose_sources`.
            pose_topic: Topic of the poses; None is ``/vicon/cf{d}/cf{d}`` with the number of the drone.
            estimator: The filter.
            agent_id: Number of the drone; None asks parameter and namespace.
            parameters: Values of parameters.
            context: Context of rclpy.
        """
        super().__init__("mocap_odometry", agent_id=agent_id, parameters=parameters, context=context)
        timeout = self.declare("pose_timeout", 0.25, "age of the pose at which a drone counts as lost (s)", low=0.001)
        self.estimator = Estimator() if estimator is None else estimator
        """The filter."""
        self._watch = PoseWatch(self, timeout)
        self._last: float | None = None
        self._odometry = self.announce(ODOM)
        topic = pose_topic or MOCAP_POSE.name.format(d=self.agent_id)
        self.pose_source = pose_subscribe(pose_handler, topic, self, self._take_pose, self.estimator)
        self.when_time_jumps_back(self._begin_anew)
        self.every(1.0 / timeout, self._watch.is_fresh)

    def _take_pose(self, pose: Pose) -> None:
        now = self.now()
        self._watch.saw(pose, now)
        if self._watch.is_fresh(now) and pose.time != self._last:
            self._last = pose.time
            self._odometry.publish(pose_to_odometry(pose))

    def _begin_anew(self, now: float) -> None:
        self.estimator.reset()
        self._watch.reset()
        self._last = None
