"""Many futures of one world at once, in C threads: `mujoco.batch` with the onboard software in the loop."""

from __future__ import annotations

from functools import partial
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import CrazychoirError, RangeError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.simulation.drone import Drone
from crazychoir_fw.simulation.snapshot import Snapshot
from crazychoir_fw.simulation.world import World


class Episodes:
    """Copies of a world, from the present instant on, that are stepped together.

    They have no agenda, no scene of their own and no viewer: commands, parameters and logs of each drone work
    between two calls of `run`. A row costs the state of its world, 22 KiB per drone, and nothing else.
    """

    def __init__(self, world: World, count: int, threads: int = 0) -> None:
        """Prepare episodes.

        Args:
            world: Where they start; it stays as it is.
            count: How many there are.
            threads: C threads that share them, the calling one included; 0 is one per processor.

        Raises:
            RangeError: If a number is outside its range.
            CrazychoirError: If this MuJoCo has no batches.
        """
        if not (isinstance(count, int) and count >= 1):
            raise RangeError(f"Episodes: count is {count!r}, allowed: 1 or more")
        if not (isinstance(threads, int) and threads >= 0):
            raise RangeError(f"Episodes: threads is {threads!r}, allowed: 0 or more")
        try:
            from mujoco.batch import Batch
        except ImportError:
            raise CrazychoirError(
                f"MuJoCo {mujoco.__version__} has no batches, MuJoCo 4 (Python 3.11) has; `World.fork` works with both"
            ) from None

        self._world = world
        self._start = world.snapshot()
        # MuJoCo keeps more than the state of a body that sleeps
        sleeps = bool(world.model.opt.enableflags & mujoco.mjtEnableBit.mjENBL_SLEEP)
        self.batch = Batch(world.model, count, threads, persistent=sleeps)
        """The batch of MuJoCo: its rows are the worlds, for `bind`, `expand` and whatever else it can do."""
        self.batch.state[:] = self._start.state
        self._rows: list[tuple[Drone, ...] | None] = [None] * count
        self._journals = [self._start.journal] * count

    def __len__(self) -> int:
        return len(self._rows)

    def __repr__(self) -> str:
        return f"<{len(self)} episodes of {len(self._world.drones)} drones at {self.time:.3f} s>"

    @property
    def time(self) -> float:
        """Simulated time of the first episode (s)."""
        return float(self.batch.bind("time")[0])

    def drones(self, episode: int) -> tuple[Drone, ...]:
        """Return the drones of an episode, to be commanded between two calls of `run`."""
        row = self._rows[episode]
        if row is None:
            # what a handle looks at of mjData, here views of the row
            names = ("qpos", "qvel", "qacc", "eq_active", "plugin_state")
            data: Any = SimpleNamespace(**{name: self.batch.bind(name)[episode] for name in names})
            drones = tuple(Drone(self._world.model, data, drone.config) for drone in self._world.drones)
            self._journals[episode] = self._journals[episode].copy()
            for number, drone in enumerate(drones):
                drone.uplink.listeners.append(partial(self._write_down, episode, number))
            row = self._rows[episode] = drones
        return row

    def _write_down(self, episode: int, drone: int, verb: str, arguments: tuple[Any, ...]) -> None:
        tick = round(float(self.batch.bind("time")[episode]) * TICKS_PER_SECOND)
        self._journals[episode].add(tick, drone, verb, arguments)

    def run(self, seconds: float) -> None:
        """Let all episodes go on, rounded to whole steps of the scene; Python does nothing meanwhile.

        Raises:
            RangeError: If the time is negative or not finite.
        """
        if not (np.isfinite(seconds) and seconds >= 0):
            raise RangeError(f"run({seconds}): allowed: 0 s or more")
        self.batch.step(nstep=round(seconds / self._world.model.opt.timestep))

    def positions(self) -> NDArray[np.float64]:
        """Return the true positions of all drones (m, world), shape (episodes, N, 3)."""
        places = np.array([drone.qpos_address for drone in self._world.drones])[:, None] + np.arange(3)
        return self.batch.bind("qpos")[:, places]

    def snapshot(self, episode: int) -> Snapshot:
        """Return an episode as a snapshot: ``world.restore(episodes.snapshot(best))`` goes on with it.

        Events of its own it has none.
        """
        state = self.batch.state[episode].copy()
        time = float(self.batch.bind("time")[episode])
        start = self._start
        beside = start.beside
        if self.batch.persistent:
            beside = {name: self.batch.bind(name)[episode].copy() for name in start.beside}
        return Snapshot(state, beside, start.fingerprint, time, start.events, self._journals[episode].copy())
