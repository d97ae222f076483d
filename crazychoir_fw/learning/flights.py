"""N flights of one task side by side, in one world: arrays in, arrays out.

This is all that the environments of Gymnasium and PettingZoo wrap; it needs neither. Drones do not see each other, and
what a flight draws depends on its seed and the number of its episode alone: a flight is the same, bit for bit, with any
number of others beside it and at any number of threads.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.learning.prepared_starts import PreparedStarts
from crazychoir_fw.learning.reading import Floats, Motion, Reading
from crazychoir_fw.learning.start_bank import StartBank
from crazychoir_fw.learning.swarm_port import SwarmPort
from crazychoir_fw.learning.tasks.task import Task
from crazychoir_fw.onboard.core import check
from crazychoir_fw.simulation import World


class Flights:
    """Flights of a task, stepped together."""

    def __init__(
        self, task: Task, count: int = 1, threads: int | None = None, bank_seed: int = 0, visuals: bool = False
    ) -> None:
        """Build the world, and let the patterns of all episodes take off.

        Args:
            task: What is to be learned.
            count: Number of flights.
            threads: Threads that share the drones, for the whole process; None leaves the number as it is.
            bank_seed: Of the variants of the drone (`StartBank`).
            visuals: Whether drones can be seen, for pictures. Not a bit of a flight changes.

        Raises:
            RangeError: If a value is outside its range; the text says which.
        """
        if isinstance(count, bool) or not isinstance(count, int) or count < 1:
            raise RangeError(f"flights: count is {count!r}, allowed: 1 or more")
        self.task = task
        """What is to be learned."""
        self.bank = StartBank(task, bank_seed)
        """Drones from which episodes begin."""
        drones = [task.drone_config(f"drone{number}") for number in range(count)]
        self.world = World(drones, scene=task.scene, seed=0, threads=threads, visuals=visuals)
        """The world of all flights."""
        self.world.stop_journal("learners keep none")
        # up to 100 drones a world solves contacts by Newton's method: a flight must not depend on their number
        self.world.model.opt.solver = mujoco.mjtSolver.mjSOL_CG
        self._take_pictures = None if task.camera is None else task.camera.mount(self.world)
        self.port = SwarmPort(self.world)
        """Their memory as arrays."""
        self.scale = task.action.scale(task.platform)
        """From actions to commands."""
        model = self.world.model
        self._bodies = np.array([model.body(drone.id).id for drone in self.world.drones])
        self._starts = PreparedStarts(task, count, len(self.bank))
        self._steps = np.zeros(count, np.int64)
        self._plan = np.zeros((count, task.plan_size))
        self._action = np.zeros((count, task.action.size), np.float32)
        self._previous = np.zeros_like(self._action)
        self._changes_plans = type(task).advance is not Task.advance
        self._for_c = self._describe()
        self._status = ffi.new("cf_status_t *")
        self.reading: Reading
        """What is known of all flights after the latest step or start."""
        every = np.arange(count, dtype=np.int32)
        self._make_heavy(every, np.zeros_like(every))
        self.start(every)

    def __len__(self) -> int:
        return len(self._steps)

    @property
    def plan(self) -> NDArray[np.float64]:
        """What the task knows of each episode, shape (N, k)."""
        return self._plan

    # --------------------------------------------------------------------------------------- starts

    def seed(self, seeds: ArrayLike) -> None:
        """Give each flight a seed, shape (N,); its episodes count from 0 again.

        Raises:
            RangeError: If a seed is negative, or their number is not that of the flights.
        """
        numbers = np.asarray(seeds)
        if numbers.shape != (len(self),) or numbers.min(initial=0) < 0:
            raise RangeError(f"seed: {seeds!r} for {len(self)} flights, allowed: one seed of 0 or more each")
        self._starts.seed(numbers.astype(np.uint64))

    def start(self, which: ArrayLike) -> None:
        """Begin the next episode of some flights, by their numbers; `reading` is up to date."""
        if self.begin(which):
            self.reading = self._read()

    def begin(self, which: ArrayLike) -> bool:
        """Begin the next episode of some flights, and leave `reading` as it was; return whether there are any."""
        chosen = np.ascontiguousarray(which, np.int32)
        if not len(chosen):
            return False
        if len(chosen) == len(self):
            # the looks around of the onboard software go by simulated time
            self.world.data.time = 0.0
        self._starts.prepare(chosen)
        if self.bank.differs_in_mass:
            self._make_heavy(chosen, self._starts.next_patterns(chosen))
        begun = lib.cf_start_flights(self._for_c, ffi.from_buffer("int32_t[]", chosen), len(chosen), self._status)
        if begun < len(chosen):
            refused = self._starts.next_starts(chosen[begun:])[0]
            check(self._status[0], f"{type(self.task).__name__}: start {refused}")
        return True

    def _describe(self) -> Any:
        """Return the ``cf_flights_t`` of these flights; its arrays stay where they are."""
        starts, port = self._starts, self.port

        def numbers(array: NDArray[Any], kind: str = "double") -> Any:
            return ffi.cast(f"{kind} *", array.ctypes.data)

        return ffi.new(
            "cf_flights_t *",
            {
                "drones": port.structs,
                "patterns": self.bank.structs,
                "starts": numbers(starts.rows),
                "start_size": starts.rows.shape[1],
                "plan_size": self._plan.shape[1],
                "ahead": starts.ahead,
                "action_size": self._action.shape[1],
                "episodes": numbers(starts.episodes, "int64_t"),
                "steps": numbers(self._steps, "int64_t"),
                "plans": numbers(self._plan),
                "actions": numbers(self._action, "float"),
                "previous_actions": numbers(self._previous, "float"),
                "qpos": numbers(port.qpos),
                "qvel": numbers(port.qvel),
                "qpos_stride": port.qpos.strides[0] // port.qpos.itemsize,
                "qvel_stride": port.qvel.strides[0] // port.qvel.itemsize,
            },
        )

    def _make_heavy(self, chosen: NDArray[np.int32], patterns: NDArray[np.int32]) -> None:
        model, bodies = self.world.model, self._bodies[chosen]
        model.body_mass[bodies] = model.body_subtreemass[bodies] = self.bank.masses[patterns]
        model.body_inertia[bodies], model.body_iquat[bodies] = self.bank.inertias[patterns], self.bank.frames[patterns]

    # ---------------------------------------------------------------------------------------- steps

    def step(self, actions: ArrayLike) -> tuple[Floats, NDArray[np.bool_], NDArray[np.bool_]]:
        """Fly on by one action each.

        Args:
            actions: In [-1, 1], shape (N, A); numbers beyond count as the nearer end.

        Returns:
            Rewards, which flights have ended early, and which have reached their time, each of shape (N,). `reading`
            is that of the end of the step; `start` begins new episodes.

        Raises:
            RangeError: If the shape is another, or a number is not finite; nothing has flown then.
        """
        action = self._checked(actions)
        task = self.task
        self._previous[:] = self._action
        self._action[:] = action
        task.action.write(self.port, self.scale.of(action), self.reading)
        self.world.step_motion(task.ticks)
        self._steps += 1
        reading = self._read()
        bonus = task.advance(self._plan, reading)
        self.reading = reading
        is_over = task.is_over(reading)
        reward = task.reward(reading) + bonus - np.float32(task.end_cost) * is_over
        if self._changes_plans:
            reading.reference = task.reference(self._plan, self._seconds())
        is_late = (self._steps >= task.steps) & ~is_over
        return np.asarray(reward, np.float32), is_over, is_late

    def _seconds(self) -> NDArray[np.float64]:
        return np.asarray(self._steps * (1.0 / self.task.rate_hz), np.float64)

    def _checked(self, actions: ArrayLike) -> Floats:
        try:
            action = np.array(actions, np.float32)
        except (TypeError, ValueError):
            raise RangeError(f"action is {actions!r}, allowed: numbers of shape {self._action.shape}") from None
        if action.shape != self._action.shape:
            raise RangeError(f"action has shape {action.shape}, allowed: {self._action.shape}")
        if not np.isfinite(action).all():
            row, column = np.argwhere(~np.isfinite(action))[0]
            raise RangeError(f"action: number {column} of flight {row} is {action[row, column]}, allowed: -1 to 1")
        return np.clip(action, np.float32(-1.0), np.float32(1.0))

    def _read(self) -> Reading:
        port, task = self.port, self.task
        seconds = self._seconds()
        found = port.read(task.ticks)
        return Reading(
            estimate=Motion(*(found[name].copy() for name in ("position", "velocity", "rotation", "rates"))),
            truth=port.truth(),
            specific_force=found["specific_force"].copy(),
            ranges=port.ranges(),
            battery_voltage=found["battery_voltage"].copy(),
            is_out=found["is_out"] != 0,
            is_touching=found["is_touching"] != 0,
            reference=task.reference(self._plan, seconds),
            action=self._action.copy(),
            previous_action=self._previous.copy(),
            seconds=seconds.astype(np.float32),
        )

    def observe(self) -> Floats:
        """Return what policies see, shape (N, k)."""
        return self.task.observation.of(self.reading)

    def see(self) -> NDArray[Any] | None:
        """Return the pictures of the task's camera, shape (N, height, width[, 3]), or None.

        Raises:
            RenderingError: If there is no OpenGL on this machine.
        """
        return None if self._take_pictures is None else self._take_pictures()

    def observe_critic(self) -> Floats | None:
        """Return what critics see, shape (N, k), or None."""
        return None if self.task.critic is None else self.task.critic.of(self.reading)
