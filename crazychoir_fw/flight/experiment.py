"""`Experiment`: guidance, planning and control of a swarm in one process, round by round, on any backend."""

from __future__ import annotations

import time as wall
from collections.abc import Callable, Iterable, Mapping, Sequence
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.common.finite import are_finite
from crazychoir_fw.common.messages import Pose, Reference, TrajectoryPoint
from crazychoir_fw.common.user_code import USER_ERRORS, describe
from crazychoir_fw.flight.agent import Agent, DronePhase
from crazychoir_fw.flight.backend import Backend, one_of
from crazychoir_fw.flight.control_group import ControlGroup
from crazychoir_fw.flight.detour import Detour
from crazychoir_fw.flight.event import Event
from crazychoir_fw.flight.flying_swarm import Names
from crazychoir_fw.flight.guided_swarm import GuidedSwarm
from crazychoir_fw.flight.layer_signals import LayerSignals
from crazychoir_fw.flight.services import Service
from crazychoir_fw.flight.touchdown import fallen_of, landed_of
from crazychoir_fw.mission.communicators import statistics_of

Array = NDArray[np.float64]

_ROUNDS_PER_LOOK = 4  # rounds between two checks for failed drones
_FAILURE = attrgetter("failure")
PARTS = ("simulation", "guidance", "planning", "control", "sending", "record")


