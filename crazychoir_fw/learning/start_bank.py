"""Drones that fly already, from which episodes begin: each is a variant of the drone of a task.

They boot, take off and hover once, in a world of their own; then an episode begins by a copy of one of them
(`bindings/flight_start.h`), which takes some microseconds where a boot takes 1.6 s of simulated time.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from crazychoir_fw._core import ffi
from crazychoir_fw.common.errors import StateError
from crazychoir_fw.learning.tasks.task import Task
from crazychoir_fw.learning.variation import read_vary, varied
from crazychoir_fw.simulation import DroneConfig, World

HOVER_HEIGHT = 1.0
"""Height at which the patterns hover (m)."""

PHASE = 40
"""Ticks: all rates of the onboard loops, and of policies from 25 Hz on, begin a round at multiples of it."""


class StartBank:
    """The patterns of a task."""

    def __init__(self, task: Task, seed: int = 0) -> None:
        """Let the patterns take off.

        Args:
            task: Its drone, `vary` and `variants`.
            seed: Of what varies, and of turn-on errors of sensors.

        Raises:
            RangeError: If the task cannot be built; the text says why.
            StateError: If a variant does not hover, for instance because its motors are too weak.
        """
        vary = read_vary(task.vary) if task.vary else {}
        base = task.drone_config("pattern")
        drones = []
        for number in range(task.variants):
            fields = varied(base, vary, number, seed)
            drones.append(DroneConfig(**{**fields, "id": f"pattern{number}", "position": (0.0, 0.0, None)}))
            drones[-1].attributes = {**drones[-1].attributes, "isolated": "on"}  # they hover at one place
        self.world = World([replace(drone, motor_ctrl=None) for drone in drones], seed=seed, visuals=False)
        self.world.stop_journal("patterns of episodes keep none")
        self._take_off()
        self.structs = ffi.new("cf_t *[]", [drone.struct for drone in self.world.drones])
        """The patterns for C."""
        model = self.world.model
        bodies = [model.body(drone.id).id for drone in self.world.drones]
        self.masses = model.body_mass[bodies]
        """Of each (kg), shape (V,)."""
        self.inertias = model.body_inertia[bodies]
        """About the principal axes (kg m^2), shape (V, 3)."""
        self.frames = model.body_iquat[bodies]
        """Of the principal axes, as quaternions (w, x, y, z), shape (V, 4)."""
        every = np.column_stack([self.masses, self.inertias, self.frames])
        self.differs_in_mass = bool((every != every[0]).any())
        """Whether the bodies of two patterns differ."""

    def __len__(self) -> int:
        return len(self.world.drones)

    def _take_off(self) -> None:
        world = self.world
        world.wait_until_ready()
        for drone in world.drones:
            drone.high_level_commander.takeoff(HOVER_HEIGHT, 1.5)
        world.run(3.0)
        for drone in world.drones:
            height = float(drone.true_position[2])
            if not drone.is_flying or abs(height - HOVER_HEIGHT) > 0.5:
                raise StateError(
                    f"learning: variant {drone.id} does not hover: height {height:.2f} m, '{drone.supervisor_state}'"
                )
        # drones boot together, so that all of them begin a round of their loops at once
        world.step(-int(world.drones[0].struct.onboard.step) % PHASE)
