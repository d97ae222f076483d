"""Fly a mission with layers: its buttons one after the other, and what is told about it afterwards."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from crazychoir_fw.common.messages import TrajectoryPoint
from crazychoir_fw.flight.agents import (
    guidance_of,
    leads,
    make_agents,
    make_groups,
    metrics_of,
    names_of,
)
from crazychoir_fw.flight.backend import Backend
from crazychoir_fw.flight.backends import make_backend
from crazychoir_fw.flight.criteria import Judge, Window
from crazychoir_fw.flight.experiment import Experiment
from crazychoir_fw.flight.layered_result import LayeredResult
from crazychoir_fw.flight.runner import Film, Observer, Progress
from crazychoir_fw.flight.services import make_services
from crazychoir_fw.flight.summary import collision_failures
from crazychoir_fw.mission.schema import LayeredMission
from crazychoir_fw.onboard.core import identity

if TYPE_CHECKING:
    from crazychoir_fw.recording.flight_log import FlightLog
    from crazychoir_fw.simulation import World

LONGEST_FILM_S = 12.0
"""A film of a longer flight is played faster (s)."""

LATE_S = 6.0
"""So much longer than its button a landing may take (s)."""

SETTLE_S = 1.0
"""Time after the last button (s)."""


def fly_layers(
    mission: LayeredMission,
    threads: int | None = None,
    visuals: bool = True,
    frames_per_second: int = 0,
    observe: Observer | None = None,
    backend: Backend | None = None,
    make: Callable[..., Experiment] | None = None,
) -> LayeredResult:
    """Fly a mission with layers to its end, or until no drone flies any more.

    Args:
        mission: What to fly.
        threads: Worker threads of a simulated world; None lets the world choose.
        visuals: Whether simulated drones can be seen, in a film or a window.
        frames_per_second: Rate of the video; 0 makes none.
        observe: Called about 25 times per second of flight.
        backend: Where the drones are, instead of what the mission says; it is closed at the end.
        make: Makes the experiment of mission, backend and observer, instead of `make_experiment`.

    Raises:
        CrazychoirError: If layers or backend cannot be made as the mission says.
    """
    wall_start = time.perf_counter()
    if backend is None:
        backend = make_backend(mission, threads, visuals)
    try:
        return _Flight(mission, backend, frames_per_second, observe, wall_start, make or make_experiment).run()
    finally:
        backend.close()


def make_experiment(
    mission: LayeredMission, backend: Backend | None = None, observe: Callable[[Experiment], None] | None = None
) -> Experiment:
    """Return the layers of a mission on a backend, for those who press the buttons from Python.

    Args:
        mission: The mission; its `flight` is not flown.
        backend: Where the drones are; None is what the mission says.
        observe: Called after every round.

    Raises:
        CrazychoirError: If layers or backend cannot be made as the mission says.
    """
    chosen = make_backend(mission) if backend is None else backend
    agents = make_agents(mission, lambda: chosen.time, chosen.true_positions)
    groups = make_groups(mission, list(chosen.masses), getattr(chosen, "true_poses", None))
    services = make_services(mission, agents)
    return Experiment(chosen, agents, groups, mission.layers.rate, mission.log_rate, observe, services)


# -------------------------------------------------------------------------------- one flight


class _Flight:
    """One flight while it runs."""

    def __init__(
        self,
        mission: LayeredMission,
        backend: Backend,
        frames_per_second: int,
        observe: Observer | None,
        wall_start: float,
        make: Callable[..., Experiment],
    ) -> None:
        self._mission = mission
        self._backend = backend
        self._fps = frames_per_second
        self._observe = observe
        self._wall_start = wall_start
        self._world: World | None = getattr(backend, "world", None)
        self._windows: list[Window] = []
        self._experiment = make(mission, backend, self._show if observe is not None else None)
        self._rounds = 0
        self._begin = backend.time
        self._total = sum(phase.button.duration for phase in mission.flight)

    def run(self) -> LayeredResult:
        """Fly to the end and return the result."""
        experiment = self._experiment
        flown = time.perf_counter()
        self._begin = self._backend.time
        if self._observe is not None:
            self._show(experiment)
        is_down = False
        for phase in self._mission.flight:
            begin = experiment.time
            self._press(phase)
            if not is_down:
                experiment.run(phase.button.duration)
            self._windows.append(Window(phase.name, begin, experiment.time))
            # when all drones failed there is nothing left to see
            is_down = all(agent.failure is not None for agent in experiment.agents)
        if self._mission.flight[-1].name == "land":
            experiment.run_until_landed(LATE_S)
        experiment.run(SETTLE_S)
        seconds = time.perf_counter() - flown
        return self._result(seconds)

    def _press(self, phase: Any) -> None:
        experiment, button = self._experiment, phase.button
        who = getattr(button, "drones", None)
        if phase.name in ("takeoff", "start", "land", "stop"):
            getattr(experiment, phase.name)(who)
        elif phase.name == "trajectory":
            points = [TrajectoryPoint(time, np.array(at)) for time, *at in button.rows]
            experiment.set_trajectory(points, who)
        elif phase.name == "go_to":
            experiment.set_trajectory([TrajectoryPoint(button.duration, np.array(button.position))], who)

    def _show(self, experiment: Experiment) -> None:
        if self._rounds % max(1, self._mission.layers.rate // 25) == 0:
            wall = time.perf_counter() - self._wall_start
            self._observe(self._world, Progress(experiment.time - self._begin, self._total, wall))  # type: ignore[misc, arg-type]
        self._rounds += 1

    def _result(self, seconds: float) -> LayeredResult:
        mission, experiment = self._mission, self._experiment
        names = names_of(mission)
        about = {
            "mission": mission.name,
            "description": mission.description,
            "backend": mission.backend,
            "seed": mission.seed,
            "windows": [[window.name, window.begin, window.end] for window in self._windows],
            "platform": ", ".join(sorted({drone.platform for drone in mission.fleet})),
        }
        log = experiment.log(about)
        judge = Judge(log, self._windows, metrics_of(mission))
        verdicts = judge.verdicts(mission.criteria, names, mission.may_fail)

        failures, expected = [], []
        for agent in experiment.agents:
            if agent.failure is not None:
                (expected if agent.name in mission.may_fail else failures).append(agent.failure)
        failures += experiment.service_failures
        if self._world is not None:
            for name, sentence in collision_failures(mission, self._world.events):
                (expected if name in mission.may_fail else failures).append(sentence)
        failures += [verdict.sentence for verdict in verdicts if not verdict.passed]
        summary = self._summary(log, judge, verdicts, failures, expected, seconds)
        film, no_film = Film(self._fps), None
        if not hasattr(self._backend, "film"):
            no_film = f"nobody films the backend {mission.backend}"
        elif self._fps:
            qpos, times = self._backend.film
            is_new = np.diff(times, prepend=-np.inf) > 0.0
            flown = float(times[-1] - times[0])
            film = Film(
                self._fps, list(times[is_new]), list(qpos[is_new]), max(1.0, float(np.ceil(flown / LONGEST_FILM_S)))
            )
            film.marks = [mark for one in judge.metrics for mark in one.marks(None)]
            film.links = [pair for one in judge.metrics for pair in one.pairs]
            film.drones = names if hasattr(self._backend, "mirror") else None
        return LayeredResult(mission, self._world, log, film, summary, judge, no_film)  # type: ignore[arg-type]

    def _summary(
        self,
        log: FlightLog,
        judge: Judge,
        verdicts: list[Any],
        failures: list[str],
        expected: list[str],
        seconds: float,
    ) -> dict[str, Any]:
        mission, experiment = self._mission, self._experiment
        rms, largest = judge.tracking()
        figures = {
            "position_error_m": judge.position_errors(),
            "rms_error_m": rms,
            "max_error_m": largest,
            "least_distance_m": judge.least_distances(),
        }
        drones = [
            {
                "id": agent.name,
                "role": _role(mission, agent.index),
                **{key: _rounded(values[agent.index]) for key, values in figures.items()},
                "phase": agent.phase.value,
            }
            for agent in experiment.agents
        ]
        figures_of_laws = {"bearing_error_deg": None, "bearing_error_max_deg": None, **judge.figures_of_laws()}
        flown = experiment.time - self._begin
        world = self._world
        summary = {
            "mission": mission.name,
            "backend": mission.backend,
            "platform": log.metadata["platform"],
            "seed": mission.seed,
            "success": not failures,
            "failures": failures,
            "sim_seconds": _rounded(flown),
            "wall_seconds": _rounded(seconds),
            "real_time_factor": _rounded(flown / seconds if seconds > 0.0 else np.nan),
            "criteria": [verdict.as_dict() for verdict in verdicts],
            **{key: None if value is None else _rounded(value) for key, value in figures_of_laws.items()},
            "drones": drones,
            "events": [happening.as_dict() for happening in experiment.events],
            "collisions": [
                {"time": _rounded(event.time), "drone": event.drone, **event.details}
                for event in (world.events if world is not None else ())
                if event.kind == "collision"
            ],
            "shares": {name: _rounded(value) for name, value in experiment.shares.items()},
            "build": identity(),
            "expected_failures": expected,
            "faults": log.metadata.get("faults", []),
        }
        talk = experiment.communication()
        if talk is not None:
            summary["communication"] = talk
        mirror = getattr(self._backend, "mirror", None)
        if mirror is not None:
            summary["mirrored"] = mirror.report()
            summary["behind_s"] = _rounded(self._backend.behind_s)  # type: ignore[attr-defined]
        radio = getattr(self._backend, "radio", None)
        if radio is not None:
            summary["link"] = radio.link.statistics()
        return summary


def _role(mission: LayeredMission, i: int) -> str:
    layer = guidance_of(mission, i)
    if layer.formation is None and not layer.leaders:
        return "-"
    return "leader" if leads(mission, i) else "follower"


def _rounded(value: Any, digits: int = 4) -> float | None:
    return round(float(value), digits) if np.isfinite(value) else None
