"""One flight as a `gymnasium.Env`: a vector environment of one, without its autoreset."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.learning.flights import Flights
from crazychoir_fw.learning.rendering import Picture
from crazychoir_fw.learning.spaces import action_space, observation_space, observations, task_of
from crazychoir_fw.learning.tasks.task import Task


class SingleEnv(gymnasium.Env):
    """A flight of a task. Reset with seed s, it is the flight of seed s in a `FlightVectorEnv`, bit for bit."""

    metadata = {"render_modes": ["rgb_array", "human"], "render_fps": 100}  # noqa: RUF012 -- as Gymnasium has it

    def __init__(
        self,
        task: Task | type[Task] | str = "Hover",
        render_mode: str | None = None,
        bank_seed: int = 0,
        **changes: Any,
    ) -> None:
        """Build the world; arguments as of `FlightVectorEnv`.

        Raises:
            RangeError: If a value is outside its range.
            UnknownNameError: If there is no such task or field.
        """
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise RangeError(f"render_mode is {render_mode!r}, allowed: None, rgb_array, human")
        self.task = task_of(task, changes)
        """What is to be learned."""
        self.flights = Flights(self.task, 1, None, bank_seed, visuals=render_mode is not None)
        """The engine: readings, memory, world."""
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": self.task.rate_hz}
        self.observation_space = observation_space(self.task)
        self.action_space = action_space(self.task)
        self._picture = Picture(self.flights.world, self.flights.world.drones[0].id) if render_mode else None
        self._is_done = True

    def _observation(self) -> Any:
        found = observations(self.flights)
        return {name: part[0] for name, part in found.items()} if isinstance(found, dict) else found[0]

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode: the first one of a seed, or without a seed the next one.

        Raises:
            RangeError: If there are options; there are none.
        """
        if options:
            raise RangeError(f"reset: options name {', '.join(map(str, options))}, allowed: none")
        super().reset(seed=seed)
        if seed is not None:
            self.flights.seed([seed])
        self.flights.start([0])
        self._is_done = False
        if self.render_mode == "human":
            self.render()
        return self._observation(), {}

    def step(self, action: ArrayLike) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Fly on by one action, shape (A,), in [-1, 1].

        Raises:
            RangeError: If the shape is another, or a number is not finite; nothing has flown then.
            StateError: If the episode is over.
        """
        if self._is_done:
            raise StateError("step: the episode is over or has not begun, call reset() first")
        if np.shape(action) != self.action_space.shape:
            raise RangeError(f"action has shape {np.shape(action)}, allowed: {self.action_space.shape}")
        rewards, terminated, truncated = self.flights.step(np.asarray(action)[None])
        self._is_done = bool(terminated[0] or truncated[0])
        if self.render_mode == "human":
            self.render()
        return self._observation(), float(rewards[0]), bool(terminated[0]), bool(truncated[0]), {}

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture that follows the drone, shape (height, width, 3); ``human`` shows it in a window."""
        return None if self._picture is None else self._picture.render(self.render_mode)

    def close(self) -> None:
        """Close the window."""
        if self._picture is not None:
            self._picture.close()
