"""Radio handlers as ROS 2 nodes, one per Crazyradio, with the names of the original (docs/reference/crazychoir.md#13).

A handler has threads of its own. They put received data into a queue, which the node's executor publishes. Calls that
may take seconds, such as a take-off, run in worker threads.
"""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from rclpy.clock import Clock, ClockType
from rclpy.context import Context
from sensor_msgs.msg import BatteryState
from std_msgs.msg import String

from crazychoir_fw.common.errors import CrazychoirError, RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.ros.conversions import (
    joint_trajectory_to_points,
    message_to_twist,
    pose_stamped_to_pose,
    pose_to_odometry,
)
from crazychoir_fw.ros.names import CF_ODOM, CMD_VEL, FAILURE, LATEST, MOCAP_POSE, TRAJ_PARAMS, qos
from crazychoir_fw.ros.node import LayerNode

_PUBLISH_EVERY = 0.005  # [s], wall
_BREATH_S = 0.0002  # [s], for threads of the radio
_VOLTAGE = "pm.vbat"
_LOG_HZ = 1.0


class RadioHandler(LayerNode):
    """The drones of one Crazyradio as topics.

    Parameters: ``uris``; ``agent_ids``, numbers of the drones in that order; ``cmd_topic``, ``cmd_vel`` or
    ``traj_params``; ``logger``, whether battery voltages are logged to ``battery``; ``send_groundtruth``, whether poses
    of motion capture on ``/vicon/cf{d}/cf{d}`` are forwarded, where d is the last digit of the URI; ``odom_topic``,
    where the drones' own odometry goes; ``odometry_hz``, how often (Hz); ``takeoff_height`` (m).

    The buttons ``/takeoff``, ``/land`` and ``/stop`` are those of the handler; ``/experiment_trigger`` does nothing.
    The handler lands a drone at the first message on its ``failure``.
    """

    handler_name = "RadioHandlerFPQR"
    """Class of `crazychoir_fw.radio`."""
    cmd_topic = CMD_VEL.name
    """Default topic of commands, see the parameter ``cmd_topic``."""
    flies_by_itself = False
    """Whether a take-off is flown by the planner on board."""

    def __init__(
        self,
        *,
        make: Callable[..., Any] | None = None,
        parameters: Mapping[str, Any] | None = None,
        context: Context | None = None,
        radio_id: int = 0,
        **options: Any,
    ) -> None:
        """Make the node ``radio`` and connect to the drones.

        Args:
            make: Makes the handler of URIs by agent and options; None takes that of `crazychoir_fw.radio`.
            parameters: Values of parameters.
            context: Context of rclpy.
            radio_id: Number of the Crazyradio: the node is called ``radio_{radio_id}``.
            options: Of the handler, see `crazychoir_fw.radio.Options`.

        Raises:
            RangeError: If parameters are missing or outside their range.
            RadioError: If drones are not reached.
        """
        super().__init__(f"radio_{radio_id}", swarm_wide=True, parameters=parameters, context=context)
        uris = self.declare("uris", [], "URIs of the drones", list[str]) or []
        numbers = self.declare("agent_ids", list(range(len(uris))), "numbers of the drones", list[int], low=0)
        if not uris or len(numbers or []) != len(uris):
            given = f"{len(uris)} uris and {len(numbers or [])} agent_ids"
            raise RangeError(f"radio: {given}, allowed: as many, and one or more")
        self.height = self.declare("takeoff_height", 0.5, "height of the take-off (m)", low=0.05, high=10.0)
        topic = self.declare("cmd_topic", self.cmd_topic, "topic of the commands")
        logs = self.declare("logger", False, "whether battery voltages are logged")
        forwards = self.declare("send_groundtruth", True, "whether poses of motion capture are forwarded")
        odom = self.declare("odom_topic", CF_ODOM.name, "topic of the drones' own odometry")
        rate = self.declare("odometry_hz", 50.0, "rate of the drones' own odometry (Hz)", low=0.0, high=100.0)
        options.setdefault("odometry_hz", rate)
        self._number_of = {f"agent_{number}": number for number in numbers}
        self._spoken: queue.SimpleQueue[tuple[Any, Any]] = queue.SimpleQueue()
        self._odom = {name: self.announce(CF_ODOM, self.topic_of(i, odom)) for name, i in self._number_of.items()}
        self._states = {
            name: self.create_publisher(String, self.topic_of(i, "radio_state"), qos(10))
            for name, i in self._number_of.items()
        }
        self._batteries: dict[str, Any] = {}
        if logs:
            options.setdefault("log", {_VOLTAGE: _LOG_HZ})
            self._batteries = {
                name: self.create_publisher(BatteryState, self.topic_of(i, "battery"), qos(10))
                for name, i in self._number_of.items()
            }
        if make is None:
            from crazychoir_fw import radio

            make = getattr(radio, self.handler_name)
        self.handler = make(dict(zip(self._number_of, uris, strict=True)), **options)
        self.handler.on_odometry = self._heard_odometry
        self.handler.on_log = self._heard_log
        self.handler.on_state = lambda agent, state, why: self._say(agent, f"{state} {why}".strip())
        self.handler.on_event = lambda agent, kind, text: self._say(agent, f"{kind} {text}")
        # a button, above all a stop, must not wait while another one takes seconds
        self._workers = ThreadPoolExecutor(max_workers=4, thread_name_prefix="radio")
        self._listen(dict(zip(self._number_of, uris, strict=True)), topic, forwards)
        self.create_timer(_PUBLISH_EVERY, self._publish_heard, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self.handler.connect()

    def _listen(self, uris: Mapping[str, str], topic: str, forwards: bool) -> None:
        for name, i in self._number_of.items():
            where = self.topic_of(i, topic)
            if topic == TRAJ_PARAMS.name:
                self.listen(TRAJ_PARAMS, self._point_taker(name), where)
            else:
                self.listen(CMD_VEL, self._command_taker(name), where, profile=qos(10))
            self.create_subscription(String, self.topic_of(i, FAILURE), self._failure_taker(name), LATEST)
            if forwards:
                digit = uris[name][-1]
                self.listen(MOCAP_POSE, self._pose_taker(name), MOCAP_POSE.name.format(d=digit))
        self.on_buttons(
            takeoff=lambda now: self._work(self._take_off),
            land=lambda now: self._work(self.handler.land),
            stop=lambda now: self._work(self.handler.stop),
        )

    # ---------------------------------------------------------------- in

    def _command_taker(self, name: str) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            twist = message_to_twist(message)
            self.handler.cmd_vel(name, twist.linear.tolist(), twist.angular.tolist())

        return take

    def _point_taker(self, name: str) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            point = joint_trajectory_to_points(message)[-1]
            self._work(lambda: self.handler.command(name, *point.position.tolist(), point.time_s))

        return take

    def _pose_taker(self, name: str) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            pose = pose_stamped_to_pose(message)
            self.handler.external_pose(name, pose.position.tolist(), pose.orientation.tolist())

        return take

    def _failure_taker(self, name: str) -> Callable[[String], None]:
        def take(message: String) -> None:
            del message  # the node that failed has logged it
            self._work(lambda: self.handler.land(agents=[name]))

        return take

    def _take_off(self) -> None:
        if self.flies_by_itself:
            self.handler.takeoff(self.height)
        else:
            # only unlocks the motors: commands lead the drone
            self.handler.takeoff()

    def _work(self, do: Callable[[], Any]) -> None:
        def guarded() -> None:
            try:
                do()
            except CrazychoirError as error:
                self.get_logger().error(str(error))

        self._workers.submit(guarded)

    # ---------------------------------------------------------------- out

    def _say(self, agent: str, text: str) -> None:
        self._spoken.put((self._states[agent], lambda: String(data=text)))

    def _heard_odometry(self, agent: str, seen: Any) -> None:
        def message() -> Any:
            values = (seen.position, seen.quat_xyzw, seen.velocity, seen.body_rates)
            return pose_to_odometry(Pose(*(np.asarray(value, float) for value in values), time=self.now()))

        self._spoken.put((self._odom[agent], message))

    def _heard_log(self, agent: str, values: Mapping[str, float], time_s: float) -> None:
        del time_s
        if agent in self._batteries and _VOLTAGE in values:
            voltage = float(values[_VOLTAGE])
            self._spoken.put((self._batteries[agent], lambda: BatteryState(voltage=voltage, present=True)))

    def _publish_heard(self) -> None:
        for _ in range(self._spoken.qsize()):
            publisher, message = self._spoken.get()
            publisher.publish(message())
        # an executor that always has something to do takes the interpreter back before a waiting thread is awake: the
        # radio's threads would fall silent, and their drones with them
        time.sleep(_BREATH_S)

    def destroy_node(self) -> None:
        """Bring the drones down according to the handler's option ``on_close``, and close the links."""
        self._workers.shutdown(wait=False, cancel_futures=True)
        self.handler.close()
        super().destroy_node()


class RadioHandlerFPQR(RadioHandler):
    """Thrust and body rates on ``cmd_vel``."""


class RadioHandlerFRPY(RadioHandler):
    """Thrust and angles on ``cmd_vel``."""

    handler_name = "RadioHandlerFRPY"


class RadioHandlerVel(RadioHandler):
    """Velocities on ``cmd_vel``."""

    handler_name = "RadioHandlerVel"
    flies_by_itself = True


class RadioHandlerXYZ(RadioHandler):
    """Points on ``traj_params``."""

    handler_name = "RadioHandlerXYZ"
    cmd_topic = TRAJ_PARAMS.name
    flies_by_itself = True


class RadioHandlerVelLightHouse(RadioHandlerVel):
    """Velocities, with drones that know their places by lighthouse."""

    handler_name = "RadioHandlerVelLightHouse"


class RadioHandlerXYZLightHouse(RadioHandlerXYZ):
    """Points, with drones that know their places by lighthouse."""

    handler_name = "RadioHandlerXYZLightHouse"
