"""All flights as one `gymnasium.vector.VectorEnv`: one world, one call per step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.learning.flights import Flights
from crazychoir_fw.learning.rendering import Picture
from crazychoir_fw.learning.spaces import action_space, observation_space, observations, task_of
from crazychoir_fw.learning.tasks.task import Task


class FlightVectorEnv(VectorEnv):
    """N flights of a task; a flight that ends begins again within the same step (autoreset mode ``SAME_STEP``).

    ``infos["final_obs"]`` has the last observations of flights that ended, and ``infos["_final_obs"]`` says which those
    are. A flight with seed s is that of a single environment reset with seed s.
    """

    metadata = {  # noqa: RUF012 -- as Gymnasium has it
        "render_modes": ["rgb_array", "human"],
        "render_fps": 100,
        "autoreset_mode": AutoresetMode.SAME_STEP,
    }

    def __init__(
        self,
        task: Task | type[Task] | str = "Hover",
        num_envs: int = 1,
        render_mode: str | None = None,
        threads: int | None = None,
        bank_seed: int = 0,
        **changes: Any,
    ) -> None:
        """Build the world.

        Args:
            task: A task, its class or its name.
            num_envs: Number of flights.
            render_mode: ``rgb_array`` or ``human``, of the first flight; None cannot be seen, and is faster.
            threads: Threads that share the drones, for the whole process; None leaves the number as it is.
            bank_seed: Of the variants of the drone.
            **changes: Fields of the task that differ, such as ``rate_hz=50``.

        Raises:
            RangeError: If a value is outside its range.
            UnknownNameError: If there is no such task or field.
        """
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise RangeError(f"render_mode is {render_mode!r}, allowed: None, rgb_array, human")
        self.task = task_of(task, changes)
        """What is to be learned."""
        if self.task.camera is not None and render_mode is not None and num_envs > 1:
            # drones that can be seen by the one can be seen by the other
            raise RangeError(f"render_mode is {render_mode!r} with a camera and {num_envs} flights, allowed: None")
        self.flights = Flights(self.task, num_envs, threads, bank_seed, visuals=render_mode is not None)
        """The engine: readings, memory, world."""
        self.num_envs = num_envs
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": self.task.rate_hz}
        self.single_observation_space = observation_space(self.task)
        self.single_action_space = action_space(self.task)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._picture = Picture(self.flights.world, self.flights.world.drones[0].id) if render_mode else None

    def reset(
        self, *, seed: int | Sequence[int] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode in all flights.

        Args:
            seed: Flight i gets ``seed + i``, or the i-th of a list; None goes on with the next episode of each.
            options: ``reset_mask``, booleans of shape (N,): only these flights begin again.

        Raises:
            RangeError: If a seed or an option is outside its range.
        """
        mask = self._mask(options)
        if seed is not None:
            numbers = np.arange(self.num_envs) + seed if isinstance(seed, int | np.integer) else np.asarray(seed)
            self.flights.seed(numbers)
        self.flights.start(np.flatnonzero(mask))
        if self.render_mode == "human":
            self.render()
        return observations(self.flights), {}

    def _mask(self, options: dict[str, Any] | None) -> NDArray[np.bool_]:
        unknown = set(options or ()) - {"reset_mask"}
        if unknown:
            raise RangeError(f"reset: options name {', '.join(sorted(map(str, unknown)))}, allowed: reset_mask")
        mask = np.asarray((options or {}).get("reset_mask", np.ones(self.num_envs, bool)))
        if mask.shape != (self.num_envs,) or mask.dtype != bool:
            raise RangeError(f"reset: reset_mask has shape {mask.shape}, allowed: ({self.num_envs},) of booleans")
        return mask

    def step(
        self, actions: ArrayLike
    ) -> tuple[Any, NDArray[np.float32], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Fly on by one action of each flight, shape (N, A), in [-1, 1].

        Raises:
            RangeError: If the shape is another, or a number is not finite; nothing has flown then.
        """
        rewards, terminated, truncated = self.flights.step(actions)
        infos: dict[str, Any] = {}
        is_done = terminated | truncated
        if is_done.any():
            infos = {"final_obs": observations(self.flights), "_final_obs": is_done}
            self.flights.start(np.flatnonzero(is_done))
        if self.render_mode == "human":
            self.render()
        return observations(self.flights), rewards, terminated, truncated, infos

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Return a picture that follows the first flight, shape (height, width, 3); ``human`` shows it in a window."""
        picture = None if self._picture is None else self._picture.render(self.render_mode)
        return None if picture is None else (picture,)

    def close_extras(self, **kwargs: Any) -> None:
        """Close the window."""
        del kwargs
        if self._picture is not None:
            self._picture.close()
