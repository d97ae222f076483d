"""`MPCGuidance`: sequential distributed model predictive control (docs/reference/crazychoir.md#17.4).

Time goes in periods. During each, agents plan the next one after another, by number: each takes the plans that those
before it have just made and those that the others made a period ago, and keeps what couples it to them. The old plan
of an agent is still feasible at its turn, because those before it respected that plan.

In the original a set of plans is handed from agent to agent and all others wait. Here each agent sends its plan to its
neighbors in every round, and plans at its turn, so that no agent waits in vain. A neighbor that is late or silent is
expected to follow its latest plan. It is left out of the coupling once it counts as lost.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Reference
from crazychoir_fw.guidance.cf_guidance import Phase
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.formation_metrics import ShapeMetrics
from crazychoir_fw.guidance.law import LawContext, Needs, option
from crazychoir_fw.guidance.metrics import Flown, criterion
from crazychoir_fw.guidance.schemes.mpc_problem import MPCProblem, Plan
from crazychoir_fw.guidance.velocity_feedback import VelocityFeedback

Array = NDArray[np.float64]

_TURN = 0.6  # of a period, after which an agent plans without waiting for those before it


class TogetherMetrics(ShapeMetrics):
    """Drones shall come to the goal, without ever being too far from neighbors; both along some axes."""

    curve_label, curve_limit = "distance from its place (m)", "position_error_m"

    def __init__(self, context: LawContext) -> None:
        """Take goal and axes."""
        super().__init__(context)
        self.axes = tuple("xyz".index(axis) for axis in context.option("axes", "x") if axis in "xyz")
        self.goals = np.full((context.graph.size, 3), np.nan)
        self.goals[:, self.axes] = context.option("goal", 0.0)

    @property
    def leads(self) -> frozenset[int]:
        """See `Metrics`."""
        return frozenset()

    def errors(self, flown: Flown) -> Array:
        """Return how far each drone is from the goal along the axes (m), shape (T, N)."""
        return np.where(flown.up, np.linalg.norm((flown.at - self.goals)[:, :, self.axes], axis=2), np.nan)

    def places(self, at: Array, wanted: Array) -> Array:
        """Return the goal, along other axes where drones are."""
        return np.where(np.isnan(self.goals), at, self.goals)

    @criterion("the largest excess of a difference between neighbors", "m")
    def coupling_error_m(self, flown: Flown) -> float:
        """Return by how much neighbors were ever farther apart than allowed in flight (m)."""
        i, j = np.array(self.pairs, int).reshape(-1, 2).T
        apart = np.abs((flown.at[:, i] - flown.at[:, j])[:, :, self.axes]).max(axis=2)
        errors = (apart - float(self.context.option("coupling", 2.0)))[self.fly_together(flown)]
        return max(0.0, float(np.max(errors))) if errors.size else math.nan


class MPCGuidance(VelocityFeedback):
    """Drones fly to a goal along some axes, with bounded speeds, and never farther apart than allowed.

    What is planned are single integrators, x(t + 1) = x(t) + period u(t), per axis: the reference of each drone, whose
    position at the next period is known, so that plans need no luck. Its controller holds the drone to it; `margin`
    is kept for what it does not hold.
    """

    needs = Needs(graph=True)
    metrics = TogetherMetrics
    node = replace(VelocityFeedback.node, positional=("sampling_period", *VelocityFeedback.node.positional))

    goal: Any = option(0.0, "where to fly along the axes, one number for all axes or one for each", "m", kind=object)
    axes: Any = option("x", "some of x, y, z: along the others drones stay where they were")
    sampling_period: float = option(1.0, "length of a period", "s", above=0)
    horizon: int = option(10, "periods that are looked ahead", low=1)
    state_cost: float = option(1.0, "cost per squared distance from the goal", above=0)
    input_cost: Any = option(1.0, "cost per squared speed; one number for all drones, or one for each", kind=object)
    largest_state: float = option(10.0, "largest coordinate", "m", above=0)
    largest_input: Any = option(
        0.5, "largest speed along each axis; one number for all drones, or one for each", "m/s", kind=object
    )
    coupling: float = option(2.0, "largest difference of coordinates between neighbors", "m", above=0)
    margin: float = option(0.1, "by which plans stay below it", "m", low=0)

    def __init__(self, agent_id: int, communicator: TopicCommunicator, **options: Any) -> None:
        """Prepare; arguments and errors are those of `RoundGuidance`."""
        super().__init__(agent_id, communicator, **options)
        who, axes = f"agent {agent_id}", self.axes
        self.axes = ["xyz".find(axis) for axis in axes]
        if not self.axes or -1 in self.axes or len(set(self.axes)) != len(self.axes):
            raise RangeError(f"{who}: axes are {axes!r}, allowed: some of x, y, z, each once")
        if self.margin >= self.coupling:
            raise RangeError(f"{who}: margin is {self.margin}, allowed: below the coupling, {self.coupling} m")
        m, goal = len(self.axes), np.asarray(self.goal, np.float64)
        if goal.size not in (1, m) or not np.isfinite(goal).all():
            raise RangeError(f"{who}: goal is {goal}, allowed: one finite number, or {m}")
        self.goal = np.broadcast_to(goal.reshape(-1), m)
        speed = _own(who, "largest_input", self.largest_input, communicator)
        self.moving.max_speed = max(options.get("max_speed", 0.0), 1.001 * math.sqrt(m) * speed)
        self.problem = self._made_problem(m, speed, _own(who, "input_cost", self.input_cost, communicator))
        self.plan: Plan | None = None
        """What it does in this period and later; states are relative to the goal."""
        self._next: Plan | None = None
        self._told: dict[str, Any] = {}
        self._count = 0  # of the period
        self._others: dict[int, tuple[int, Array]] = {}  # first period and states of their newest plans
        self.violations = 0
        """How many plans could not keep the coupling."""

    def _made_problem(self, m: int, speed: float, cost: float) -> MPCProblem:
        both = np.vstack([np.eye(m), -np.eye(m)])
        self._both = both
        return MPCProblem(
            np.eye(m),
            self.sampling_period * np.eye(m),
            self.state_cost * np.eye(m),
            cost * np.eye(m),
            self.horizon,
            E=both,
            f=np.concatenate([self.largest_state - self.goal, self.largest_state + self.goal]),
            G=both,
            h=np.full(2 * m, speed),
        )

    # ---------------------------------------------------------------- messages between neighbors

    def message(self) -> object:
        """Return the message to neighbors: the newest plan and the period that it begins with."""
        return self._told or {"period": -1, "states": np.zeros((0, len(self.axes)))}

    def receive_round(self, now: float) -> dict[int, Any]:
        """End the round and remember the plans that came."""
        data = self.end_round(now)
        for neighbor in self._neighbors:
            told = data[neighbor] if neighbor in data else self.communicator.latest(neighbor)
            plan = self._read(told)
            if neighbor in self.presence.lost:
                self._others.pop(neighbor, None)
            elif plan is not None:
                self._others[neighbor] = plan
        return {}

    def _read(self, told: object) -> tuple[int, Array] | None:
        """Return first period and states of a neighbor's message, if it is a plan."""
        if not isinstance(told, dict):
            return None
        first, states = told.get("period"), told.get("states")
        shape = (self.problem.horizon + 1, len(self.axes))
        if not isinstance(first, int) or not isinstance(states, np.ndarray) or states.shape != shape:
            return None
        return (first, states) if first >= 0 and np.isfinite(states).all() else None

    # ---------------------------------------------------------------- plans

    def begin_flight(self, now: float) -> None:
        """Stay for one period, in which all plan."""
        super().begin_flight(now)
        self.plan = self._next = None
        self._count = 0
        self._others.clear()
        state = self._state()
        rest = np.tile(state, (self.problem.horizon + 1, 1))
        self.plan = Plan(rest, np.zeros((self.problem.horizon, len(self.axes))))
        self._tell(0, rest)

    def _state(self) -> Array:
        return self.moving.position[self.axes] - self.goal  # type: ignore[index]

    def _tell(self, first: int, states: Array) -> None:
        self._told = {"period": first, "states": states + self.goal}

    def respond(self, neigh_data: dict[int, Any], now: float) -> Reference | None:
        """Return what a drone asks for."""
        if self._phase is not Phase.FLIGHT or self.is_leader or self.moving.position is None:
            return super().respond(neigh_data, now)
        self.previous_round = now
        self._go_on(now)
        plan = self.plan
        assert plan is not None
        # a part of the way of this period, and no sum of steps: references meet plans exactly
        part = min(1.0, (now - self._begin) / self.sampling_period - self._count)
        position = self.moving.position.copy()
        position[self.axes] = self.goal + plan.states[0] + part * (plan.states[1] - plan.states[0])
        self.moving.begin(position)
        return Reference(position=position, velocity=self.evaluate_input(neigh_data), acceleration=np.zeros(3))

    def _go_on(self, now: float) -> None:
        elapsed = now - self._begin + 1e-9
        count = int(elapsed / self.sampling_period)
        if count > self._count:
            # a plan is begun once its period comes, made or not
            self.plan = self._next if self._next is not None else self._rest_of(self.plan)
            for _ in range(count - self._count - 1):
                self.plan = self._rest_of(self.plan)
            self._count, self._next = count, None
        if self._next is None:
            spent = elapsed - count * self.sampling_period
            if spent >= _TURN * self.sampling_period or self._is_its_turn():
                self._make_plan()

    def _rest_of(self, plan: Plan | None) -> Plan:
        """Return a plan a period later."""
        assert plan is not None
        states = self.problem.shifted(plan.states)
        inputs = np.vstack([plan.inputs[1:], (states[-1] - states[-2]) / self.sampling_period])
        return Plan(states, inputs, plan.violation)

    def _is_its_turn(self) -> bool:
        """Return whether agents before it have planned the next period, and all have sent where they begin."""
        for neighbor in self._neighbors:
            if neighbor in self.presence.lost:
                continue
            first = self._others.get(neighbor, (-1, None))[0]
            if first < (self._count + 1 if neighbor < self.agent_id else self._count):
                return False
        return True

    def _make_plan(self) -> None:
        """Plan the next period from where it begins."""
        assert self.plan is not None
        begin, horizon, m = self.plan.states[1], self.problem.horizon, len(self.axes)
        limit = self.coupling - self.margin
        upper, lower = np.full((horizon, m), np.inf), np.full((horizon, m), np.inf)
        for first, states in self._others.values():
            ahead = self._ahead(first, states)
            upper = np.minimum(upper, ahead + limit)
            lower = np.minimum(lower, limit - ahead)
        plan = self.problem.solve(begin, self._both, np.hstack([upper, lower]))
        self.violations += plan.violation > 1e-6
        self._next = plan
        self._tell(self._count + 1, plan.states)

    def _ahead(self, first: int, states: Array) -> Array:
        """Return where another one will be, relative to the goal, one to T periods after the next begins: (T, m)."""
        states = states - self.goal
        for _ in range(min(self._count + 1 - first, self.problem.horizon)):
            states = self.problem.shifted(states)
        return states[1:]

    def evaluate_input(self, neigh_data: dict[int, Any]) -> Array:
        """Return the velocity (m/s, world), shape (3,): to where the period ends."""
        velocity = np.zeros(3)
        if self.plan is not None:
            velocity[self.axes] = self.plan.inputs[0]
        return velocity


def _own(who: str, name: str, value: ArrayLike, communicator: TopicCommunicator) -> float:
    """Return the number of one agent, out of one for all or one for each."""
    numbers = np.asarray(value, np.float64).reshape(-1)
    if numbers.size not in (1, communicator.size) or not (np.isfinite(numbers).all() and (numbers > 0.0).all()):
        raise RangeError(f"{who}: {name} is {value}, allowed: above 0, one number or {communicator.size}")
    return float(numbers[communicator.rank if numbers.size > 1 else 0])
