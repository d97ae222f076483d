"""A mission whose layers live in other processes: phases, commands, log and verdict here, decisions over topics.

The flight is that of the runner in one process (`Experiment`), only that guidance, planning and control of each drone
are asked by topics: odometry goes out, commands come in, round by round.
"""

from __future__ import annotations

import json
import os
import time
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.context import Context
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from std_msgs.msg import Empty, String

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.common.messages import Pose, TrajectoryPoint
from crazychoir_fw.flight.access import open_access
from crazychoir_fw.flight.agent import Agent, DronePhase
from crazychoir_fw.flight.agents import graph_of, is_only_watched, names_of, what_it_follows
from crazychoir_fw.flight.experiment import Experiment, Names
from crazychoir_fw.ros.arming_services import serve_arming_services
from crazychoir_fw.ros.conversions import points_to_joint_trajectory
from crazychoir_fw.ros.drone_states import StateTeller
from crazychoir_fw.ros.names import BUTTONS, LAST_BUTTON, LATEST, REFERENCES, TRAJ_PARAMS
from crazychoir_fw.ros.parts import Part, has_table, one_command
from crazychoir_fw.ros.remote import (
    HostedDrones,
    RemoteGroup,
    RemoteGuidance,
    neighbors_taker,
    points_taker,
    reference_taker,
)
from crazychoir_fw.ros.simulation import PaceSettings, SimulationNode
from crazychoir_fw.ros.statistics import RemoteCommunicator, StatisticsCollector
from crazychoir_fw.ros.tasks import EVERYTHING, HAPPENINGS, LAST_TABLE, MEMORY

ANSWERED = "answered"
"""Topic on which a guidance answers each tick in lock step."""

READY = "/ready"
"""Topic on which each process says that it has found its partners."""

_COMMANDS = (("control", "cmd_vel"), ("avoidance", "cmd_vel"))
_HOLD_S = 0.5  # [s], within which it comes to rest
_SHORTEST_LANDING_S = 1.0
_DESCENT_SPEED = 0.4  # [m/s], of a drone that nobody but the host lands
_WARM_UP_ROUNDS = 10
_WARM_UP_S = 20.0  # [s], wall, at most
_PAUSE_S = 0.3  # [s], wall: the longest round while somebody has not been heard of


def names_from(reading: int) -> list[str]:
    """Return the processes that have ended since the last look, if any.

    Args:
        reading: End of a pipe that their supervisor writes their names to, one a line.
    """
    os.set_blocking(reading, False)
    try:
        return os.read(reading, 65536).decode().splitlines()
    except BlockingIOError:
        return []


