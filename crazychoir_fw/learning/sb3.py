"""All flights as a vector environment of Stable-Baselines3: ``PPO("MlpPolicy", Sb3Flights("Hover", 256))``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import MissingLibraryError
from crazychoir_fw.learning.tasks.task import Task
from crazychoir_fw.learning.vector_env import FlightVectorEnv

try:
    from stable_baselines3.common.vec_env import VecEnv
except ImportError:
    raise MissingLibraryError(
        "Stable-Baselines3 is not installed; pip install 'crazychoir-fw[train]' installs it"
    ) from None


class Sb3Flights(VecEnv):
    """A `FlightVectorEnv` with the interface of Stable-Baselines3."""

    def __init__(self, task: Task | type[Task] | str = "Hover", num_envs: int = 256, **options: Any) -> None:
        """Build the world; arguments as of `FlightVectorEnv`."""
        self.vector = FlightVectorEnv(task, num_envs, **options)
        """The environment within."""
        super().__init__(num_envs, self.vector.single_observation_space, self.vector.single_action_space)
        self._actions: NDArray[np.float32] | None = None
        self._returns = np.zeros(num_envs)
        self._lengths = np.zeros(num_envs, int)

    def reset(self) -> Any:
        """Begin an episode in all flights; with the seeds of `seed`, if it was called since the last time."""
        given = [seed for seed in self._seeds if seed is not None]
        observation, _ = self.vector.reset(seed=given if len(given) == self.num_envs else None)
        self._reset_seeds()
        self._returns[:], self._lengths[:] = 0.0, 0
        return observation

    def step_async(self, actions: NDArray[np.float32]) -> None:
        """Keep the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[Any, NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Fly on by one action of each flight."""
        observation, rewards, terminated, truncated, found = self.vector.step(self._actions)
        is_done = terminated | truncated
        self._returns += rewards
        self._lengths += 1
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for number in np.flatnonzero(is_done):
            last = found["final_obs"]
            infos[number] = {
                "terminal_observation": {k: v[number] for k, v in last.items()}
                if isinstance(last, dict)
                else last[number],
                "TimeLimit.truncated": bool(truncated[number]),
                "episode": {"r": float(self._returns[number]), "l": int(self._lengths[number])},
            }
        self._returns[is_done], self._lengths[is_done] = 0.0, 0
        return observation, rewards, is_done, infos

    def close(self) -> None:
        """Close the window, if there is one."""
        self.vector.close()

    def get_attr(self, attr_name: str, indices: int | Sequence[int] | None = None) -> list[Any]:
        """Return an attribute of the environment, once per flight."""
        return [getattr(self.vector, attr_name, None)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: int | Sequence[int] | None = None) -> None:
        """Set an attribute of the environment."""
        del indices
        setattr(self.vector, attr_name, value)

    def env_method(
        self, method_name: str, *args: Any, indices: int | Sequence[int] | None = None, **kwargs: Any
    ) -> list[Any]:
        """Call a method of the environment, once."""
        found = getattr(self.vector, method_name)(*args, **kwargs)
        return [found] * len(list(self._get_indices(indices)))

    def env_is_wrapped(self, wrapper_class: Any, indices: int | Sequence[int] | None = None) -> list[bool]:
        """Return False for each: nothing is wrapped."""
        del wrapper_class
        return [False] * len(list(self._get_indices(indices)))

    def get_images(self) -> list[NDArray[np.uint8] | None]:
        """Return the picture of the first flight, and none of the others."""
        picture = self.vector.render()
        return [picture[0] if picture else None] + [None] * (self.num_envs - 1)
