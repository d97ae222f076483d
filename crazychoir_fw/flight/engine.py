"""Fly a mission to its end: wait for the drones, fly the phases, and judge the result."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from crazychoir_fw.common.garbage import present_objects_frozen
from crazychoir_fw.flight.agents import make_agents, make_groups
from crazychoir_fw.flight.backend import Backend
from crazychoir_fw.flight.backends import make_backend
from crazychoir_fw.flight.experiment import Experiment
from crazychoir_fw.flight.flight_result import FlightResult, explained
from crazychoir_fw.flight.layers_flight import LayersFlight
from crazychoir_fw.flight.onboard_flight import OnboardFlight
from crazychoir_fw.flight.services import make_services
from crazychoir_fw.flight.streamed import Flushes, stream_flight
from crazychoir_fw.flight.summary import summarize
from crazychoir_fw.mission.schema import LayeredMission, Mission

if TYPE_CHECKING:
    from crazychoir_fw.recording.log_stream import LogStream
    from crazychoir_fw.simulation import World


@dataclass(frozen=True)
class Progress:
    """How far a flight has come."""

    sim_seconds: float
    total_seconds: float
    wall_seconds: float

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds per second."""
        return self.sim_seconds / self.wall_seconds if self.wall_seconds > 0 else 0.0


Observer = Callable[["World", Progress], None]


def fly(
    mission: Mission,
    threads: int | None = None,
    visuals: bool = True,
    observe: Observer | None = None,
    backend: Backend | None = None,
    make: Callable[..., Any] | None = None,
    stream: LogStream | None = None,
) -> FlightResult:
    """Fly a mission to its end, or until it has failed.

    Args:
        mission: What to fly.
        threads: Worker threads of a simulated world; None lets the world choose.
        visuals: Whether simulated drones can be seen in a window; the flight is the same.
        observe: Called with the world, if there is one, to show progress or to pace the flight: at every sample of the
            log, or about 25 times per second of a flight of layers.
        backend: Where the drones are, instead of what the mission says; it is closed at the end.
        make: Makes the layers of mission, backend and observer, instead of `make_experiment`.
        stream: Where the flight is written while it flies; the caller closes it.

    Raises:
        CrazychoirError: If backend or layers cannot be made as the mission says.
    """
    chosen: Any = make_backend(mission, threads, visuals) if backend is None else backend
    world, rounds, started = getattr(chosen, "world", None), 0, time.perf_counter()

    flushes: Flushes | None = None

    def show(_: Any) -> None:
        nonlocal rounds
        if flushes is not None:
            flushes.look()
        if observe is not None and rounds % flight.rounds_per_picture == 0:
            wall = time.perf_counter() - started
            observe(world, Progress(chosen.time - flight.began, flight.total_s, wall))  # type: ignore[arg-type]
        rounds += 1

    try:
        watch = None if observe is None and stream is None else show
        flight: Any
        if isinstance(mission, LayeredMission):
            flight = LayersFlight(mission, (make or make_experiment)(mission, chosen, watch))
        else:
            flight = OnboardFlight(mission, chosen, watch)
        about = {"mission": mission.name, "description": mission.description}
        if stream is not None:
            flushes = stream_flight(stream, chosen, flight, {**about, "backend": mission.backend, "seed": mission.seed})
        started, begin = time.perf_counter(), chosen.time
        with present_objects_frozen():
            flight.fly()
        seconds, flown = time.perf_counter() - started, chosen.time - begin
        log = flight.log(about)
        assessment = flight.assess(log)
        summary = summarize(mission, chosen, log, assessment, flown, seconds)
        result = FlightResult(mission, world, log, summary, assessment.judge)
        log.metadata |= explained(result)
        return result
    finally:
        if flushes is not None:
            flushes.write()  # before drones in the air are landed, which takes its time
        chosen.close()


def make_experiment(
    mission: LayeredMission, backend: Backend | None = None, observe: Callable[[Experiment], None] | None = None
) -> Experiment:
    """Return the layers of a mission on a backend, for a Python script that commands the flight itself.

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
