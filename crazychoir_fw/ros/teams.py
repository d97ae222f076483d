"""Teams: equal nodes of one process that compute together, in a fraction of the time that each for itself takes.

A team answers a bundle of odometry for all of its nodes at once, with the groups of the plain layers. What the nodes
say is the same, on the same topics; whenever a round is not of the plain kind, each node works by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw import control
from crazychoir_fw.common.messages import Pose, Reference, Twist
from crazychoir_fw.flight import agents
from crazychoir_fw.guidance import BearingFormation, GuidanceGroup
from crazychoir_fw.mission.communicators import goes_by_distance
from crazychoir_fw.ros.controller import CrazyflieController
from crazychoir_fw.ros.guidance_node import GuidanceNode

Array = NDArray[np.float64]


def make_teams(mission: Any, nodes: Sequence[Any]) -> None:
    """Let nodes of one hub work together, as far as they are equal."""
    guidance = [node for node in nodes if isinstance(node, GuidanceNode)]
    # who talks to other processes goes by their pace, and who hears only those near by has to look where they are
    alike = not goes_by_distance(mission) and all(type(node.guidance) is BearingFormation for node in guidance)
    if alike and len(guidance) == len(mission.fleet) > 1:
        GuidanceTeam(guidance)
    members = [node for node in nodes if type(node) is CrazyflieController and has_no_memory(node.controller)]
    if len(members) > 1:
        ControlTeam(members, agents.make_controller(mission, [node.agent_id for node in members]))


def has_no_memory(controller: Any) -> bool:
    """Whether it is one whose command depends on pose and reference only, so that anybody may compute it."""
    return (
        type(controller) is control.HierarchicalController
        and type(controller.position_strategy) is control.FlatnessAccelerationCtrl
        and type(controller.attitude_strategy) in (control.GeometryAttitudeCtrl, type(None))
        and len(controller.periods) == 1
    )


class GuidanceTeam:
    """Guidance of a whole swarm in one process."""

    def __init__(self, nodes: Sequence[GuidanceNode]) -> None:
        """Join nodes that hear no other process."""
        self._nodes = list(nodes)
        self._group = GuidanceGroup([node.guidance for node in nodes], sends=False)
        by_id = {node.agent_id: node for node in nodes}
        self._followers = [by_id[i] for i in self._group.followers]
        self._rows: list[int | None] = [None]
        self._poses: list[Pose] = []
        hub = nodes[0].hub
        assert hub is not None
        hub.guidance_team = self
        for node in nodes:
            node.team = self

    def work(self, numbers: Array, turned: Array, good: Sequence[bool], now: float) -> bool:
        """Do the round of all nodes, if it is a plain one; else each does its own.

        Args:
            numbers: Rows of a bundle of odometry, shape (N, 13).
            turned: Their quaternions, of length 1, shape (N, 4).
            good: Which rows are usable.
            now: Time (s).
        """
        rows = [node.row for node in self._nodes]
        if None in rows or not all(good) or not all(node.may_work_in_team for node in self._nodes):
            self._group.let_go()
            return False
        if rows != self._rows:
            self._rows, self._order = rows, np.array(rows)
        own = numbers[self._order]
        self._latest = own, turned[self._order], now
        wanted = self._group.decide(now, own[:, :3], own[:, 7:10])
        if wanted is None:
            self.tell_poses()
            for node, outputs in zip(self._nodes, self._group.step(now), strict=True):
                node.take_outputs(outputs)
            return True
        for node, acceleration in zip(self._followers, wanted, strict=True):
            node.ask_for(Reference(acceleration=acceleration))
        for node in self._nodes:
            node.answer()
        return True

    def tell_poses(self) -> None:
        """Tell all plain guidance where they are; in formation only the group knows."""
        own, turned, now = self._latest
        for node, row, attitude in zip(self._nodes, own, turned, strict=True):
            node.note_pose(Pose(row[:3], attitude, row[7:10], row[10:], now))


class ControlTeam:
    """Controllers that follow accelerations."""

    def __init__(self, nodes: Sequence[CrazyflieController], controller: Any) -> None:
        """Join nodes.

        Args:
            nodes: The nodes.
            controller: Computes for all of them, in their order.
        """
        self._nodes = list(nodes)
        self._controller = controller
        count = len(nodes)
        self._pose = Pose(np.zeros((count, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)), *np.zeros((2, count, 3)))
        self._accelerations = np.zeros((count, 3))
        self._present: list[int] = []
        self._now = -np.inf
        hub = nodes[0].hub
        assert hub is not None
        for k, node in enumerate(nodes):
            node.join(self, k)
        hub.when_settling(nodes[0], self._settle)

    def take(self, k: int, pose: Pose, reference: Reference, now: float) -> None:
        """Let node k have its command with the others of this step."""
        stacked = self._pose
        stacked.orientation[k] = pose.orientation  # type: ignore[index]
        stacked.angular[k] = pose.angular  # type: ignore[index]
        self._accelerations[k] = reference.acceleration
        self._present.append(k)
        self._now = now

    def _settle(self) -> None:
        if not self._present:
            return
        present, self._present = self._present, []
        controller = self._controller
        # a pose remembers the matrix of each array of attitudes: what was written into the last one would not be seen
        self._pose.orientation = np.copy(self._pose.orientation)
        controller.set_pose(self._pose)
        controller.set_reference(Reference(acceleration=self._accelerations.copy()))
        twist = controller.step(self._now)
        if twist is not None:
            linear, angular = twist.linear, twist.angular
            for k in present:
                self._nodes[k].send_input(Twist(linear[k], angular[k]))