class Experiment(GuidedSwarm):
    """Flies the layers of a swarm.

    A round is: poses, guidance, trajectory handlers, controllers, commands; then the backend goes on for a period. With
    a simulated backend the result depends on nothing else. A layer of the user's that raises lands its own drone only.

    Buttons (`takeoff`, `start`, `land`, `stop`) may be pressed between rounds, for all drones or some::

        experiment.takeoff()
        experiment.run(5.0)
        experiment.start()
        experiment.run(60.0)
        experiment.land()
        experiment.run(7.0)
    """

    no_rewind: str | None = None
    """Why the flight cannot be rewound though the backend can, a sentence."""
    unkept = ("shares", "observe")

    def __init__(
        self,
        backend: Backend,
        agents: Sequence[Agent],
        groups: Sequence[ControlGroup],
        rate: int = 100,
        log_rate: int = 100,
        observe: Callable[[Experiment], None] | None = None,
        services: Sequence[Service] = (),
    ) -> None:
        """Bind layers to a backend.

        Args:
            backend: Where the drones are.
            agents: The layers of each drone, in its order.
            groups: Controllers; a drone in none of them is flown by the planner on board.
            rate: Rounds per second (Hz).
            log_rate: Samples of the log per second (Hz), a divisor of it.
            observe: Called after every round.
            services: What belongs to no drone and takes its turn before guidance.

        Raises:
            RangeError: If the numbers do not fit together.
        """
        _check_rates(rate, log_rate)
        super().__init__(backend, agents, {int(i) for group in groups for i in group.indices})
        self.groups = list(groups)
        self.services = list(services)
        self.service_failures: list[str] = []
        """Why services stopped, one sentence each."""
        for service in self.services:
            service.note = self._note_of_service
        self.period = 1.0 / rate
        self.shares = dict.fromkeys(PARTS, 0.0)
        """Time that each part took on this machine (s); for people, nothing depends on it."""
        self._rounds = 0
        self._rounds_per_sample = rate // log_rate
        self.observe = observe
        self._detours: dict[int, Detour] = {}
        self._layer_signals = LayerSignals(agents, self._phases)

    # ---------------------------------------------------------------- buttons

    def takeoff(self, drones: Names = None) -> None:
        """Take off: motors on.

        Raises:
            UnknownNameError: If there is no such drone.
        """
        self._press("takeoff", drones, motors=True)

    def start(self, drones: Names = None) -> None:
        """Let the guidance do what it is for; drones whose motors do not turn yet begin from where they are."""
        self._press("start", drones, motors=True)
        for service in list(self.services):
            self._serve(service, service.start, self.time)

    def land(self, drones: Names = None) -> None:
        """Land; the motors of each drone stop when it is down."""
        for agent in self._press("land", drones, motors=False):
            agent.phase = DronePhase.LANDING

    def stop(self, drones: Names = None) -> None:
        """Stop the motors at once."""
        chosen = self._chosen(drones)
        self.backend.stop([agent.index for agent in chosen])
        for agent in chosen:
            self._guarded(agent, _button(agent.guidance, "stop"), self.time)
            agent.phase = DronePhase.STOPPED if agent.is_up else agent.phase
            self._is_let_down[agent.index] = False
            self._detours.pop(agent.index, None)
            self._note("stop", agent)

    def set_trajectory(self, points: Sequence[TrajectoryPoint], drones: Names = None) -> None:
        """Hand points to the trajectory handlers, as a drawn curve is; the first one in flight.

        Raises:
            UnknownNameError: If there is no such drone.
        """
        poses, now = self._poses(), self.time
        for agent in self._chosen(drones):
            self._guarded(agent, self._plan, agent, list(points), one_of(poses, agent.index), now)

    def send_to(self, point: TrajectoryPoint, drone: str) -> None:
        """Send a drone that flies to a point; one that follows its guidance alone goes there until the next button.

        Raises:
            UnknownNameError: If there is no such drone.
            StateError: If it cannot be sent.
        """
        (agent,) = self._chosen(drone)
        if agent.planner is None and agent.index in self._controlled:
            self._divert(agent, point)
        else:
            self.set_trajectory([point], drone)

    def cannot_divert(self, agent: Agent) -> str | None:
        """Return why a drone that follows its guidance alone cannot be sent anywhere, a sentence, or None."""
        del agent
        return None

    def _divert(self, agent: Agent, point: TrajectoryPoint) -> None:
        if reason := self.cannot_divert(agent):
            raise StateError(reason)
        if agent.is_up and agent.failure is None:
            start = one_of(self._poses(), agent.index).position
            assert start is not None
            goal = np.array(point.position, float)
            self._detours[agent.index] = Detour(start.copy(), goal, self.time, max(float(point.time_s), self.period))

    def _press(self, name: str, drones: Names, motors: bool) -> list[Agent]:
        """Press a button of some drones; returns those that it is for."""
        now = self.time
        wanted = [agent for agent in _not_failed(self._chosen(drones)) if motors or agent.is_up]
        for agent in wanted:
            self._detours.pop(agent.index, None)
        resting = [agent for agent in wanted if not agent.is_up]
        if resting and motors:
            self._turn_on(resting)
            now = self.time  # real drones take their time
        poses = self._poses()
        for agent in wanted:
            if agent.failure is None and self._known[agent.index]:
                self._guarded(agent, agent.guidance.set_pose, one_of(poses, agent.index))
            if agent.failure is None:
                self._guarded(agent, _button(agent.guidance, name), now)
                self._note(name, agent)
        return _not_failed(wanted)

    def _turn_on(self, agents: Sequence[Agent]) -> None:
        refused = set(self.backend.unlock([agent.index for agent in agents]))
        reasons = self.backend.failures()
        poses = self._poses()
        for agent in agents:
            if agent.is_watched:
                continue
            if agent.index in refused:
                self._fail(agent, reasons.get(agent.index, f"{agent.name}: the motors may not run"))
                continue
            if not self._known[agent.index]:
                self._fail(agent, f"{agent.name}: nobody knows where it is")
                continue
            agent.phase = DronePhase.FLYING
            agent.has_flown, agent.low_since = False, None
            agent.begin_at(poses.position[agent.index])
            # until the guidance or the caller sets another reference
            agent.reference = Reference(position=agent.home.copy(), velocity=np.zeros(3), acceleration=np.zeros(3))
            self.accelerations[agent.index] = 0.0

    # ---------------------------------------------------------------- rounds

    def run(self, seconds: float) -> None:
        """Fly so many seconds, rounded to whole rounds."""
        if not (np.isfinite(seconds) and seconds >= 0.0):
            raise RangeError(f"run({seconds}): allowed: 0 s or more")
        for _ in range(round(seconds / self.period)):
            self.step()

    def run_until_landed(self, timeout_s: float, all_drones: bool = True) -> bool:
        """Fly until no motor turns, or none of a drone whose layers have failed; returns whether it came about in time.

        Args:
            timeout_s: How long (s).
            all_drones: Whether to wait for drones without a failure as well.
        """
        end = self.time + timeout_s
        while any(agent.is_up and (all_drones or agent.failure is not None) for agent in self.agents):
            if self.time >= end:
                return False
            self.step()
        return True

    def step(self) -> None:
        """Fly one round."""
        clock = wall.perf_counter
        begin = clock()
        poses, now = self._poses(), self.time
        for service in list(self.services):
            self._serve(service, service.step, now, poses, self._turning())
        # also those on the ground: neighbors hear them
        deciding = self._seen_ones(self.agents)
        self._decide(_not_failed(deciding) if any(map(_FAILURE, deciding)) else deciding, poses, now)
        turning = self._turning()
        up = self._seen_ones(self._phases.up)
        decided = clock()
        self._follow(now)
        for i, detour in self._detours.items():
            if self.agents[i].is_up and self.agents[i].failure is None:
                self.agents[i].reference = detour.reference(now)
                self.accelerations[i] = detour.acceleration(one_of(poses, i), now)
        planned = clock()
        orders = self._control(list(self.groups), turning & ~self._is_let_down, poses, now) if up else []
        controlled = clock()
        for group, indices, twist in orders:
            self._send(group, indices, twist)
        self._look(up, poses)
        sent = clock()
        if self._rounds % self._rounds_per_sample == 0:
            self.backend.record(self._signals())
        recorded = clock()
        self.backend.advance(self.period)
        self._rounds += 1
        parts = (decided - begin, planned - decided, controlled - planned, sent - controlled, recorded - sent)
        for name, seconds in zip(PARTS[1:], parts, strict=True):
            self.shares[name] += seconds
        self.shares["simulation"] += clock() - recorded
        if self.observe is not None:
            self.observe(self)

    def _control(
        self, groups: Iterable[ControlGroup], turning: NDArray[np.bool_], poses: Pose, now: float
    ) -> list[tuple[ControlGroup, Any, Any]]:
        """Ask controllers for commands; returns the drones and their commands, group by group.

        Drones of a group that raises get a controller each, and one that raises there lands its own drone only.
        """
        orders = []
        for group in groups:
            try:
                order = group.step(self.agents, self.accelerations, turning, poses, now)
            except USER_ERRORS as error:  # a user's code may raise anything
                at = self.groups.index(group)
                if len(group.indices) > 1 and group.of_one is not None:
                    alone = [group.of_one(int(i)) for i in group.indices]
                    self.groups[at : at + 1] = alone
                    orders += self._control(alone, turning, poses, now)
                else:
                    del self.groups[at]
                    for i in group.indices:
                        self._fail_by(self.agents[i], group.controller, error)
                continue
            if order is not None:
                orders.append((group, *order))
        return orders

    def _send(self, group: ControlGroup, indices: Any, twist: Any) -> None:
        linear, angular = twist.linear, twist.angular
        if not are_finite(linear, angular):
            good = np.isfinite(linear).all(axis=1) & np.isfinite(angular).all(axis=1)
            for i in indices[~good]:
                self._let_down(
                    self.agents[i], f"{self.agents[i].name}: its controller asks for numbers that are not finite"
                )
            indices, twist = indices[good], type(twist)(linear[good], angular[good])
        if not self._is_everybody_known:
            seen = self._known[indices]
            indices, twist = indices[seen], type(twist)(twist.linear[seen], twist.angular[seen])
        is_vel = group.kind == "vel"
        self._commands[indices, 0] = 0.0 if is_vel else twist.linear[:, 2]
        self._commands[indices, 1:] = twist.linear if is_vel else twist.angular
        if len(indices):
            self.backend.send(indices, twist, group.kind)

    def _look(self, up: Sequence[Agent], poses: Pose) -> None:
        """Handle landings, and drones whose flight failed."""
        if self._phases.is_anybody_landing:
            landed = landed_of(up, poses)
            if landed:
                self._touch_down(landed)
        if self._rounds % _ROUNDS_PER_LOOK == 0:
            for agent in fallen_of(up, poses, self.time):
                self._fail(agent, f"{agent.name}: came down at {agent.low_since:.2f} s")
            for i, sentence in self.backend.failures().items():
                if self.agents[i].is_up:
                    self._fail(self.agents[i], sentence)

    # ---------------------------------------------------------------- what goes wrong

    def _serve(self, service: Service, call: Callable[..., None], *arguments: Any) -> None:
        """Give a service its turn; a service that raises is removed."""
        try:
            call(*arguments)
        except USER_ERRORS as error:
            sentence = f"{type(service).__name__}: {describe(error)} (at {self.time:.2f} s)"
            self.services.remove(service)
            self.service_failures.append(sentence)
            self._note_of_service("failure", None, sentence)

    def _note_of_service(self, kind: str, drone: int | None, details: str | Mapping[str, Any] = "") -> None:
        name = None if drone is None else self.agents[drone].name
        self.events.append(Event(self.time, kind, name, details))

    @property
    def failures(self) -> list[str]:
        """Failures of drones and services, one sentence each."""
        return [agent.failure for agent in self.agents if agent.failure is not None] + self.service_failures

    # ---------------------------------------------------------------- log

    def _signals(self) -> dict[str, Array]:
        """Return what the layers say at present, for the log."""
        self._phases.look()
        return self._layer_signals.now(self.accelerations, self._commands)

    def log(self, metadata: dict[str, Any] | None = None) -> Any:
        """Return the log so far, with what happened among its events."""
        self.backend.record(self._signals())
        log = self.backend.log(dict(metadata or {}))
        log.events = sorted(
            [*log.events, *(happening.as_dict() for happening in self.events)], key=lambda event: event["time"]
        )
        return log

    def communication(self) -> dict[str, Any] | None:
        """Return what the communicators have seen, by drone and in total; None if there are none."""
        return statistics_of(self.agents)


def _check_rates(rate: int, log_rate: int) -> None:
    """Refuse rates (Hz) whose samples do not fall on rounds.

    Raises:
        RangeError: If they do not.
    """
    if rate < 1 or log_rate < 1 or rate % log_rate:
        raise RangeError(f"log_rate is {log_rate}, allowed: a divisor of the rate, {rate} Hz")


def _button(guidance: Any, name: str) -> Callable[[float], None]:
    """Return what a guidance does at a button; a class that does not know it does nothing."""
    return getattr(guidance, name, lambda now: None)


def _not_failed(agents: Iterable[Agent]) -> list[Agent]:
    return [agent for agent in agents if agent.failure is None]
