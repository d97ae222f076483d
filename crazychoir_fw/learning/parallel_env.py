"""A swarm whose drones see each other, as a `pettingzoo.ParallelEnv`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import MissingLibraryError, RangeError
from crazychoir_fw.learning.flights import Flights
from crazychoir_fw.learning.rendering import Picture
from crazychoir_fw.learning.spaces import action_space, task_of
from crazychoir_fw.learning.tasks.swarm import SEEN_OF_ANOTHER, SwarmTask

try:
    from pettingzoo import ParallelEnv
except ImportError:
    raise MissingLibraryError("PettingZoo is not installed; pip install 'crazychoir-fw[rl]' installs it") from None


class SwarmEnv(ParallelEnv):  # type: ignore[misc]
    """All drones act at once; a drone that crashes, leaves or touches another one is out, and its motors stop."""

    def __init__(
        self,
        task: SwarmTask | type[SwarmTask] | str = "Swarm",
        render_mode: str | None = None,
        bank_seed: int = 0,
        **changes: Any,
    ) -> None:
        """Build the world; arguments as of `FlightVectorEnv`.

        Raises:
            RangeError: If a value is outside its range, or the task is of single drones.
            UnknownNameError: If there is no such task or field.
        """
        if render_mode not in (None, "rgb_array", "human"):
            raise RangeError(f"render_mode is {render_mode!r}, allowed: None, rgb_array, human")
        chosen = task_of(task, changes)
        if not isinstance(chosen, SwarmTask):
            raise RangeError(f"task is {type(chosen).__name__}, allowed: a SwarmTask, such as Swarm or Swap")
        if chosen.camera is not None:
            raise RangeError("camera: allowed for tasks of a single drone; drones of a swarm have none")
        self.task = chosen
        """What is to be learned."""
        self.flights = Flights(chosen, chosen.drones, None, bank_seed, visuals=render_mode is not None)
        """The engine: readings, memory, world."""
        self.render_mode = render_mode
        self.metadata = {
            "name": f"crazychoir/{type(chosen).__name__}-v0",
            "render_modes": ["rgb_array", "human"],
            "render_fps": chosen.rate_hz,
            "is_parallelizable": True,
        }
        self.possible_agents = [drone.id for drone in self.flights.world.drones]
        self.agents: list[str] = []
        self._numbers = {agent: number for number, agent in enumerate(self.possible_agents)}
        size = chosen.observation.size + chosen.neighbors * SEEN_OF_ANOTHER
        self.observation_spaces = {
            agent: spaces.Box(-np.inf, np.inf, (size,), np.float32) for agent in self.possible_agents
        }
        self.action_spaces = {agent: action_space(chosen) for agent in self.possible_agents}
        self._picture = Picture(self.flights.world, self.possible_agents[0]) if render_mode else None

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """Return the space of an agent's observations: its own blocks, then its nearest neighbors."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """Return the space of an agent's actions."""
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[np.float32]], dict[str, dict[str, Any]]]:
        """Begin an episode: the first one of a seed, or without a seed the next one. There are no options.

        Raises:
            RangeError: If the seed is negative.
        """
        del options
        count = len(self.possible_agents)
        if seed is not None:
            self.flights.seed(seed * count + np.arange(count))
        self.flights.port.command(np.arange(count))
        self.flights.start(np.arange(count))
        self.agents = list(self.possible_agents)
        if self.render_mode == "human":
            self.render()
        return self._observations(self.agents), {agent: {} for agent in self.agents}

    def step(
        self, actions: Mapping[str, NDArray[np.float32]]
    ) -> tuple[
        dict[str, NDArray[np.float32]], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]
    ]:
        """Fly on by one action of each agent that is left.

        Raises:
            RangeError: If an agent's action is missing, has another shape or is not finite; nothing has flown then.
        """
        agents = self.agents
        if not agents:
            return {}, {}, {}, {}, {}
        rewards, is_over, is_late = self.flights.step(self._together(actions))
        out = [agent for agent in agents if is_over[self._numbers[agent]]]
        nothing: dict[str, dict[str, Any]] = {agent: {} for agent in agents}
        found = (
            self._observations(agents),
            {agent: float(rewards[self._numbers[agent]]) for agent in agents},
            {agent: agent in out for agent in agents},
            {agent: bool(is_late[self._numbers[agent]]) for agent in agents},
            nothing,
        )
        self.agents = [] if is_late.any() else [agent for agent in agents if agent not in out]
        for agent in out:
            lib.cf_emergency_stop(self.flights.world[agent].struct)
            lib.cf_arm(self.flights.world[agent].struct, False)
        self.flights.port.command(np.array([self._numbers[agent] for agent in self.agents], np.int32))
        if self.render_mode == "human":
            self.render()
        return found

    def _together(self, actions: Mapping[str, NDArray[np.float32]]) -> NDArray[np.float32]:
        rows = np.zeros((len(self.possible_agents), self.task.action.size), np.float32)
        for agent in self.agents:
            if agent not in actions:
                raise RangeError(f"step: there is no action of '{agent}', allowed: one of each of {self.agents}")
            if np.shape(actions[agent]) != rows.shape[1:]:
                raise RangeError(f"{agent}: action has shape {np.shape(actions[agent])}, allowed: {rows.shape[1:]}")
            rows[self._numbers[agent]] = actions[agent]
        return rows

    def _observations(self, agents: list[str]) -> dict[str, NDArray[np.float32]]:
        is_flying = np.zeros(len(self.possible_agents), bool)
        is_flying[[self._numbers[agent] for agent in agents]] = True
        others = self.task.others(self.flights.reading, is_flying)
        rows = np.concatenate([self.flights.observe(), others], axis=1)
        return {agent: rows[self._numbers[agent]].copy() for agent in agents}

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture that follows the first drone, shape (height, width, 3); ``human`` shows it in a window."""
        return None if self._picture is None else self._picture.render(self.render_mode)

    def close(self) -> None:
        """Close the window."""
        if self._picture is not None:
            self._picture.close()
