"""`GuidedSwarm`: what guidance asks for, round by round, and the trajectories that it hands over."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference, TrajectoryPoint
from crazychoir_fw.common.user_code import USER_ERRORS
from crazychoir_fw.flight.agent import Agent, DronePhase
from crazychoir_fw.flight.backend import Backend, one_of
from crazychoir_fw.flight.flying_swarm import FlyingSwarm
from crazychoir_fw.flight.silence import Silence
from crazychoir_fw.guidance import GuidanceGroup

Array = NDArray[np.float64]

_DESCENDS = 0.02  # [m/s], above what velocities of a drone at rest are taken for


class GuidedSwarm(FlyingSwarm):
    """Lets guidance speak to neighbors, hear and decide, and trajectory handlers plan."""

    def __init__(self, backend: Backend, agents: Sequence[Agent], controlled: Collection[int]) -> None:
        """Take the drones.

        Args:
            backend: Where the drones are.
            agents: The layers of each drone, in its order.
            controlled: Numbers of the drones with a controller; the planner on board flies the others.

        Raises:
            RangeError: If there is not one agent for each drone.
        """
        super().__init__(backend, agents)
        self._controlled = set(controlled)
        self.accelerations = np.zeros((len(agents), 3))
        """What guidance asks for (m/s^2, world), of drones that follow no trajectory, shape (N, 3)."""
        self._planned = [agent for agent in agents if agent.planner is not None]
        self._watching = [(agent, agent.guidance.watched) for agent in agents if getattr(agent.guidance, "watched", ())]
        # guidance of ours decides for all drones at once; what a user brings speaks for itself alone
        self._together = GuidanceGroup.of([agent.guidance for agent in agents])
        self._silence = Silence(agents)
        if self._together is not None:
            self._followers = np.array([self._together.followers], int).ravel()

    def _decide(self, agents: Sequence[Agent], poses: Pose, now: float) -> None:
        """Let guidance speak, then hear, then decide."""
        if self._together is not None and len(agents) == len(self.agents):
            self._decide_together(self._together, agents, poses, now)
            return
        if self._together is not None:
            self._together.let_go()
        self._let_watch(poses)
        agents = self._silence.others(agents, now)
        self._begin_rounds(agents, poses, now)
        self._finish_rounds(agents, poses, now)

    def _decide_together(self, group: GuidanceGroup, agents: Sequence[Agent], poses: Pose, now: float) -> None:
        """Let guidance of ours decide for all drones at once."""
        wanted = group.decide(now, np.asarray(poses.position), np.asarray(poses.velocity))
        if wanted is not None:
            self.accelerations[self._followers] = wanted
            return
        try:
            for agent in agents:
                agent.guidance.set_pose(one_of(poses, agent.index))
            decisions = group.step(now)
            for agent, outputs in zip(agents, decisions, strict=True):
                self._take(agent, outputs, poses, now)
        except USER_ERRORS:
            self._together = None  # from now on each guidance decides alone, which shows the one that raised

    def _begin_rounds(self, agents: Sequence[Agent], poses: Pose, now: float) -> None:
        """Tell each guidance where its drone is, and let it speak to its neighbors."""
        for agent in agents:
            guidance = agent.guidance
            if agent.failure is not None:
                continue
            try:
                guidance.set_pose(one_of(poses, agent.index))
                if hasattr(guidance, "begin_round"):
                    guidance.begin_round(now)
                    agent.in_round = guidance.round_open
            except USER_ERRORS as error:  # a user's code may raise anything, and lands its own drone only
                self._fail_by(agent, guidance, error)

    def _finish_rounds(self, agents: Sequence[Agent], poses: Pose, now: float) -> None:
        """Let each guidance hear what was sent, decide, and take what it asks for."""
        for agent in agents:
            guidance = agent.guidance
            if agent.failure is not None:
                continue
            try:
                # all have sent: rounds that are complete end at once, the others wait for their deadline
                is_over = agent.in_round and guidance.is_complete(now)
                outputs = guidance.finish_round(now) if is_over else guidance.step(now)
                _check_reference(outputs.reference)
                self._take(agent, outputs, poses, now)
                self._silence.look(agent, now)
            except USER_ERRORS as error:
                self._fail_by(agent, guidance, error)

    def _let_watch(self, poses: Pose) -> None:
        """Pass the poses of watched drones to the guidance laws that watch them."""
        for agent, watched in self._watching:
            if agent.failure is None:
                for j in watched:
                    if self._known[j]:
                        self._guarded(agent, agent.guidance.see, j, one_of(poses, j))

    def _take(self, agent: Agent, outputs: Any, poses: Pose, now: float) -> None:
        """Take what the guidance of a drone asks for."""
        if not agent.is_up:
            return
        if outputs.idle and agent.phase is DronePhase.LANDING:
            # guidance goes by time alone: a drone that lags and still descends shall not fall the rest of the way
            if not np.asarray(poses.velocity)[agent.index, 2] < -_DESCENDS:
                self._touch_down([agent])
            return
        if outputs.trajectory is not None:
            self._plan(agent, list(outputs.trajectory), one_of(poses, agent.index), now)
        if agent.planner is None and outputs.reference is not None:
            agent.reference = outputs.reference
            if outputs.reference.acceleration is not None:
                self.accelerations[agent.index] = outputs.reference.acceleration
        lost = getattr(agent.guidance, "lost", None)
        if lost is not None and lost != agent.lost:
            self._note_neighbors(agent, frozenset(lost))

    def _plan(self, agent: Agent, points: list[TrajectoryPoint], pose: Pose, now: float) -> None:
        if agent.planner is not None:
            agent.planner.set_trajectory(points, pose, now)
        elif agent.index not in self._controlled and agent.is_up:
            self.backend.go_to(agent.index, points[-1])
            agent.reference = Reference(position=np.array(points[-1].position, float))

    def _follow(self, now: float) -> None:
        """Ask trajectory handlers for references."""
        for agent in self._planned:
            planner = agent.planner
            if planner is None or not agent.is_up or agent.failure is not None or not self._known[agent.index]:
                continue
            try:
                reference = planner.evaluate(now)
            except USER_ERRORS as error:
                self._fail_by(agent, planner, error)
                continue
            if reference is not None:
                agent.reference = reference

    def _note_neighbors(self, agent: Agent, lost: frozenset[int]) -> None:
        for kind, numbers in (("lost", lost - agent.lost), ("rejoined", agent.lost - lost)):
            for number in sorted(numbers):
                self._note(kind, agent, f"{kind} {self.agents[number].name}")
        agent.lost = lost


def _check_reference(reference: Reference | None) -> None:
    """Refuse numbers that are none before they reach a controller that others share.

    Raises:
        RangeError: If there are some.
    """
    if reference is None:
        return
    for name in ("position", "velocity", "acceleration", "jerk"):
        value = getattr(reference, name)
        if value is not None and not _is_three_finite(value):
            raise RangeError(f"asks for the {name} {np.asarray(value)}, allowed: three finite numbers")


def _is_three_finite(value: Any) -> bool:
    if np.shape(value) != (3,):
        return False
    # three additions cost a tenth of isfinite().all(), and are infinite at worst
    return math.isfinite(value[0] + value[1] + value[2]) or bool(np.isfinite(value).all())
