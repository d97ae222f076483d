"""The mission that the page was opened with, phase after phase, as `crazychoir fly` flies it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from crazychoir_fw.common.checkpoint import Stateful
from crazychoir_fw.common.errors import CrazychoirError, StateError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.flight.agents import guidance_class
from crazychoir_fw.flight.layers_flight import press_phase
from crazychoir_fw.flight.start_transit import StartTransit
from crazychoir_fw.mission.phases import LayeredPhase
from crazychoir_fw.mission.plan import Command, plan_flight

if TYPE_CHECKING:
    from crazychoir_fw.flight.access import Access
    from crazychoir_fw.flight.experiment import Experiment
    from crazychoir_fw.mission.schema import LayeredMission

_LATE_S = 0.5  # a phase that took longer to begin, as arming real drones does, delays those after it


@dataclass(frozen=True)
class Step:
    """One order of the mission."""

    name: str
    """Of the phase, or of the command."""
    wait_s: float
    """Time until the next step (s)."""
    order: Any
    """A `LayeredPhase`, or a `Command` of a mission without layers."""


class MissionRun(Stateful):
    """The phases of a mission on their way; the session asks a `Flying` the same."""

    unkept = ("_access", "_steps", "_mission")

    def __init__(self, experiment: Experiment, access: Access, mission: LayeredMission) -> None:
        """Begin with the next `step`.

        Raises:
            StateError: If the mission cannot be flown now.
        """
        if reason := cannot_run(mission, access):
            raise StateError(reason)
        for agent in experiment.agents:
            if agent.is_up:
                raise StateError(f"MISSION: {agent.name} flies already; LAND first")
        self.name = mission.name
        self.phases: list[str] = ["begins"]
        """What has been flown so far, the present phase last."""
        self.started: float | None = None
        """When its first phase began (s)."""
        self.problems: list[str] = []
        """What could not be ordered, sentences that the console has not shown yet."""
        self._experiment = experiment
        self._access = access
        self._mission = mission
        self._steps = steps_of(mission)
        if isinstance(self._steps[0].order, Command):
            access.upload_plan(plan_flight(mission).uploads)
        self.duration = sum(step.wait_s for step in self._steps)
        self._next = 0
        self._due = 0.0  # of the next step (s)
        self._left_out: set[int] = set()
        self._transits: list[StartTransit] = []

    @property
    def phase(self) -> str:
        """What is flown at present."""
        return self.phases[-1]

    def without(self, drones: Sequence[int]) -> None:
        """Leave out drones that another button was pressed for."""
        self._left_out |= set(drones)
        for transit in self._transits:
            transit.without(drones)

    @property
    def is_over(self) -> bool:
        """Whether the last phase has ended, or all drones were left out or failed."""
        lost = {agent.index for agent in self._experiment.agents if agent.failure is not None}
        return self.phase == "done" or len(self._left_out | lost) == len(self._experiment.agents)

    def step(self, now: float) -> None:
        """Give the orders whose time has come."""
        if self.started is None:
            self.started = self._due = now
        for transit in self._transits:
            transit.step(now)
            self.problems += transit.problems
        self._transits = [transit for transit in self._transits if not transit.is_over]
        while not self.is_over and not self._transits and now >= self._due - 1e-9:
            if self._next == len(self._steps):
                self.phases.append("done")
                return
            step = self._steps[self._next]
            self._next += 1
            if step.name != self.phase:
                self.phases.append(step.name)
            self._guarded(self._command if isinstance(step.order, Command) else self._press, step.order)
            now = self._experiment.time
            self._due = (now if now - self._due > _LATE_S else self._due) + step.wait_s

    def _guarded(self, give: Callable[[Any], None], order: Any) -> None:
        try:
            give(order)
        except CrazychoirError as error:
            self.problems.append(f"MISSION: {error}")

    def _press(self, phase: LayeredPhase) -> None:
        for order in phase.orders:
            self._guarded(self._press_one, order)

    def _press_one(self, order: LayeredPhase) -> None:
        experiment = self._experiment
        wanted = getattr(order.maneuver, "drones", None) or [agent.name for agent in experiment.agents]
        chosen = [
            agent.name for agent in experiment.agents if agent.name in wanted and agent.index not in self._left_out
        ]
        transit = press_phase(experiment, self._mission, order.name, order.maneuver, chosen) if chosen else None
        if transit is not None:
            self._transits.append(transit)

    def _command(self, command: Command) -> None:
        """Give a command of a mission without layers; take-off and landing are the buttons of its drone."""
        agent, given = self._experiment.agents[command.drone], command.arguments
        if agent.index in self._left_out or agent.failure is not None:
            return
        if command.verb in ("takeoff", "land"):
            agent.guidance.takeoff_time = given["duration_s"]
            if command.verb == "takeoff":
                agent.guidance.height = given["absolute_height_m"]
            getattr(self._experiment, command.verb)([agent.name])
        elif agent.is_up and command.verb != "arm":  # TAKE-OFF arms
            agent.reference = None  # what the planner on board says is shown
            self._access.command(command.drone, command.verb, given)


def steps_of(mission: LayeredMission) -> list[Step]:
    """Return the orders of a mission, in turn."""
    if not mission.flight or isinstance(mission.flight[0], LayeredPhase):
        return [
            Step(", ".join(dict.fromkeys(order.name for order in phase.orders)), phase.duration, phase)
            for phase in mission.flight
        ]
    plan = plan_flight(mission)
    ends = [command.tick for command in plan.commands[1:]] + [plan.ticks]
    return [
        Step(command.verb, (end - command.tick) / TICKS_PER_SECOND, command)
        for command, end in zip(plan.commands, ends, strict=True)
    ]


def cannot_run(mission: LayeredMission, access: Access) -> str | None:
    """Return why the page cannot fly its mission, a sentence, or None."""
    if not isinstance(mission.flight[0], LayeredPhase) and not access.flies_plans:
        return f"MISSION: the phases of {mission.name} are for planners on board of simulated drones"
    return None


def starts_something(mission: LayeredMission) -> bool:
    """Return whether START means something: some law begins a flight of its own then."""
    return any(getattr(guidance_class(mission, i), "has_start", lambda: True)() for i in range(len(mission.fleet)))
