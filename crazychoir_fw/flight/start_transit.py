"""Flying drones go to above their starts: all at once, and where their ways would meet, at different heights."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.checkpoint import Stateful
from crazychoir_fw.common.errors import StateError
from crazychoir_fw.common.messages import TrajectoryPoint
from crazychoir_fw.flight.agents import starts_of

if TYPE_CHECKING:
    from crazychoir_fw.flight.agent import Agent
    from crazychoir_fw.flight.experiment import Experiment
    from crazychoir_fw.mission.schema import LayeredMission

Array = NDArray[np.float64]

CLEARANCE_M = 0.6
"""Drones that come nearer on their ways, seen from above, fly at different heights (m)."""
LAYER_M = 0.6
"""Distance of these heights (m): downwash is weak there."""
NEAR_M = 0.3
"""A drone that stays within this distance of the start of another one is in its way (m)."""
PACE = 0.5
"""Mean speed of the longest way of a stage (m/s)."""
_SHORTEST_S = 2.0
_THERE_M = 0.05  # from its start a drone need not move
_ARRIVED_M = 0.15  # from the end of a stage the next one may begin
_PATIENCE_S = 5.0  # after the end of a stage
_STAGES = ("climb", "cross", "descend")


@dataclass(frozen=True)
class Stage:
    """What drones do at the same time."""

    name: str
    seconds: float
    goals: dict[int, Array]
    """Where to (m, world), by the number of the drone."""


def cannot_go(experiment: Experiment, agent: Agent) -> str | None:
    """Return why a drone follows no trajectory of a user, a sentence, or None."""
    controlled = {int(i) for group in experiment.groups for i in group.indices}
    if agent.planner is None and agent.index in controlled:
        return (
            f"{agent.name}: follows its guidance, {type(agent.guidance).__name__}, and takes no trajectories; "
            "a mission with layers.planning does"
        )
    return agent.failure and f"{agent.failure}; REBOOT helps"


def cannot_be_sent(experiment: Experiment, agent: Agent) -> str | None:
    """Return why a drone cannot be sent to a point, a sentence, or None."""
    reason = cannot_go(experiment, agent)
    if reason is None or agent.failure is not None or not hasattr(experiment, "cannot_divert"):
        return reason
    return experiment.cannot_divert(agent)


def plan_transit(position: Array, starts: Array, movers: Sequence[int], resting: Sequence[int] = ()) -> list[Stage]:
    """Return the stages after which each mover hovers above its start, at the height that it has now.

    They climb to heights of their own where their ways meet, cross on straight ways at the same pace, and descend.

    Args:
        position: Where all drones are (m), shape (N, 3).
        starts: Where they shall be, shape (N, 2) or (N, 3).
        movers: Numbers of the drones that go.
        resting: Numbers of those that hover and stay.
    """
    goals = position.copy()
    goals[list(movers), :2] = starts[list(movers), :2]
    going = [i for i in movers if np.linalg.norm(goals[i] - position[i]) > _THERE_M]
    heights = {i: float(position[i, 2]) for i in {*movers, *resting} - {*going}}
    for i in going:
        taken = [height for j, height in heights.items() if _least_distance(position, goals, i, j) < CLEARANCE_M]
        heights[i] = _free(float(position[i, 2]), taken)
    above, across = position.copy(), goals.copy()
    for i in going:
        above[i, 2] = across[i, 2] = heights[i]
    stages, at = [], position
    for name, wanted in zip(_STAGES, (above, across, goals), strict=True):
        lengths = {i: float(np.linalg.norm(wanted[i] - at[i])) for i in going}
        chosen = {i: wanted[i] for i, length in lengths.items() if length > 0.0}
        if chosen:
            stages.append(Stage(name, max(_SHORTEST_S, max(lengths.values()) / PACE), chosen))
        at = wanted
    return stages


def _free(height: float, taken: Sequence[float]) -> float:
    """Return the lowest height (m) from one on that keeps its distance from those that are taken."""
    for other in sorted(taken):
        if abs(height - other) < LAYER_M - 1e-9:
            height = other + LAYER_M
    return height


def _least_distance(position: Array, goals: Array, i: int, j: int) -> float:
    """Return how near two drones come (m), seen from above, when both are at the same share of their ways."""
    between = (position[i] - position[j])[:2]
    change = (goals[i] - goals[j])[:2] - between
    square = float(change @ change)
    share = 0.0 if square == 0.0 else float(np.clip(-between @ change / square, 0.0, 1.0))
    return float(np.linalg.norm(between + share * change))


class StartTransit(Stateful):
    """Drones on their way to above their starts; give it a `step` after each round."""

    name = "GO TO STARTS"

    def __init__(self, experiment: Experiment, mission: LayeredMission, drones: Sequence[str] | None = None) -> None:
        """Begin with the next `step`.

        Args:
            experiment: What flies.
            mission: Says where the starts are, and how high drones may fly.
            drones: Names of those that go, if they fly and can be sent; None: all of these.

        Raises:
            StateError: If a drone that stays is in the way, one is not seen, or the sky is too low.
        """
        up = [agent for agent in experiment.agents if agent.is_up]
        chosen = [agent for agent in up if drones is None or agent.name in drones]
        self._experiment = experiment
        self.movers = [agent.index for agent in chosen if cannot_be_sent(experiment, agent) is None]
        """Numbers of the drones that go."""
        position, starts = np.asarray(experiment.backend.poses().position), starts_of(mission)
        known = [agent.index for agent in up if np.isfinite(position[agent.index]).all()]
        if unknown := set(self.movers) - set(known):
            raise StateError(f"{self.name}: {experiment.agents[min(unknown)].name} is not seen")
        resting = [i for i in known if i not in self.movers]
        self._check_way(position, starts, resting)
        self._stages = plan_transit(position, starts, self.movers, resting)
        self._check_height(mission)
        self.phase = "begins"
        """What is flown at present."""
        self.started: float | None = None
        """When it began (s)."""
        self.duration = sum(stage.seconds for stage in self._stages)
        """How long it takes at least (s)."""
        self.problems: list[str] = []
        """Why it ended before its end, sentences that the console has not shown yet."""
        self._next = 0
        self._until = 0.0
        self._left_out: set[int] = set()

    def _check_way(self, position: Array, starts: Array, resting: Sequence[int]) -> None:
        agents = self._experiment.agents
        for j in resting:
            gaps = np.linalg.norm(starts[:, :2] - position[j, :2], axis=1)
            for i in self.movers:
                if gaps[i] < NEAR_M <= gaps[j]:
                    raise StateError(
                        f"{self.name}: {agents[j].name} stays above the start of {agents[i].name}; send it as well"
                    )

    def _check_height(self, mission: LayeredMission) -> None:
        area = mission.hardware.safety_area
        top = max((float(goal[2]) for stage in self._stages for goal in stage.goals.values()), default=0.0)
        if area is not None and top > area.high[2]:
            raise StateError(
                f"{self.name}: so many ways cross that a drone would fly at {top:.1f} m, allowed: {area.high[2]:g} m, "
                "the safety area; send fewer drones at once, or fly lower"
            )

    def without(self, drones: Sequence[int]) -> None:
        """Leave out drones that another button was pressed for."""
        self._left_out |= set(drones)

    @property
    def is_over(self) -> bool:
        """Whether all drones have arrived, or none is under way any more."""
        return self.phase == "done" or not self._going

    @property
    def _going(self) -> list[int]:
        return [i for i in self.movers if i not in self._left_out and self._experiment.agents[i].is_up]

    def step(self, now: float) -> None:
        """Begin the next stage when all have come to the end of the one before."""
        if self.started is None:
            self.started = self._until = now
        if self.is_over or now < self._until - 1e-9 or not self._are_there(now):
            return
        if self._next == len(self._stages):
            self.phase = "done"
            return
        stage = self._stages[self._next]
        self._next += 1
        self.phase, self._until = stage.name, now + stage.seconds
        for i in self._going:
            if i in stage.goals:
                point = TrajectoryPoint(stage.seconds, stage.goals[i])
                self._experiment.send_to(point, self._experiment.agents[i].name)

    def _are_there(self, now: float) -> bool:
        """Return whether the next stage may begin; gives up when a drone does not come."""
        if self._next == 0:
            return True
        goals = self._stages[self._next - 1].goals
        position = np.asarray(self._experiment.backend.poses().position)
        late = [i for i in self._going if i in goals and not np.linalg.norm(position[i] - goals[i]) < _ARRIVED_M]
        if late and now > self._until + _PATIENCE_S:
            self.problems.append(f"{self.name} ends: {self._experiment.agents[late[0]].name} does not arrive")
            self.phase = "done"
        return not late
