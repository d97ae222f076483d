"""Fly a mission with layers: its backend, its buttons one after the other, and what came of it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass
from dataclasses import replace as replaced
from functools import partial
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from crazychoir_fw.core import identity
from crazychoir_fw.errors import CrazychoirError, MissionError
from crazychoir_fw.experiment.agents import (
    graph_of,
    guidance_of,
    leads,
    make_agents,
    make_groups,
    masses_of,
    names_of,
    starts_of,
)
from crazychoir_fw.experiment.backend import Backend
from crazychoir_fw.experiment.communicators import statistics_of
from crazychoir_fw.experiment.criteria import Judge, Window
from crazychoir_fw.experiment.experiment import Experiment
from crazychoir_fw.experiment.odometry import through_mocap
from crazychoir_fw.experiment.services import make_services
from crazychoir_fw.experiment.shapes import shape_of
from crazychoir_fw.experiment.surveillance import surveillance_of
from crazychoir_fw.messages import TrajectoryPoint
from crazychoir_fw.mission.distance_curve import distance_curve
from crazychoir_fw.mission.fleet import drone_settings
from crazychoir_fw.mission.runner import Film, FlightResult, Observer, Progress, build_world, turn_on_radios
from crazychoir_fw.mission.schema import LayeredMission
from crazychoir_fw.mission.story import story_of
from crazychoir_fw.mission.summary import collision_failures
from crazychoir_fw.report.error_curve import ErrorCurve
from crazychoir_fw.report.marks import Story

if TYPE_CHECKING:
    from crazychoir_fw.experiment.integrator_backend import IntegratorBackend
    from crazychoir_fw.experiment.sim_backend import SimBackend
    from crazychoir_fw.report.flight_log import FlightLog
    from crazychoir_fw.simulation import World
    from crazychoir_fw.simulation.mirrored import MirroredConfig

READY_TIMEOUT = 10.0
"""Longest time until all drones are ready to fly (s, simulated)."""

LONGEST_FILM_S = 12.0
"""A film of a longer flight is played faster (s)."""

LATE_S = 6.0
"""So much longer than its button a landing may take (s)."""

SETTLE_S = 1.0
"""Time after the last button (s)."""


@dataclass(frozen=True)
class LayeredResult(FlightResult):
    """A flight of layers that is over."""

    judge: Judge
    """Figures of the flight."""
    no_film: str | None = None
    """Why there is nothing to be filmed."""

    @property
    def curve(self) -> ErrorCurve | None:
        """Errors of formation or defenders, or distances that a filter keeps, over time, for the picture."""
        if self.judge.surveillance is not None:
            return self._surveillance_curve
        label, limit = "bearing error (deg)", self.mission.criteria.bearing_error_deg  # type: ignore[attr-defined]
        errors = self.judge.bearing_errors()
        if errors is None:
            errors = self.judge.formation_errors()
            is_distance = errors is not None and self.judge.formation.kind == "distance"  # type: ignore[union-attr]
            label = "error of distances (m)" if is_distance else "distance from its place (m)"
            criteria = self.mission.criteria  # type: ignore[attr-defined]
            limit = criteria.distance_error_m if is_distance else criteria.position_error_m
        if errors is None or np.isnan(errors).all():
            return None if self.story is not None else distance_curve(self.mission, self.judge)  # type: ignore[arg-type]
        flies = ~np.isnan(errors).all(axis=1)
        mean, largest = np.full(len(errors), np.nan), np.full(len(errors), np.nan)
        mean[flies], largest[flies] = np.nanmean(errors[flies], axis=1), np.nanmax(errors[flies], axis=1)
        pairs = list(self.judge.formation.graph.pairs)  # type: ignore[union-attr]
        end = self.judge.final_positions
        return ErrorCurve(label, mean, largest, limit, self.judge.places(), end, pairs)

    @property
    def _surveillance_curve(self) -> ErrorCurve | None:
        judge, criteria = self.judge, self.mission.criteria  # type: ignore[attr-defined]
        errors = judge.surveillance_errors()
        flies = ~np.isnan(errors).any(axis=1)
        if not flies.any():
            return None
        mean, largest = np.full(len(errors), np.nan), np.full(len(errors), np.nan)
        mean[flies], largest[flies] = np.mean(errors[flies], axis=1), np.max(errors[flies], axis=1)
        end, label = judge.final_positions, "distance from optimum (m)"
        places = None
        if end is not None:
            places = np.full_like(end, np.nan)
            places[list(judge.surveillance.defenders), :2] = judge.surveillance.places(end)
        return ErrorCurve(
            label, mean, largest, criteria.surveillance_error_m, places, markers=judge.surveillance.markers(end)
        )

    @property
    def story(self) -> Story | None:
        """Tasks or deliveries, for the picture and the film."""
        return story_of(self.log.events, self.log.drone_ids, float(self.log.time[-1]))

    @property
    def film_model(self) -> Any:
        """The model that the film is made with: drones of an integrator are drawn where they were."""
        from crazychoir_fw.simulation import DroneConfig
        from crazychoir_fw.simulation.builder import build_model

        if self.world is not None:
            model = copy(self.world.model)
        else:
            drones = [DroneConfig(**drone_settings(drone)) for drone in self.mission.fleet]
            model = build_model(drones, self.mission.scene, self.mission.seed, True)
        formation, surveillance = self.judge.formation, self.judge.surveillance
        if surveillance is not None:
            for i, drone in enumerate(self.mission.fleet):
                _paint(model, drone.id, _FOLLOWER if i in surveillance.defenders else _LEADER)
        if formation is not None:
            mirrored = self.world.mirrored if self.world is not None else {}
            for i, drone in enumerate(self.mission.fleet):
                if drone.id in mirrored:
                    continue  # it keeps the color of real drones
                _paint(model, drone.id, _LEADER if i in formation.leaders else _FOLLOWER)
        elif self.story is not None:
            from matplotlib.colors import to_rgb

            from crazychoir_fw.report.plot import palette

            for drone, color in zip(self.mission.fleet, palette(len(self.mission.fleet)), strict=True):
                _paint(model, drone.id, to_rgb(color))
        return model


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


_LEADER, _FOLLOWER = (0.85, 0.1, 0.1), (0.1, 0.4, 0.85)


def _paint(model: Any, drone: str, color: tuple[float, float, float]) -> None:
    """Give the colored part of a drone another color."""
    geom = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, f"{drone}/accent")
    if geom >= 0:
        model.geom_rgba[geom, :3] = color
        model.geom_matid[geom] = -1


# -------------------------------------------------------------------------------- backends


def make_backend(mission: LayeredMission, threads: int | None = None, visuals: bool = False) -> Backend:
    """Return the backend of a mission, its drones ready to fly.

    Raises:
        CrazychoirError: If it cannot be made as the mission says.
    """
    if mission.backend == "hardware":
        from crazychoir_fw.mission.real_drones import over_the_radio

        return over_the_radio(mission)
    if mission.backend == "mixed":
        from crazychoir_fw.mission.real_drones import mixed_reality

        return mixed_reality(mission, partial(_sim, mission, threads, visuals))
    return {"sim": _sim, "integrator": _integrator}[mission.backend](mission, threads, visuals)


def _sim(
    mission: LayeredMission, threads: int | None, visuals: bool, mirrored: Sequence[MirroredConfig] = ()
) -> SimBackend:
    """Return the simulated drones of a mission: those that are not mirrored."""
    from crazychoir_fw.experiment.sim_backend import SimBackend, truth

    world = build_world(mission, threads, visuals, mirrored)
    radio = turn_on_radios(mission, world)
    world.wait_until_ready(timeout_s=READY_TIMEOUT)
    for number, entry in enumerate(mission.faults):
        try:
            world.add_fault(replaced(entry.fault, at=round(entry.fault.at + world.time, 6)))
        except CrazychoirError as error:
            raise MissionError(f"faults[{number}].{entry.name}: {error}") from None
    odometry = mission.layers.odometry
    backend = SimBackend(world, "estimate" if odometry == "estimate" else "truth", mission.log_rate)
    if odometry == "mocap":
        backend.read_poses = through_mocap(truth(world), mission.seed)
    backend.radio = radio
    return backend


def _integrator(mission: LayeredMission, threads: int | None, visuals: bool) -> IntegratorBackend:
    from crazychoir_fw.experiment.integrator_backend import IntegratorBackend
    from crazychoir_fw.integrator import RandomForce

    settings = mission.integrator
    disturbance = None
    if settings.disturbance is not None:
        given = settings.disturbance
        disturbance = RandomForce(given.sigma, given.time_constant, mission.seed)
    platforms = {drone.platform for drone in mission.fleet}
    if len(platforms) > 1:
        raise MissionError(
            f"backend integrator flies one platform at a time, but there are {', '.join(sorted(platforms))}"
        )
    backend = IntegratorBackend(
        names_of(mission),
        starts_of(mission),
        yaw=np.radians([drone.yaw_deg for drone in mission.fleet]),
        mass=masses_of(mission),
        platform=platforms.pop(),
        drag=settings.drag,
        disturbance=disturbance,
    )
    if mission.layers.odometry == "mocap":
        backend.read_poses = through_mocap(backend.read_poses, mission.seed)
    return backend


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
        formation = shape_of(mission)
        judge = Judge(log, self._windows, formation)
        judge.surveillance = surveillance_of(mission)
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
            if judge.surveillance is not None:
                film.markers = [marker for marker in judge.surveillance.markers(None) if not marker.moves]
                film.links = list(graph_of(mission).pairs)
            film.drones = names if hasattr(self._backend, "mirror") else None
            if formation is not None:
                film.links = list(formation.graph.pairs)
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
        bearings = judge.final_bearing_errors()
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
            "bearing_error_deg": None if bearings is None else _rounded(np.mean(bearings) if len(bearings) else np.nan),
            "bearing_error_max_deg": None
            if bearings is None
            else _rounded(np.max(bearings) if len(bearings) else np.nan),
            "drones": drones,
            "events": [happening.as_dict() for happening in experiment.happenings],
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
        talk = statistics_of(experiment.agents)
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
