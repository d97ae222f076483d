"""Flies drawn curves: take-off where need be, all to where their curves begin, then all curves at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from crazychoir_fw.common.checkpoint import Stateful
from crazychoir_fw.common.errors import CrazychoirError, StateError
from crazychoir_fw.common.messages import TrajectoryPoint
from crazychoir_fw.flight.start_transit import cannot_go

if TYPE_CHECKING:
    from crazychoir_fw.flight.access import Access
    from crazychoir_fw.flight.agent import Agent
    from crazychoir_fw.flight.experiment import Experiment
    from crazychoir_fw.planning import Polynomial

APPROACH_SPEED = 0.5  # [m/s]
SHORTEST_S = 2.0
"""Min duration of a go-to without a given time (s)."""
_SETTLE_S = 1.0
_AT_HEIGHT_M = 0.1


def duration_of(distance: float) -> float:
    """Return the default duration (s) of a go-to over a distance (m)."""
    return max(SHORTEST_S, distance / APPROACH_SPEED)


def go_to(experiment: Experiment, agent: Agent, goal: Any, seconds: float) -> None:
    """Send a drone to a point (m, world), shape (3,)."""
    experiment.send_to(TrajectoryPoint(seconds, np.asarray(goal, float)), agent.name)


@dataclass
class Leg:
    """What one drone flies."""

    drone: int
    curve: Polynomial


class Flying(Stateful):
    """Curves on their way."""

    unkept = ("_access",)

    def __init__(self, experiment: Experiment, access: Access, legs: Sequence[Leg], name: str) -> None:
        """Begin: drones on the floor take off.

        Raises:
            StateError: If a drone follows no trajectories, or cannot fly.
        """
        self.name = name
        self.legs = list(legs)
        self.phase = "climb"
        self.started: float | None = None
        """When the curves began (s)."""
        self.problems: list[str] = []
        """Why drones were left out, sentences that are not reported yet."""
        self.duration = max(leg.curve.duration for leg in legs)
        self._experiment = experiment
        self._access = access
        agents = [experiment.agents[leg.drone] for leg in legs]
        for agent in agents:
            reason = cannot_go(experiment, agent) or (None if agent.planner else access.cannot_follow(agent.index))
            reason = reason or (None if agent.is_up else access.refusal(agent.index))
            if reason:
                raise StateError(reason)
        resting = [agent.name for agent in agents if not agent.is_up]
        self._until = experiment.time
        if resting:
            experiment.takeoff(resting)
            self._until += max(getattr(experiment.agents[leg.drone].guidance, "takeoff_time", 5.0) for leg in legs)
            self._until += _SETTLE_S

    def without(self, drones: Sequence[int]) -> None:
        """Leave out drones that received another command: stop, land or go-to."""
        self.legs = [leg for leg in self.legs if leg.drone not in drones]

    @property
    def is_over(self) -> bool:
        """Whether all curves have been flown."""
        return self.phase == "done" or not self.legs

    def step(self, now: float) -> None:
        """Go on to the next part when its time has come."""
        self.legs = [leg for leg in self.legs if self._experiment.agents[leg.drone].is_up]
        if self.is_over or now < self._until:
            return
        if self.phase == "climb":
            self.phase = "approach"
            self._until = now + self._approach() + _SETTLE_S
            # not earlier: what they fly by then is no trajectory of that memory
            self._of_all(self._begin_upload)
        elif self.phase == "approach":
            if not all(self._of_all(self._is_uploaded)):
                return
            self.phase = "curves"
            self.started = now
            self._until = now + self.duration
            self._of_all(lambda leg: follow(self._experiment, self._access, leg.drone, leg.curve, now))
        else:
            self.phase = "done"

    def _of_all(self, do: Callable[[Leg], Any]) -> list[Any]:
        """Do something for each leg; one for which it cannot be done is left out, and the others go on."""
        answers = []
        for leg in list(self.legs):
            try:
                answers.append(do(leg))
            except CrazychoirError as error:
                self.legs.remove(leg)
                self.problems.append(f"'{self.name}' is flown without {error}")
        return answers

    def _is_onboard(self, leg: Leg) -> bool:
        return self._experiment.agents[leg.drone].planner is None

    def _begin_upload(self, leg: Leg) -> None:
        if self._is_onboard(leg):
            self._access.begin_upload(leg.drone, leg.curve)

    def _is_uploaded(self, leg: Leg) -> bool:
        return not self._is_onboard(leg) or self._access.is_uploaded(leg.drone)

    def _approach(self) -> float:
        position = self._experiment.backend.poses().position
        starts = [leg.curve.at(0.0)[:3] for leg in self.legs]
        farthest = max(
            float(np.linalg.norm(start - position[leg.drone])) for leg, start in zip(self.legs, starts, strict=True)
        )
        seconds = duration_of(farthest)
        for leg, start in zip(self.legs, starts, strict=True):
            go_to(self._experiment, self._experiment.agents[leg.drone], start, seconds)
        return seconds


def follow(experiment: Experiment, access: Access, drone: int, curve: Polynomial, now: float) -> None:
    """Let a drone follow a curve from now on: its trajectory handler streams it, or it is on board already."""
    agent = experiment.agents[drone]
    if agent.planner is None:
        access.fly_uploaded(drone)
    elif hasattr(agent.planner, "set_curve"):
        agent.planner.set_curve(curve, now)
    else:  # of a user's, that knows points only
        count = max(2, math.ceil(curve.duration / 0.5))
        times = np.linspace(0.0, curve.duration, count + 1)[1:]
        experiment.set_trajectory([TrajectoryPoint(float(t), curve.at(t)[:3]) for t in times], agent.name)
