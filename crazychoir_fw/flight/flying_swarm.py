"""`FlyingSwarm`: drones of a backend, where they are, and what goes wrong with them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.checkpoint import Stateful
from crazychoir_fw.common.errors import CrazychoirError, RangeError, UnknownNameError
from crazychoir_fw.common.finite import are_finite
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.common.user_code import USER_ERRORS, describe
from crazychoir_fw.flight.agent import Agent, DronePhase, SwarmPhases
from crazychoir_fw.flight.backend import Backend
from crazychoir_fw.flight.event import Event
from crazychoir_fw.flight.touchdown import TOUCHDOWN_M

Flags = NDArray[np.bool_]
Names = str | Iterable[str] | None

_DESCENT_SPEED = 0.4  # [m/s], of a drone whose layers cannot land it
_SHORTEST_DESCENT_S = 1.0
_PARTS = ("position", "orientation", "velocity", "angular")  # of a pose


class FlyingSwarm(Stateful):
    """Agents and their drones. A layer of the user's that raises lands its own drone only."""

    def __init__(self, backend: Backend, agents: Sequence[Agent]) -> None:
        """Take the drones.

        Args:
            backend: Where the drones are.
            agents: The layers of each drone, in its order.

        Raises:
            RangeError: If there is not one agent for each drone.
        """
        if len(agents) != len(backend.names):
            raise RangeError(f"there are {len(agents)} agents, allowed: {len(backend.names)}, one for each drone")
        self.backend = backend
        self.agents = list(agents)
        self.events: list[Event] = []
        """What happened, in order."""
        self._commands = np.zeros((len(agents), 4))  # the last ones
        self._seen: Pose | None = None  # of each drone, without gaps
        self._everybody: Flags = np.ones(len(agents), bool)
        self._is_let_down: Flags = ~self._everybody  # the backend lands it, because a layer of it has raised
        self._known: Flags = ~self._everybody
        self._is_everybody_known = False
        self._phases = SwarmPhases(agents)

    @property
    def time(self) -> float:
        """Time of the backend (s)."""
        return self.backend.time

    def _chosen(self, drones: Names) -> list[Agent]:
        if drones is None:
            return list(self.agents)
        wanted: Collection[str] = [drones] if isinstance(drones, str) else list(drones)
        known = {agent.name: agent for agent in self.agents}
        for name in wanted:
            if name not in known:
                raise UnknownNameError(f"there is no drone '{name}', allowed: {', '.join(known)}")
        return [known[name] for name in wanted]

    def _poses(self) -> Pose:
        """Return where all drones are; those that are not seen stay where they were."""
        poses, before = self.backend.poses(), self._seen
        position = np.asarray(poses.position)
        self._is_everybody_known = are_finite(position)
        self._known = self._everybody if self._is_everybody_known else np.isfinite(position).all(axis=1)
        if before is None:
            self._seen = Pose(**{name: np.nan_to_num(getattr(poses, name)) for name in _PARTS}, time=poses.time)
        elif not self._is_everybody_known:
            is_known = self._known[:, None]
            kept = {name: np.where(is_known, getattr(poses, name), getattr(before, name)) for name in _PARTS}
            self._seen = Pose(**kept, time=poses.time)
        else:
            self._seen = poses
        return self._seen

    def _seen_ones(self, agents: Sequence[Agent]) -> Sequence[Agent]:
        """Return those of some agents whose drones are known."""
        return agents if self._is_everybody_known else [agent for agent in agents if self._known[agent.index]]

    def _turning(self) -> NDArray[np.bool_]:
        """Return whose motors turn at present, shape (N,)."""
        self._phases.look()
        return self._phases.turning

    def _touch_down(self, agents: Sequence[Agent]) -> None:
        """Turn motors off after a landing."""
        self.backend.stop([agent.index for agent in agents])
        for agent in agents:
            agent.phase = DronePhase.LANDED if agent.failure is None else DronePhase.FAILED
            self._is_let_down[agent.index] = False
            agent.reference = None
            self._commands[agent.index] = 0.0
            self._note("landed", agent)

    def _guarded(self, agent: Agent, call: Callable[..., Any], *arguments: Any) -> None:
        try:
            call(*arguments)
        except USER_ERRORS as error:
            self._fail_by(agent, agent.guidance, error)

    def _fail_by(self, agent: Agent, layer: object, error: BaseException) -> None:
        self._let_down(agent, f"{agent.name}: {type(layer).__name__}: {describe(error)} (at {self.time:.2f} s)")

    def _let_down(self, agent: Agent, sentence: str) -> None:
        """Land a drone whose layers have failed: its body and its onboard software are sound."""
        if agent.failure is not None:
            return
        if not agent.is_up:
            self._fail(agent, sentence)
            return
        height = float(np.asarray(self.backend.pose_of(agent.index).position)[2]) - agent.floor
        if not height > TOUCHDOWN_M:  # on the floor, or at an unknown height
            self._fail(agent, sentence)
            return
        try:
            self.backend.land(agent.index, agent.floor, max(_SHORTEST_DESCENT_S, height / _DESCENT_SPEED))
        except CrazychoirError as error:
            self._fail(agent, f"{sentence}; it could not be landed: {error}")
            return
        agent.phase, agent.failure, agent.reference = DronePhase.LANDING, sentence, None
        agent.low_since = None
        self._is_let_down[agent.index] = True
        self._commands[agent.index] = 0.0
        self._note("failure", agent, f"{sentence}; it lands")

    def _fail(self, agent: Agent, sentence: str) -> None:
        """Stop the motors of a drone that cannot fly."""
        if agent.phase is DronePhase.FAILED:
            return
        was_up = agent.is_up
        sentence = sentence if agent.failure is None else f"{agent.failure}; {sentence}"
        agent.phase, agent.failure, agent.reference = DronePhase.FAILED, sentence, None
        self._is_let_down[agent.index] = False
        self._commands[agent.index] = 0.0
        if was_up:
            try:
                self.backend.stop([agent.index])
            except CrazychoirError as error:
                agent.failure += f"; it could not be stopped: {error}"
        self._note("failure", agent, sentence)

    def _note(self, kind: str, agent: Agent, details: str = "") -> None:
        self.events.append(Event(self.time, kind, agent.name, details))
