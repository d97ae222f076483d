"""A flight of layers: the phases of a mission are buttons, and what came of it is judged by its criteria."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from crazychoir_fw.common.errors import StateError
from crazychoir_fw.common.messages import TrajectoryPoint
from crazychoir_fw.flight.agents import guidance_of, leads, metrics_of, names_of
from crazychoir_fw.flight.criteria import Judge, Window
from crazychoir_fw.flight.experiment import Experiment
from crazychoir_fw.flight.start_transit import StartTransit
from crazychoir_fw.flight.summary import Assessment, collision_failures, rounded
from crazychoir_fw.mission.phases import LayeredPhase
from crazychoir_fw.mission.schema import LayeredMission

if TYPE_CHECKING:
    from crazychoir_fw.recording.flight_log import FlightLog

_PICTURES_HZ = 25
_LATE_S = 6.0  # so much longer than its phase a landing may take
_LONGEST_DESCENT_S = 30.0  # of drones whose layers have failed
_SETTLE_S = 1.0  # after the last phase


class LayersFlight:
    """One flight while it runs; the engine asks an `OnboardFlight` the same."""

    def __init__(self, mission: LayeredMission, experiment: Experiment) -> None:
        """Take what flies.

        Args:
            mission: What to fly.
            experiment: Its layers on its backend.
        """
        self.backend = experiment.backend
        self.rounds_per_picture = max(1, mission.layers.rate // _PICTURES_HZ)
        self.total_s = sum(phase.duration for phase in mission.flight)
        self.began: float | None = None
        """When the phases began (s)."""
        self._mission = mission
        self._experiment = experiment
        self._windows: list[Window] = []
        self._problems: list[str] = []

    @property
    def events(self) -> list[Any]:
        """What happened so far beside the events of the world."""
        return self._experiment.events

    def fly(self) -> None:
        """Fly the phases one after the other, or until no drone flies any more.

        Raises:
            StateError: If drones over the radio are not those that the mission means, or not where it says.
        """
        experiment, is_down = self._experiment, False
        if hasattr(self.backend, "before_flight"):  # drones over the radio
            self.backend.before_flight()
        self.began = self.backend.time
        if experiment.observe is not None:
            experiment.observe(experiment)
        for phase in self._mission.flight:
            begin = experiment.time
            self._fly_phase(phase, is_down)
            self._windows += [
                Window(order.name, begin, min(begin + order.maneuver.duration, experiment.time))
                if phase.together
                else Window(order.name, begin, experiment.time)
                for order in phase.orders
            ]
            # when all drones failed there is nothing left to see
            is_down = all(agent.failure is not None for agent in experiment.agents)
        if "land" in [order.name for order in self._mission.flight[-1].orders]:
            experiment.run_until_landed(_LATE_S)
        experiment.run_until_landed(_LONGEST_DESCENT_S, all_drones=False)
        experiment.run(_SETTLE_S)

    def _fly_phase(self, phase: LayeredPhase, is_down: bool) -> None:
        """Press its buttons, and fly for its time, or until drones that it sends away have arrived."""
        experiment, transits = self._experiment, []
        for order in phase.orders:
            try:
                drones = getattr(order.maneuver, "drones", None)
                transits.append(press_phase(experiment, self._mission, order.name, order.maneuver, drones))
            except StateError as error:
                self._problems.append(str(error))
        if is_down:
            return
        left = [transit for transit in transits if transit is not None]
        if not left:
            experiment.run(phase.duration)
            return
        end = experiment.time + phase.duration
        while left:
            for transit in left:
                transit.step(experiment.time)
                self._problems += transit.problems
            left = [transit for transit in left if not transit.is_over]
            experiment.step()
        experiment.run(max(0.0, end - experiment.time))

    def log(self, about: dict[str, Any]) -> FlightLog:
        """Return the log of the flight.

        Args:
            about: What it says about the flight beside what is known here.
        """
        mission, faults = self._mission, getattr(self.backend, "faults", [])
        known = {
            "backend": mission.backend,
            "seed": mission.seed,
            "windows": [[window.name, window.begin, window.end] for window in self._windows],
            "platform": ", ".join(sorted({drone.platform for drone in mission.fleet})),
        }
        return self._experiment.log({**about, **known, **({"faults": faults} if faults else {})})

    def assess(self, log: FlightLog) -> Assessment:
        """Return what the flight came down to."""
        mission, experiment = self._mission, self._experiment
        judge = Judge(log, self._windows, metrics_of(mission))
        verdicts = judge.verdicts(mission.criteria, names_of(mission), mission.may_fail)
        failures: list[str] = []
        expected: list[str] = []
        for agent in experiment.agents:
            if agent.failure is not None:
                (expected if agent.name in mission.may_fail else failures).append(agent.failure)
        failures += experiment.service_failures + self._problems
        world = getattr(self.backend, "world", None)
        for name, sentence in collision_failures(mission, () if world is None else world.events):
            (expected if name in mission.may_fail else failures).append(sentence)
        failures += [verdict.sentence for verdict in verdicts if not verdict.passed]
        return Assessment(
            drones=_drones(mission, experiment, judge),
            failures=failures,
            expected=expected,
            shares=experiment.shares,
            criteria=verdicts,
            swarm=_swarm(judge),
            events=experiment.events,
            communication=experiment.communication(),
            judge=judge,
        )


def press_phase(
    experiment: Experiment, mission: LayeredMission, name: str, maneuver: Any, drones: list[str] | None
) -> StartTransit | None:
    """Press the button of a phase for some drones, None for all, or hand over its points.

    Returns:
        What takes drones to their starts, and wants a `step` after each round.

    Raises:
        StateError: If they cannot go there.
    """
    if name == "go_to_start":
        return StartTransit(experiment, mission, drones)
    if name == "trajectory":
        points = [TrajectoryPoint(time, np.array(at)) for time, *at in maneuver.rows]
        experiment.set_trajectory(points, drones)
    elif name == "go_to":
        point = TrajectoryPoint(maneuver.duration, np.array(maneuver.position))
        for drone in [agent.name for agent in experiment.agents] if drones is None else drones:
            experiment.send_to(point, drone)
    elif name != "hover":
        getattr(experiment, name)(drones)
    return None


def _drones(mission: LayeredMission, experiment: Experiment, judge: Judge) -> list[dict[str, Any]]:
    rms, largest = judge.tracking()
    figures = {
        "position_error_m": judge.position_errors(),
        "rms_error_m": rms,
        "max_error_m": largest,
        "least_distance_m": judge.least_distances(),
    }
    return [
        {
            "role": _role(mission, agent.index),
            **{key: rounded(values[agent.index]) for key, values in figures.items()},
            "phase": agent.phase.value,
        }
        for agent in experiment.agents
    ]


def _swarm(judge: Judge) -> dict[str, Any]:
    figures = {"bearing_error_deg": None, "bearing_error_max_deg": None, **judge.figures_of_laws()}
    return {key: None if value is None else rounded(value) for key, value in figures.items()}


def _role(mission: LayeredMission, i: int) -> str:
    layer = guidance_of(mission, i)
    if layer.formation is None and not layer.leaders:
        return "-"
    return "leader" if leads(mission, i) else "follower"
