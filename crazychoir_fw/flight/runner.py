"""Fly a mission: build its world, send its commands at their ticks, record, and judge the result."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import CrazychoirError, MissionError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.flight.links import simulated_radios
from crazychoir_fw.flight.summary import collision_failures, judge, summarize
from crazychoir_fw.mission.fleet import drone_settings
from crazychoir_fw.mission.plan import Command, FlightPlan, plan_flight
from crazychoir_fw.mission.schema import Mission

if TYPE_CHECKING:
    from crazychoir_fw.crtp.link_model.flight_radio import FlightRadio
    from crazychoir_fw.recording.flight_log import FlightLog
    from crazychoir_fw.recording.marks import Mark
    from crazychoir_fw.simulation import FlightRecorder, World
    from crazychoir_fw.simulation.mirrored import MirroredConfig

LOG_RATE = 100
"""Rate of the log (Hz)."""

SUPERVISOR_TICKS = 40
"""Ticks between two looks at the supervisors: as often as they look at their drones."""

READY_TIMEOUT = 10.0
"""Longest time until all drones are ready to fly (s, simulated)."""


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


@dataclass
class Film:
    """What a video of the flight is rendered from."""

    fps: int
    times: list[float] = field(default_factory=list)  # [s], world time
    qpos: list[NDArray[np.float64]] = field(default_factory=list)  # each (nq,)
    speed: float = 1.0
    """Seconds of flight per second of film."""
    links: list[tuple[int, int]] = field(default_factory=list)
    """Drones that talk to each other."""
    marks: "list[Mark]" = field(default_factory=list)
    """Points that are shown."""

    drones: list[str] | None = None
    """Which bodies are drones, where not all of them are simulated."""


@dataclass(frozen=True)
class FlightResult:
    """A flight that is over."""

    mission: Mission
    world: "World"
    log: "FlightLog"
    film: Film
    summary: dict[str, Any]

    @property
    def film_model(self) -> Any:
        """The model that the film is made with."""
        return self.world.model

    @property
    def success(self) -> bool:
        """Whether every drone did what it was told."""
        return self.summary["success"]

    @property
    def failures(self) -> list[str]:
        """What went wrong, one sentence each."""
        return self.summary["failures"]

    @property
    def expected_failures(self) -> list[str]:
        """What went wrong with drones that may fail, one sentence each."""
        return self.summary["expected_failures"]


Observer = Callable[["World", Progress], None]


def fly(
    mission: Mission,
    threads: int | None = None,
    visuals: bool = True,
    frames_per_second: int = 0,
    observe: Observer | None = None,
) -> FlightResult:
    """Fly a mission from the floor to its last phase, or until a drone fails.

    Args:
        mission: What to fly.
        threads: Worker threads of the world; None lets the world choose.
        visuals: Whether the drones can be seen, in a film or a window; the flight is the same.
        frames_per_second: Rate of the frames kept for a video (Hz, simulated); 0 keeps none.
        observe: Called with the world at every sample of the log, to show progress or to pace the flight.

    Raises:
        CrazychoirError: If the world cannot be built, or a fault befalls a drone that cannot have it.
    """
    from crazychoir_fw.simulation import FlightRecorder

    plan = plan_flight(mission)
    world = build_world(mission, threads, visuals)
    _check_faults(mission, world)
    radio = turn_on_radios(mission, world)
    recorder = FlightRecorder(world, rate_hz=LOG_RATE)
    result = MissionFlight(mission, plan, world, recorder, Film(frames_per_second), observe).run()
    if radio is not None:
        result.summary["link"] = radio.link.statistics()
    return result


def build_world(
    mission: Mission,
    threads: int | None = None,
    visuals: bool = True,
    mirrored: "Sequence[MirroredConfig]" = (),
) -> "World":
    """Return the world of a mission with its drones on the floor, but for those that are mirrored."""
    from crazychoir_fw.simulation import DroneConfig, World

    elsewhere = {body.id for body in mirrored}
    drones = [DroneConfig(**drone_settings(drone)) for drone in mission.fleet if drone.id not in elsewhere]
    return World(drones, scene=mission.scene, seed=mission.seed, threads=threads, visuals=visuals, mirrored=mirrored)


def turn_on_radios(mission: Mission, world: "World") -> "FlightRadio | None":
    """Let the requests of the flight go by radio, if the mission has radios."""
    radios = simulated_radios(mission)
    if radios is None:
        return None
    from crazychoir_fw.crtp.link_model.flight_radio import FlightRadio

    return FlightRadio(world, radios)


def _check_faults(mission: Mission, world: "World") -> None:
    """Refuse what cannot go wrong, before the flight."""
    for number, entry in enumerate(mission.faults):
        try:
            world.faults.check(entry.fault)
        except CrazychoirError as error:
            raise MissionError(f"faults[{number}].{entry.name}: {error}") from None


class MissionFlight:
    """One flight while it runs."""

    def __init__(
        self,
        mission: Mission,
        plan: FlightPlan,
        world: "World",
        recorder: "FlightRecorder",
        film: Film,
        observe: Observer | None = None,
    ) -> None:
        self._mission = mission
        self._plan = plan
        self._world = world
        self._film = film
        self._observe = observe
        self._recorder = recorder
        self._failures: list[str] = []
        self._own_failures: dict[str, str] = {}  # of drones that fly themselves: the others go on
        self._events_seen = 0
        self._faults: list[dict[str, Any]] = []  # what was planned to go wrong, in times of the world
        self._expected: dict[str, str] = {}  # what happened to those that may fail, by id

    def run(self) -> FlightResult:
        """Fly to the end and return the result."""
        wall_start = time.perf_counter()
        start = 0.0
        if self._get_ready() and self._plan_faults(self._world.time):
            start = self._world.time
            self._follow_plan()
        else:
            # even a flight that never began has a log: how things stood
            self._recorder.sample()
        wall_seconds = time.perf_counter() - wall_start

        about = {"mission": self._mission.name, "description": self._mission.description, "faults": self._faults}
        log = self._recorder.finish(about)
        if not self._failures:
            self._failures = judge(self._mission, self._plan, log, start)
        self._failures += self._own_failures.values()
        expected = list(self._expected.values())
        summary = summarize(self._mission, self._plan, self._world, log, start, wall_seconds, self._failures, expected)
        return FlightResult(self._mission, self._world, log, self._film, summary)

    def _get_ready(self) -> bool:
        """Wait for calibration, checks and arming, then upload; return whether all drones can fly."""
        try:
            self._world.wait_until_ready(timeout_s=READY_TIMEOUT)
            for drone in self._world.drones:
                for upload in self._plan.uploads:
                    commander = drone.high_level_commander
                    commander.upload_trajectory(upload.number, upload.rows, offset=upload.offset)
        except CrazychoirError as error:
            self._failures.append(str(error))
        return not self._failures

    def _plan_faults(self, start: float) -> bool:
        """Plan what goes wrong, in times of the world; return whether all of it can."""
        try:
            for entry in self._mission.faults:
                fault = replace(entry.fault, at=round(entry.fault.at + start, 6))
                self._world.add_fault(fault)
                self._faults.append(fault.as_dict())
        except CrazychoirError as error:
            self._failures.append(str(error))
        return not self._failures

    def _fail(self, drone: str, sentence: str) -> None:
        """Remember a failure; that of a drone that may fail is no end of the flight, and its first one is enough."""
        if drone in self._mission.may_fail:
            self._expected.setdefault(drone, sentence)
        else:
            self._failures.append(sentence)

    def _follow_plan(self) -> None:
        """Send the commands at their ticks until the end or the first failure."""
        wall_start = time.perf_counter()
        commands = iter(self._plan.commands)
        upcoming = next(commands, None)
        flown = 0
        for tick, is_sample, is_frame in self._stops():
            if tick > flown:
                self._world.step(tick - flown)
                flown = tick
            if is_frame:
                self._film.times.append(self._world.time)
                self._film.qpos.append(np.array(self._world.data.qpos))
            if is_sample:
                self._recorder.sample()
                if tick % SUPERVISOR_TICKS == 0:
                    self._look_for_failures()
                if self._observe is not None:
                    wall = time.perf_counter() - wall_start
                    total = self._plan.ticks / TICKS_PER_SECOND
                    self._observe(self._world, Progress(tick / TICKS_PER_SECOND, total, wall))
            while upcoming is not None and upcoming.tick == tick:
                self._send(upcoming)
                upcoming = next(commands, None)
            if self._failures:
                return
        self._look_for_failures()

    def _stops(self) -> Iterator[tuple[int, bool, bool]]:
        """Yield the ticks at which something happens, with whether it is a sample of the log and a frame."""
        end = self._plan.ticks
        samples = set(range(0, end + 1, TICKS_PER_SECOND // LOG_RATE))
        frames: set[int] = set()
        if fps := self._film.fps:
            frames = {k * TICKS_PER_SECOND // fps for k in range(end * fps // TICKS_PER_SECOND + 1)}
        for tick in sorted(samples | frames | {command.tick for command in self._plan.commands}):
            yield tick, tick in samples, tick in frames

    def _send(self, command: Command) -> None:
        """Hand one command to its drone."""
        drone = self._world.drones[command.drone]
        if command.verb == "arm":
            if drone.can_arm:
                drone.arm()
            return
        if command.verb == "takeoff" and not drone.can_fly:
            self._fail(drone.id, f"{drone.id}: is not ready to take off ({drone.supervisor_state})")
            return
        try:
            getattr(drone.high_level_commander, command.verb)(**command.arguments)
        except CrazychoirError as error:
            self._fail(drone.id, str(error))

    def _look_for_failures(self) -> None:
        """Note every drone that collided, crashed, locked or stopped; it ends the flight unless it flies itself."""
        for name, sentence in collision_failures(self._mission, self._world.events[self._events_seen :]):
            self._fail(name, sentence)
        self._events_seen = len(self._world.events)
        for drone in self._world.drones:
            sentence = drone.outage(self._world.time)
            if sentence is None:
                continue
            if drone.motor_ctrl is not None and drone.id not in self._mission.may_fail:
                self._own_failures.setdefault(drone.id, sentence)
            else:
                self._fail(drone.id, sentence)