class HostedExperiment(Experiment):
    """An experiment whose layers are nodes."""

    def __init__(
        self,
        mission: Any,
        backend: Any,
        executor: Any,
        pace: PaceSettings,
        observe: Any = None,
        context: Context | None = None,
    ) -> None:
        """Make the simulation node of a mission.

        Args:
            mission: The mission.
            backend: Where the drones are.
            executor: What the node is worked on by.
            pace: How fast time goes on.
            observe: Called after every round.
            context: Context of rclpy.
        """
        layers = mission.layers
        count = len(names_of(mission))
        kind = one_command(mission)
        answers = {ANSWERED: range(count)} if pace.lockstep else {}
        if kind != "xyz":
            answers["cmd_vel"] = range(count)
        self.node = SimulationNode(
            HostedDrones(backend),
            command=kind,
            rate=layers.rate,
            pace=pace,
            answers=answers,
            obeys_idle=False,
            context=context,
        )
        self._executor = executor
        executor.add_node(self.node)
        remote = [RemoteGuidance() for _ in range(count)]
        agents = [
            Agent(i, name, remote[i], is_watched=is_only_watched(mission, i))
            for i, name in enumerate(names_of(mission))
        ]
        self._remote = None if kind == "xyz" else RemoteGroup(self.node, kind)
        groups = [] if self._remote is None else [self._remote]
        super().__init__(backend, agents, groups, layers.rate, mission.log_rate, observe)  # type: ignore[arg-type]
        self._command_timeout = mission.layers.command_timeout_s
        self._held: set[int] = set()
        self._guidance_ended: set[int] = set()  # whose process is gone, so that no button reaches it
        self._parts: dict[str, Part] = {}
        self._look_for_deaths: Callable[[], None] = lambda: None
        self._buttons: dict[str, Any] = {name: self.node.announce(topic) for name, topic in BUTTONS.items()}
        self._last_button = self.node.create_publisher(String, f"/{LAST_BUTTON}", LATEST)
        self._own_presses: Counter[tuple[str, int | None]] = Counter()
        self._presses = [0] * count
        self._button_of: dict[tuple[str, int], Any] = {}
        self._last_button_of: dict[int, Any] = {}
        self._trajectories = [
            self.node.announce(TRAJ_PARAMS, self.node.topic_of(i, "traj_params")) for i in range(count)
        ]
        self._listen(mission, remote, kind)
        self._statistics = self._collector(mission, remote)
        self.ready: set[str] = set()
        """Processes that have found their partners."""
        # many say it at once, and none of them may push another one out
        everything = QoSProfile(depth=1000, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
        self.node.create_subscription(String, READY, lambda message: self._is_ready(message.data), everything)

    def _listen(self, mission: Any, remote: Sequence[RemoteGuidance], kind: str) -> None:
        node = self.node
        if has_table(mission):
            node.create_subscription(String, HAPPENINGS, self._hear_of, EVERYTHING)
            # outlives the process of the table
            self._last_table = node.create_publisher(String, LAST_TABLE, LATEST)
            node.create_subscription(String, MEMORY, self._last_table.publish, LATEST)
        numbers = {node.namespace_pattern.format(i=i): i for i in range(len(remote))}
        for name, topic in BUTTONS.items():
            node.listen(topic, lambda _, pressed=name: self._pressed(pressed))
            for i in range(len(remote)):
                where = node.topic_of(i, topic.name.lstrip("/"))
                node.listen(topic, lambda _, pressed=name, i=i: self._pressed(pressed, i), where)
        for i, guidance in enumerate(remote):
            node.create_subscription(String, node.topic_of(i, "lost_neighbors"), neighbors_taker(guidance, numbers), 10)
            if kind == "xyz":
                node.listen(TRAJ_PARAMS, points_taker(guidance), node.topic_of(i, "traj_params"))
                continue
            follows = what_it_follows(mission, i)
            topic = REFERENCES[follows]
            node.hear(topic, node.topic_of(i, topic.name), reference_taker(node, guidance, follows))
        node.members.invite()

    def _collector(self, mission: Any, remote: Sequence[RemoteGuidance]) -> StatisticsCollector:
        graph = graph_of(mission)
        for i, guidance in enumerate(remote):
            if graph.in_neighbors(i) or graph.out_neighbors(i):
                guidance.communicator = RemoteCommunicator(graph.in_neighbors(i), graph.out_neighbors(i))
        communicators = {i: one.communicator for i, one in enumerate(remote) if one.communicator is not None}
        return StatisticsCollector(self.node, communicators)

    def communication(self) -> dict[str, Any] | None:
        """See `Experiment`; asks the processes, and takes what was told last by those that are gone."""
        alive = [agent.index for agent in self.agents if agent.index not in self._guidance_ended]
        self._statistics.ask(alive, lambda: self._executor.spin_once(timeout_sec=0.05))
        return super().communication()

    def _hear_of(self, message: String) -> None:
        """Something happened at a table."""
        try:
            told = json.loads(message.data)
            agent = told["agent"]
            if agent is None or 0 <= int(agent) < len(self.agents):
                self._note_of_service(str(told["kind"]), agent, dict(told["details"]))
        except (ValueError, KeyError, TypeError) as error:
            self.node.get_logger().warning(f"{HAPPENINGS}: {error}", throttle_duration_sec=1.0)

    # ---------------------------------------------------------------- buttons

    def takeoff(self, drones: Names = None) -> None:
        """See `Experiment`."""
        self._carry_out("takeoff", drones)
        self._tell("takeoff", drones)

    def start(self, drones: Names = None) -> None:
        """See `Experiment`."""
        self._carry_out("start", drones)
        self._tell("start", drones)

    def land(self, drones: Names = None) -> None:
        """See `Experiment`."""
        self._carry_out("land", drones)
        self._tell("land", drones)
        self._bring_down_whom_nobody_lands(drones)

    def stop(self, drones: Names = None) -> None:
        """See `Experiment`."""
        self._carry_out("stop", drones)
        self._tell("stop", drones)

    def _carry_out(self, button: str, drones: Names) -> None:
        """Do what a button means where the drones are."""
        if button in ("takeoff", "start"):
            self._hear_again(drones)
        getattr(super(), button)(drones)
        for agent in self._chosen(drones):
            self._presses[agent.index] += 1

    def _bring_down_whom_nobody_lands(self, drones: Names) -> None:
        if not self.backend.is_real_time:
            for agent in self._chosen(drones):
                if agent.index in self._held or agent.index in self._guidance_ended:
                    self._bring_down(agent)

    def set_trajectory(self, points: Sequence[TrajectoryPoint], drones: Names = None) -> None:
        """Hand points to the trajectory handlers, by topic."""
        for agent in self._chosen(drones):
            self._trajectories[agent.index].publish(points_to_joint_trajectory(points, agent.index))

    def _hear_again(self, drones: Names) -> None:
        if self._remote is not None:
            self._remote.unheard.difference_update(agent.index for agent in self._chosen(drones))

    def _tell(self, button: str, drones: Names) -> None:
        if drones is None:
            self._own_presses[button, None] += 1
            self._buttons[button].publish(Empty())
        else:
            for agent in self._chosen(drones):
                self._own_presses[button, agent.index] += 1
                self._button_of[button, agent.index].publish(Empty())
        self._keep(button, drones)

    def _keep(self, button: str, drones: Names) -> None:
        """Keep what was pressed last, for processes that are started again."""
        if drones is None:
            self._last_button.publish(String(data=button))
            return
        for agent in self._chosen(drones):
            i = agent.index
            if i not in self._last_button_of:
                topic = self.node.topic_of(i, LAST_BUTTON)
                self._last_button_of[i] = self.node.create_publisher(String, topic, LATEST)
            self._last_button_of[i].publish(String(data=button))

    def prepare(self, phases: Sequence[Any]) -> None:
        """Make publishers for buttons of single drones, so that they are known when they are needed."""
        for phase in phases:
            if phase.name in BUTTONS and phase.maneuver.drones is not None:
                topic = BUTTONS[phase.name]
                for agent in self._chosen(phase.maneuver.drones):
                    where = self.node.topic_of(agent.index, topic.name.lstrip("/"))
                    self._button_of[phase.name, agent.index] = self.node.announce(topic, where)

    def _pressed(self, button: str, drone: int | None = None) -> None:
        """Somebody pressed a button, of all drones or of one: this flight itself, or a person."""
        if self._own_presses[button, drone] > 0:
            self._own_presses[button, drone] -= 1
            return
        names = None if drone is None else [self.agents[drone].name]
        self._carry_out(button, names)
        self._keep(button, names)
        if button == "land":
            self._bring_down_whom_nobody_lands(names)

    def tell_states(self, mission: Any) -> None:
        """Say from now on how the drones are, and what happens, to whoever watches; arm and reboot them if asked."""
        access = open_access(self.backend)
        self._teller = StateTeller(self.node, self, mission, access, self._presses.__getitem__)
        serve_arming_services(self.node, self.agents, access)

    # ---------------------------------------------------------------- rounds

    def wait_for(self, processes: Sequence[str], timeout: float, look: Callable[[], None] = lambda: None) -> list[str]:
        """Wait until processes have found their partners; returns those that have not in time (s, wall).

        Args:
            processes: Their names.
            timeout: How long (s, wall).
            look: Called now and then; what it raises ends the waiting.
        """
        deadline = time.monotonic() + timeout
        while not self.ready.issuperset(processes) and time.monotonic() < deadline:
            self._executor.spin_once(timeout_sec=0.05)
            look()
        return sorted(set(processes) - self.ready)

    def watch_deaths(self, reading: int, parts: Sequence[Part]) -> None:
        """Wait no more for processes that have ended.

        Args:
            reading: See `names_from`.
            parts: What each of them does.
        """
        self._parts = {part.name: part for part in parts}

        def look() -> None:
            for name in names_from(reading):
                if name in self._parts:
                    self._has_ended(self._parts[name])

        self.node.while_waiting = self._look_for_deaths = look

    def _has_ended(self, part: Part) -> None:
        """A process is gone: nobody waits for it, and the log says so."""
        for i in part.agents:
            for layer, topic in (("guidance", ANSWERED), *_COMMANDS):
                if layer in part.layers:
                    self.node.answers.bury((i, topic))
            if "guidance" in part.layers:
                self._guidance_ended.add(i)
                if self.agents[i].phase is DronePhase.LANDING and not self.backend.is_real_time:
                    self._bring_down(self.agents[i])
        self._note_of_service(
            "ended", part.agents[0] if len(part.agents) == 1 else None, f"process {part.name} has ended"
        )

    def _is_ready(self, process: str) -> None:
        self.ready.add(process)
        part = self._parts.get(process)
        if part is not None and "guidance" in part.layers:
            self._guidance_ended.difference_update(part.agents)
            if self._remote is not None:
                self._remote.unheard.difference_update(part.agents)

    def warm_up(self) -> None:
        """Say a few times how things are, while the drones rest, so that everybody knows pose and time.

        Afterwards everybody is waited for. The number of rounds is always the same, so that the flight is.
        """
        answers, deadline = self.node.answers, time.monotonic() + _WARM_UP_S
        # the time comes first, so that nobody takes the first pose for an old one
        self.node.publish_clock()
        pause = time.monotonic() + _PAUSE_S
        while time.monotonic() < pause:
            self._executor.spin_once(timeout_sec=0.05)
        for _ in range(_WARM_UP_ROUNDS):
            self.node.publish()
            pause = time.monotonic() + (_PAUSE_S if self.node.pace.lockstep else 0.0)
            while time.monotonic() < pause or (not answers.is_complete and time.monotonic() < deadline):
                self._executor.spin_once(timeout_sec=0.01)
                if not answers.missing and answers.is_complete:
                    break
            self.backend.advance(self.period)
        if self.node.pace.lockstep:
            answers.expect_all()

    def _decide(self, agents: Sequence[Agent], poses: Pose, now: float) -> None:
        """Take what guidance elsewhere has asked for since the last round."""
        for agent in agents:
            guidance: RemoteGuidance = agent.guidance
            if guidance.is_new or guidance.lost is not agent.lost:
                guidance.is_new = not agent.is_up  # who rests takes nothing, and is asked again
                self._take(agent, guidance.step(now), poses, now)

    def step(self) -> None:
        """Fly one round: say how things are, hear what is to be done, do it."""
        self.node.exchange(self._executor)
        # who waits for nobody looks here
        self._look_for_deaths()
        if not self.node.context.ok():
            raise CrazychoirError("ROS was shut down")
        super().step()
        if self._remote is not None and not self.backend.is_real_time:
            self._hold_whom_nobody_commands(self._remote.commanded)

    def _hold_whom_nobody_commands(self, commanded: NDArray[np.float64]) -> None:
        """Let drones stay where they are by their planner on board, once nobody has commanded them for a while.

        Over the radio the handler minds silence; simulated drones would fall, or fly on as they were told last.
        """
        now = self.time
        for agent in self.agents:
            i = agent.index
            if now - commanded[i] <= self._command_timeout or not agent.is_up:
                self._held.discard(i)
            elif i not in self._held:
                self._held.add(i)
                sentence = f"no command for {self._command_timeout:g} s, stays where it is"
                self.node.get_logger().warning(f"{agent.name}: {sentence}")
                self._note("held", agent, sentence)
                if agent.phase is DronePhase.LANDING:
                    self._bring_down(agent)
                else:
                    self._guarded(
                        agent, self.backend.go_to, i, TrajectoryPoint(_HOLD_S, self.backend.pose_of(i).position)
                    )

    def _bring_down(self, agent: Agent) -> None:
        """Land a drone by its planner on board, since nobody else does."""
        if not agent.is_up:
            return
        if self._remote is not None:
            self._remote.unheard.add(agent.index)
        x, y, z = self.backend.pose_of(agent.index).position
        duration = max(_SHORTEST_LANDING_S, (z - agent.floor) / _DESCENT_SPEED)
        self._guarded(agent, self.backend.go_to, agent.index, TrajectoryPoint(duration, np.array([x, y, agent.floor])))
