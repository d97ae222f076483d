"""Proxies of layers in other processes, for the experiment of the host: they hold the latest messages received."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from std_msgs.msg import String

from crazychoir_fw.common.messages import Pose, Reference, TrajectoryPoint, Twist
from crazychoir_fw.flight.agent import Agent
from crazychoir_fw.flight.agents import guidance_class, takeoff_time_of, what_it_follows
from crazychoir_fw.guidance import Outputs
from crazychoir_fw.ros.conversions import joint_trajectory_to_points, message_to_reference, points_to_joint_trajectory
from crazychoir_fw.ros.parts import one_command
from crazychoir_fw.ros.simulation import CommandInbox
from crazychoir_fw.ros.statistics import RemoteCommunicator


class RemoteGuidance:
    """A guidance in another process: its latest reference, points and lost neighbors received."""

    def __init__(self, kind: str, takeoff_time: float) -> None:
        """Store the kind of its references, and the duration of its take-off (s)."""
        self.kind, self.takeoff_time = kind, takeoff_time
        self.reference: Reference | None = None
        self.points: list[TrajectoryPoint] | None = None
        self.lost: frozenset[int] = frozenset()
        self.is_new = False
        """Whether a message came since the last round of the host."""
        self.communicator: RemoteCommunicator | None = None
        """Statistics received of its communicator, if it has neighbors."""

    @classmethod
    def of(cls, mission: Any, i: int) -> RemoteGuidance:
        """Return the proxy for a drone of a mission, of a class named as its guidance."""
        kind = "acceleration" if one_command(mission) == "xyz" else what_it_follows(mission, i)
        return type(guidance_class(mission, i).__name__, (cls,), {})(kind, takeoff_time_of(mission))

    def set_pose(self, pose: Pose) -> None:
        """Do nothing: the guidance receives its pose by topic."""

    def step(self, now: float) -> Outputs:
        """Return the latest reference, and points that came since the last call."""
        del now
        points, self.points = self.points, None
        return Outputs(self.reference, points)


class RemotePlanner:
    """A trajectory handler in another process: points go to it by topic; `RemoteGuidance` holds its references."""

    def __init__(self, guidance: RemoteGuidance, publisher: Any, agent_id: int) -> None:
        """Publish points on ``traj_params``."""
        self.kind = guidance.kind
        self._guidance, self._publisher, self._agent_id = guidance, publisher, agent_id

    def set_trajectory(self, points: list[TrajectoryPoint], pose: Pose, now: float) -> None:
        """Publish points."""
        del pose, now
        self._publisher.publish(points_to_joint_trajectory(points, self._agent_id))

    def evaluate(self, now: float) -> Reference | None:
        """Return the reference that came since the last call, or None."""
        del now
        reference, self._guidance.reference = self._guidance.reference, None
        return reference


class RemoteGroup:
    """The controllers of all drones, in other processes."""

    def __init__(self, commands: CommandInbox, kind: str) -> None:
        """Take commands of a kind."""
        self._commands = commands
        self.kind = kind
        self.indices = np.arange(len(commands.is_new))
        self.commanded = np.full(len(self.indices), -np.inf)
        """When the latest command was passed on, or the motors did not turn (s), shape (N,)."""
        self.unheard: set[int] = set()
        """Drones whose commands are dropped, since the host flies them itself."""

    def step(
        self,
        agents: Sequence[Agent],
        accelerations: NDArray[np.float64],
        turning: NDArray[np.bool_],
        poses: Pose,
        now: float,
    ) -> tuple[NDArray[np.intp], Twist] | None:
        """Return the drones with new commands and turning motors, and these commands."""
        del agents, accelerations, poses
        indices, twist = self._commands.take()
        chosen = turning[indices]
        if self.unheard:
            chosen &= ~np.isin(indices, list(self.unheard))
        self.commanded[indices] = self.commanded[~turning] = now
        if not chosen.any():
            return None
        return indices[chosen], Twist(twist.linear[chosen], twist.angular[chosen])


def neighbors_taker(guidance: RemoteGuidance, numbers: dict[str, int]) -> Any:
    """Return the callback of a guidance's messages on `lost_neighbors`, by the numbers of namespaces."""

    def take(message: String) -> None:
        word, _, name = message.data.partition(" ")
        if name in numbers:
            one = frozenset([numbers[name]])
            guidance.lost = guidance.lost | one if word == "lost" else guidance.lost - one

    return take


def points_taker(guidance: RemoteGuidance) -> Any:
    """Return the callback of the points of a guidance."""

    def take(message: Any) -> None:
        guidance.points = joint_trajectory_to_points(message)
        guidance.is_new = True

    return take


def reference_taker(guidance: RemoteGuidance, kind: str) -> Any:
    """Return the callback of the references of a guidance, of a kind."""

    def take(message: Any) -> None:
        guidance.reference = message_to_reference(message, kind)
        guidance.is_new = True

    return take
