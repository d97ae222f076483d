"""Layers that live in other processes, as the experiment of the host sees them: what was heard of them."""

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
    """A guidance somewhere else: what it has asked for, as far as that was heard here."""

    def __init__(self, kind: str, takeoff_time: float) -> None:
        """Know what references it gives, and how long its take-off lasts (s)."""
        self.kind, self.takeoff_time = kind, takeoff_time
        self.reference: Reference | None = None
        self.points: list[TrajectoryPoint] | None = None
        self.lost: frozenset[int] = frozenset()
        self.is_new = False
        """Whether anything was heard since somebody looked."""
        self.communicator: RemoteCommunicator | None = None
        """What it tells of its communicator, if it has neighbors."""

    @classmethod
    def of(cls, mission: Any, i: int) -> RemoteGuidance:
        """Return that of a drone of a mission, whose class people know by its name."""
        kind = "acceleration" if one_command(mission) == "xyz" else what_it_follows(mission, i)
        return type(guidance_class(mission, i).__name__, (cls,), {})(kind, takeoff_time_of(mission))

    def set_pose(self, pose: Pose) -> None:
        """It hears its pose by topic."""

    def step(self, now: float) -> Outputs:
        """Return what was heard."""
        del now
        points, self.points = self.points, None
        return Outputs(self.reference, points)


class RemotePlanner:
    """A trajectory handler somewhere else: points go there by topic, and references were heard as the guidance's."""

    def __init__(self, guidance: RemoteGuidance, publisher: Any, agent_id: int) -> None:
        """Publish points on ``traj_params``."""
        self.kind = guidance.kind
        self._guidance, self._publisher, self._agent_id = guidance, publisher, agent_id

    def set_trajectory(self, points: list[TrajectoryPoint], pose: Pose, now: float) -> None:
        """Hand points over."""
        del pose, now
        self._publisher.publish(points_to_joint_trajectory(points, self._agent_id))

    def evaluate(self, now: float) -> Reference | None:
        """Return a reference that was heard since it was asked for last."""
        del now
        reference, self._guidance.reference = self._guidance.reference, None
        return reference


class RemoteGroup:
    """The controllers of all drones, somewhere else."""

    def __init__(self, commands: CommandInbox, kind: str) -> None:
        """Take commands of a kind."""
        self._commands = commands
        self.kind = kind
        self.indices = np.arange(len(commands.is_new))
        self.commanded = np.full(len(self.indices), -np.inf)
        """When the latest command was passed on, or the motors did not turn (s), shape (N,)."""
        self.unheard: set[int] = set()
        """Whose commands are not passed on, since the host lands them itself."""

    def step(
        self,
        agents: Sequence[Agent],
        accelerations: NDArray[np.float64],
        turning: NDArray[np.bool_],
        poses: Pose,
        now: float,
    ) -> tuple[NDArray[np.intp], Twist] | None:
        """Return who has sent commands, of those whose motors turn, and these."""
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
    """Return what takes the words of a guidance on `lost_neighbors`, by the numbers of namespaces."""

    def take(message: String) -> None:
        word, _, name = message.data.partition(" ")
        if name in numbers:
            one = frozenset([numbers[name]])
            guidance.lost = guidance.lost | one if word == "lost" else guidance.lost - one

    return take


def points_taker(guidance: RemoteGuidance) -> Any:
    """Return what takes the points of a guidance."""

    def take(message: Any) -> None:
        guidance.points = joint_trajectory_to_points(message)
        guidance.is_new = True

    return take


def reference_taker(guidance: RemoteGuidance, kind: str) -> Any:
    """Return what takes the references of a guidance, of a kind."""

    def take(message: Any) -> None:
        guidance.reference = message_to_reference(message, kind)
        guidance.is_new = True

    return take
