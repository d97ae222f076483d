"""A flight that the planners on board fly: the phases of a mission are commands at their ticks."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.flight.backends import READY_TIMEOUT, add_faults
from crazychoir_fw.flight.plan_judge import flight_figures, judge
from crazychoir_fw.flight.summary import Assessment, collision_failures
from crazychoir_fw.mission.plan import Command, plan_flight
from crazychoir_fw.mission.schema import Mission

if TYPE_CHECKING:
    from crazychoir_fw.flight.sim_backend import SimBackend
    from crazychoir_fw.recording.flight_log import FlightLog

ROUND_TICKS = 10
"""Ticks between two samples of the log."""

SUPERVISOR_TICKS = 40
"""Ticks between two looks at the supervisors: as often as they look at their drones."""


class OnboardFlight:
    """One flight while it runs, of simulated drones; the engine asks a `LayersFlight` the same."""

    rounds_per_picture = 1

    def __init__(
        self, mission: Mission, backend: SimBackend, observe: Callable[[OnboardFlight], None] | None = None
    ) -> None:
        """Make the plan.

        Args:
            mission: What to fly.
            backend: Where the drones are, not yet ready to fly.
            observe: Called with every sample of the log.
        """
        self.backend = backend
        self.plan = plan_flight(mission)
        self.total_s = self.plan.ticks / TICKS_PER_SECOND
        self.began: float | None = None
        """When the drones were ready (s)."""
        self.events: list[Any] = []
        """What happened beside the events of the world: nothing."""
        self._failures: dict[str, str] = {}  # by id, the first of each drone: the others fly on
        self._grounded: set[int] = set()  # drones that could not take off: nothing more is asked of them
        self._not_ready: str | None = None  # why the flight did not begin
        self._own_failures: dict[str, str] = {}  # of drones that fly themselves, by id: the others go on
        self._expected: dict[str, str] = {}  # what happened to those that may fail, by id
        self._shares = {"simulation": 0.0, "record": 0.0}
        self._mission = mission
        self._world = backend.world
        self._observe = observe
        self._events_seen = 0

    def fly(self) -> None:
        """Get ready, and fly to the end of the plan, whatever happens to single drones."""
        if self._get_ready():
            self.began = self.backend.time
            self._follow_plan()
        else:
            # even a flight that never began has a log: how things stood
            self.backend.record({})

    def _get_ready(self) -> bool:
        """Wait for calibration, checks and arming, upload, and plan what goes wrong; return whether all can fly."""
        try:
            self._world.wait_until_ready(timeout_s=READY_TIMEOUT)
            for drone in self._world.drones:
                for upload in self.plan.uploads:
                    commander = drone.high_level_commander
                    commander.upload_trajectory(upload.number, upload.rows, offset=upload.offset)
            self.backend.faults = add_faults(self._mission, self._world)
        except CrazychoirError as error:
            self._not_ready = str(error)
        return self._not_ready is None

    def _follow_plan(self) -> None:
        """Send the commands at their ticks; a sample comes before them."""
        commands = deque(self.plan.commands)
        flown = tick = 0
        while tick <= self.plan.ticks:
            self._advance(tick - flown)
            flown = tick
            self._sample(tick)
            while commands and commands[0].tick < tick + ROUND_TICKS:
                if commands[0].tick > flown:
                    self._advance(commands[0].tick - flown)
                    flown = commands[0].tick
                self._send(commands.popleft())
            if flown == tick:
                last = min(self.plan.ticks, commands[0].tick - ROUND_TICKS) if commands else self.plan.ticks
                flown = tick = self._go_on_alone(tick, last)
            tick += ROUND_TICKS
        self._look_for_failures()

    def _advance(self, ticks: int) -> None:
        begin = time.perf_counter()
        if ticks:
            self.backend.advance(ticks / TICKS_PER_SECOND)
        self._shares["simulation"] += time.perf_counter() - begin

    def _go_on_alone(self, tick: int, last: int) -> int:
        """Let the core fly and record at most until a tick, without Python in between; return the tick it came to.

        Nothing differs from `_advance` and `_sample`: the core returns behind the first sample with news.
        """
        if self._observe is not None or last <= tick:
            return tick
        begin = time.perf_counter()
        taken, sampling = self.backend.run_alone((last - tick) // ROUND_TICKS)
        self._shares["record"] += sampling
        self._shares["simulation"] += time.perf_counter() - begin - sampling
        tick += taken * ROUND_TICKS
        if taken and tick % SUPERVISOR_TICKS == 0:
            self._look_for_failures()
        return tick

    def _sample(self, tick: int) -> None:
        begin = time.perf_counter()
        self.backend.record({})
        self._shares["record"] += time.perf_counter() - begin
        if tick % SUPERVISOR_TICKS == 0:
            self._look_for_failures()
        if self._observe is not None:
            self._observe(self)

    def _send(self, command: Command) -> None:
        """Hand one command to its drone."""
        if command.drone in self._grounded:
            return
        drone = self._world.drones[command.drone]
        if command.verb == "arm":
            if drone.can_arm:
                drone.arm()
            return
        if command.verb == "takeoff" and not drone.can_fly:
            self._grounded.add(command.drone)
            self._fail(drone.id, f"{drone.id}: is not ready to take off ({drone.supervisor_state})")
            return
        try:
            getattr(drone.high_level_commander, command.verb)(**command.arguments)
        except CrazychoirError as error:
            self._fail(drone.id, str(error))

    def _look_for_failures(self) -> None:
        """Note every drone that collided, crashed, locked or stopped."""
        for name, sentence in collision_failures(self._mission, self._world.events[self._events_seen :]):
            self._fail(name, sentence)
        self._events_seen = len(self._world.events)
        for drone in self._world.drones:
            outage = drone.outage(self._world.time)
            if outage is None:
                continue
            if drone.motor_ctrl is not None and drone.id not in self._mission.may_fail:
                self._own_failures.setdefault(drone.id, outage)
            else:
                self._fail(drone.id, outage)

    def _fail(self, drone: str, sentence: str) -> None:
        """Remember a failure; the first one of each drone is enough."""
        if drone in self._mission.may_fail:
            self._expected.setdefault(drone, sentence)
        else:
            self._failures.setdefault(drone, sentence)

    def log(self, about: dict[str, Any]) -> FlightLog:
        """Return the log of the flight.

        Args:
            about: What it says about the flight beside what is known here.
        """
        start = self.began or 0.0
        windows = [
            [name, start + begin / TICKS_PER_SECOND, start + end / TICKS_PER_SECOND]
            for name, begin, end in (self.plan.windows if self.began is not None else ())
        ]
        return self.backend.log({**about, "faults": self.backend.faults, "windows": windows})

    def assess(self, log: FlightLog) -> Assessment:
        """Return the result of the flight; places are looked at if all drones flew to its end."""
        start = self.began or 0.0
        if self._not_ready is not None:
            failures = [self._not_ready]
        else:
            failures = list(self._failures.values()) or judge(self._mission, self.plan, log, start)
        controllers = [drone.config.controller for drone in self._world.drones]
        return Assessment(
            drones=flight_figures(self.plan, log, start, controllers),
            failures=[*failures, *self._own_failures.values()],
            expected=list(self._expected.values()),
            shares=self._shares,
        )
