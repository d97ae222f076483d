"""Guidance without neighbors (docs/reference/crazychoir.md#8.1)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Reference
from crazychoir_fw.guidance.cf_guidance import TOUCHDOWN_HEIGHT, CFGuidance, Phase
from crazychoir_fw.guidance.climb import Climb, toward
from crazychoir_fw.guidance.law import POSES, Needs, NodeFace, option
from crazychoir_fw.guidance.moving_reference import MovingReference
from crazychoir_fw.guidance.outputs import Outputs

_EARLY = 1e-9  # [s]: times of steps are sums of periods


class SimpleGuidance(CFGuidance):
    """Takes off and lands; in between, others send trajectories."""

    node = NodeFace("simple_guidance", (*POSES, "takeoff_time", "height"))

    def __init__(self, takeoff_time: float = 5.0, height: float = 1.0, **options: Any) -> None:
        """Prepare; options and errors are those of `CFGuidance`."""
        super().__init__(takeoff_time=takeoff_time, height=height, **options)


class GoToGuidance(CFGuidance):
    """Flies to goals, one after the other, from START on; no call ever waits."""

    needs = Needs(goals=True)
    node = NodeFace("goto_guidance", (*POSES, "takeoff_time"))

    goals: Any = option((), "duration (s) and position (m, world) of each, shape (N, 4) or flat", kind=list[float])

    def __init__(self, takeoff_time: float = 5.0, goals: Sequence[ArrayLike] | ArrayLike = (), **options: Any) -> None:
        """Prepare.

        Args:
            takeoff_time: Of take-off and landing (s).
            goals: Duration (s) and position (m, world) of each, shape (N, 4) or flat.
            options: Of `CFGuidance`.

        Raises:
            RangeError: If a number is outside its range.
        """
        super().__init__(takeoff_time=takeoff_time, **options)
        agent_id = self.agent_id
        numbers = np.asarray(goals, dtype=np.float64)
        if numbers.size % 4 or numbers.ndim > 2 or not np.isfinite(numbers).all():
            raise RangeError(f"agent {agent_id}: goals have shape {numbers.shape}, allowed: (t, x, y, z) each, finite")
        self.goals = numbers.reshape(-1, 4)
        if (self.goals[:, 0] <= 0.0).any():
            raise RangeError(f"agent {agent_id}: a goal takes {self.goals[:, 0].min()} s, allowed: above 0 s")
        # sums, so that goals begin where they should however the steps fall
        self._begins = np.concatenate([[0.0], np.cumsum(self.goals[:, 0])])
        self._next = 0

    def begin_flight(self, now: float) -> None:
        """Begin with the first goal."""
        del now
        self._next = 0

    def step(self, now: float) -> Outputs:
        """Return what to ask for at a time (s)."""
        if self._phase is Phase.FLIGHT:
            while self._next < len(self.goals) and now - self._begin >= self._begins[self._next] - _EARLY:
                duration, *goal = self.goals[self._next]
                self.go_to(np.array(goal), duration)
                self._next += 1
        return self.outputs(now, None)

    def silent_until(self, now: float) -> float:
        """Return when the next goal is due (s), see `CFGuidance`."""
        if type(self).step is not GoToGuidance.step or not self._keeps_quiet:
            return -math.inf
        if self._phase is not Phase.FLIGHT or self.is_done:
            return math.inf
        return self._begin + float(self._begins[self._next]) - _EARLY

    @property
    def is_done(self) -> bool:
        """Whether the last goal was sent."""
        return self._next == len(self.goals)


class TargetListGuidance(CFGuidance):
    """Flies to a list of targets, each as soon as the one before is reached: `SimpleGuidance` of ChoiRbot.

    It needs no trajectory handler: a reference moves to the target with a constant speed.
    """

    kind = "fullstate"
    node = NodeFace(positional=("update_frequency",))

    goals: Any = option((), "position (m, world) of each, shape (N, 3) or flat", kind=list[float])
    tolerance: float = option(0.05, "distance in the plane at which a target is reached", "m", above=0)
    speed: float = option(0.5, "speed of the reference", "m/s", above=0)
    update_frequency: float = option(20.0, "steps per second", "Hz", above=0)

    def __init__(self, takeoff_time: float = 5.0, goals: Sequence[ArrayLike] | ArrayLike = (), **options: Any) -> None:
        """Prepare.

        Args:
            takeoff_time: Of take-off and landing (s).
            goals: Position of each (m, world), shape (N, 3) or flat; or with a duration before it, which is left out,
                (N, 4).
            options: Further options of the class.

        Raises:
            RangeError: If a number is outside its range.
        """
        super().__init__(takeoff_time=takeoff_time, **options)
        numbers = np.asarray(goals, dtype=np.float64)
        if numbers.ndim == 1 and numbers.size % 3 == 0:
            numbers = numbers.reshape(-1, 3)
        if numbers.size and (numbers.ndim != 2 or numbers.shape[1] not in (3, 4) or not np.isfinite(numbers).all()):
            raise RangeError(f"agent {self.agent_id}: goals have shape {numbers.shape}, allowed: (N, 3), finite")
        self.goals = numbers[:, -3:] if numbers.size else np.zeros((0, 3))
        self._climb = self.height / self.takeoff_time
        self.moving = MovingReference(self.speed, 0.5, 0.0)
        self._next = 0
        self._before: float | None = None

    def begin_takeoff(self, now: float) -> None:
        """Ask for the climb."""
        self.moving.begin(np.array([*self._above_start()[:2], self._position()[2]]))

    def begin_flight(self, now: float) -> None:
        """Begin with the first target."""
        self._next = 0

    def begin_landing(self, now: float) -> None:
        """Ask for the descent."""

    def step(self, now: float) -> Outputs:
        """Return what to ask for at a time (s)."""
        period, self._before = 0.0 if self._before is None else max(now - self._before, 0.0), now
        if self._phase is Phase.IDLE or self._phase is Phase.STOPPED:
            self.moving.position = None
            return self.outputs(now, None)
        if self.moving.position is None:
            self.moving.begin(self._position())
        if self._phase is Phase.FLIGHT:
            return self.outputs(now, self._toward_target(period))
        end = self.height if self._phase is Phase.TAKEOFF else TOUCHDOWN_HEIGHT
        return self.outputs(now, self.moving.rise(end, self._climb, period))

    def _toward_target(self, period: float) -> Reference:
        drone = self._position()
        while not self.is_done and np.linalg.norm((self.goals[self._next] - drone)[:2]) < self.tolerance:
            self._next += 1
        if not len(self.goals):
            return self.moving.move(np.zeros(3), drone, period)
        way = self.goals[min(self._next, len(self.goals) - 1)] - self.moving.position
        left = float(np.linalg.norm(way))
        speed = min(self.moving.max_speed, left / max(period, 1e-3))
        return self.moving.move(way * (speed / left) if left > 0.0 else way, drone, period)

    def has_landed(self, now: float) -> bool:
        """Return whether the landing is over."""
        is_down = self.moving.position is not None and self.moving.position[2] <= TOUCHDOWN_HEIGHT
        return is_down and super().has_landed(now)

    @property
    def is_done(self) -> bool:
        """Whether the last target was reached."""
        return self._next == len(self.goals)


class SimpleDIControl(CFGuidance):
    """Flies to one goal as a double integrator: u = k_p (goal - p) - k_d v (docs/reference/crazychoir.md#17.4)."""

    kind = "acceleration"
    node = NodeFace(positional=("update_frequency",))

    goals: Any = option((), "as a mission has them: of rows [duration, x, y, z] the last one counts")
    goal: Any = option(
        None, "where to fly from START on; None with no goals: above the start", "m, world", kind=list[float]
    )
    k_p: float = option(1.0, "acceleration per distance", "1/s^2", above=0)
    k_d: float = option(5.0, "acceleration per speed", "1/s", above=0)

    def __init__(self, takeoff_time: float = 5.0, goals: Sequence[ArrayLike] | ArrayLike = (), **options: Any) -> None:
        """Prepare.

        Args:
            takeoff_time: Of take-off and landing (s).
            goals: As a mission has them: of rows [duration, x, y, z] the last one counts.
            options: Further options of the class.

        Raises:
            RangeError: If a number is outside its range.
        """
        super().__init__(takeoff_time=takeoff_time, **options)
        goal = self.goal
        rows = np.asarray(goals, dtype=np.float64)
        if goal is None and rows.size:
            goal = rows.reshape(len(rows), -1)[-1, -3:]
        self.goal = None if goal is None else self._checked("goal", goal)
        self._climb: Climb | None = None

    def begin_takeoff(self, now: float) -> None:
        """Ask for the climb."""
        self._set_out(np.array([*self._above_start()[:2], self._position()[2]]), self.height, now)

    def begin_landing(self, now: float) -> None:
        """Ask for the descent."""
        self._set_out(self._position(), TOUCHDOWN_HEIGHT, now)

    def _set_out(self, start: NDArray[np.float64], height: float, now: float) -> None:
        self._climb = Climb(start, height, now, self.height / self.takeoff_time)

    def step(self, now: float) -> Outputs:
        """Return what to ask for at a time (s)."""
        if self._phase is Phase.IDLE or self._phase is Phase.STOPPED or self.current_pose is None:
            return self.outputs(now, None)
        return self.outputs(
            now, Reference(acceleration=toward(self.current_pose, *self._wanted(now), self.k_p, self.k_d))
        )

    def _wanted(self, now: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return where to be (m) and how fast (m/s)."""
        if self._phase is Phase.FLIGHT:
            return (self._above_start() if self.goal is None else self.goal), np.zeros(3)
        return (self._position(), np.zeros(3)) if self._climb is None else self._climb.wanted(now)

    def has_landed(self, now: float) -> bool:
        """Return whether the landing is over: it falls with the speed of the take-off."""
        top = self._position()[2] if self._climb is None else self._climb.start[2]
        at_bottom = top * self.takeoff_time / self.height
        return now - self._begin >= at_bottom + self.takeoff_time
