"""A world: one MuJoCo model with its drones, stepped at 1 kHz."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import lib
from crazychoir_fw.core import register_plugin
from crazychoir_fw.errors import RangeError, StateError, UnknownNameError
from crazychoir_fw.simulation.agenda import Agenda
from crazychoir_fw.simulation.builder import build_model
from crazychoir_fw.simulation.clients import Param
from crazychoir_fw.simulation.drone import Drone
from crazychoir_fw.simulation.drone_config import DroneConfig
from crazychoir_fw.simulation.events import Event
from crazychoir_fw.simulation.faults import Fault, FaultSchedule
from crazychoir_fw.simulation.provider_words import load_apps, load_providers

TICKS_PER_SECOND = 1000
SETTLE_S = 2.0
"""Time (s) that the filter of a drone needs which must find its place by light or radio."""


class World:
    """Drones in a scene. Time advances only through `step` and `run`."""

    def __init__(
        self,
        drones: Sequence[DroneConfig],
        scene: str | Path = "arena",
        seed: int = 0,
        threads: int | None = None,
        visuals: bool = True,
        faults: Iterable[Fault] = (),
    ) -> None:
        """Build the world.

        Args:
            drones: The drones; names must differ.
            scene: ``arena``, ``flight_lab`` or the path of an MJCF file.
            seed: Seed of all noise; same seed and same commands give the same bits.
            threads: Threads that share the drones, for the whole process; None leaves the number as it is.
            visuals: False leaves out what is only seen, a tenth of the cost of a swarm; not a bit of a flight changes.
            faults: What is to go wrong, see `add_fault`.

        Raises:
            RangeError: If a value is outside its range; the message names drone, value and range.
            UnknownNameError: If there is no such scene, platform, provider or onboard parameter.
            BuildError: If an app or a provider does not compile.
        """
        register_plugin()
        if threads is not None:
            set_threads(threads)
        drones = load_apps(drones)
        load_providers((drone.provider, drone.platform) for drone in drones)
        self.seed = seed
        self.scene = str(scene)
        self.model = build_model(drones, scene, seed, visuals)
        self.data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)
        self._watched: dict[str, Param] = {}  # parameters that somebody listens to
        self.drones = tuple(Drone(self.model, self.data, config, self._watched) for config in drones)
        self._by_id = {drone.id: drone for drone in self.drones}
        self._set_parameters()
        self.agenda = Agenda()
        """What happens at simulated times: faults, plugins, replays."""
        self.events: list[Event] = []
        """What has happened so far."""
        self.faults = FaultSchedule(self)
        """What goes wrong, and when."""
        self._steps_per_tick = max(1, round(0.001 / self.model.opt.timestep))
        self._ticks_per_step = max(1, round(self.model.opt.timestep / 0.001))
        for fault in faults:
            self.add_fault(fault)

    def __repr__(self) -> str:
        return f"<World {self.scene} with {len(self.drones)} drones at {self.time:.3f} s>"

    def __getitem__(self, drone_id: str) -> Drone:
        if drone_id not in self._by_id:
            raise UnknownNameError(f"no drone named '{drone_id}', there are: {', '.join(self._by_id)}")
        return self._by_id[drone_id]

    @property
    def time(self) -> float:
        """Simulated time (s)."""
        return float(self.data.time)

    @property
    def tick(self) -> int:
        """Whole milliseconds since the start."""
        return round(self.data.time * TICKS_PER_SECOND)

    def note(self, kind: str, drone: str | None = None, **details: Any) -> None:
        """Remember that something happened at the present instant; `details` are what JSON can hold."""
        self.events.append(Event(self.time, kind, drone, details))

    def add_fault(self, fault: Fault) -> None:
        """Let something go wrong: a motor, a sensor, the radio, …, at a simulated time.

        Raises:
            RangeError: If its time is over.
            UnknownNameError: If it names a drone that does not exist.
            StateError: If a drone cannot have it, such as one that has no payload to drop.
        """
        self.faults.add(fault)

    def step(self, n_ticks: int = 1) -> None:
        """Advance by whole milliseconds.

        Raises:
            RangeError: If that is no whole number of the scene's time steps.
        """
        if n_ticks < 0 or n_ticks % self._ticks_per_step:
            raise RangeError(f"step({n_ticks}): allowed: 0 or more ticks, a multiple of {self._ticks_per_step}")
        self.agenda.keep(self.tick)
        end = self.tick + n_ticks
        while self.tick < end:
            # appointments between two steps of the scene are kept after the later one
            ticks = self.agenda.next_stop(end) - self.tick
            self._advance(-(-ticks // self._ticks_per_step) * self._ticks_per_step)
            self.agenda.keep(self.tick)
        for param in list(self._watched.values()):
            param.report_changes()

    def _advance(self, n_ticks: int) -> None:
        """Let MuJoCo and all drones go on for whole milliseconds."""
        model, data = self.model._address, self.data._address
        lib.cf_plugin_overlap(model, data, True)
        try:
            mujoco.mj_step(self.model, self.data, nstep=n_ticks * self._steps_per_tick // self._ticks_per_step)
        finally:
            lib.cf_plugin_overlap(model, data, False)

    def run(self, seconds: float) -> None:
        """Advance by seconds, rounded to whole milliseconds."""
        if not (np.isfinite(seconds) and seconds >= 0):
            raise RangeError(f"run({seconds}): allowed: 0 s or more")
        self.step(round(seconds * TICKS_PER_SECOND))

    def wait_until_ready(self, timeout_s: float = 5.0) -> None:
        """Advance until every drone can fly; drones that must be armed are armed as soon as they can be.

        A drone needs about 1.6 s: sensors start after 1 s, the gyro bias takes 0.5 s, then come the supervisor's
        pre-flight checks. With a lighthouse or loco deck among them it takes 2 s more, in which their filters find out
        where they are.

        Raises:
            StateError: If a drone is not ready in time; the message names it and its state.
        """
        deadline = self.time + timeout_s
        while not all(drone.can_fly for drone in self.drones):
            if self.time >= deadline:
                late = next(drone for drone in self.drones if not drone.can_fly)
                raise StateError(f"{late.id}: not ready after {timeout_s} s, state '{late.supervisor_state}'")
            self.run(0.02)
            for drone in self.drones:
                if drone.can_arm:
                    drone.arm()
        if any(drone.param[deck] for drone in self.drones for deck in ("deck.bcLighthouse4", "deck.bcLoco")):
            self.run(SETTLE_S)

    def positions(self) -> NDArray[np.float64]:
        """Return the true positions of all drones (m, world), shape (N, 3)."""
        return np.array([drone.true_position for drone in self.drones])

    def reset(self) -> None:
        """Go back to the start: time 0, drones booting at their start poses."""
        mujoco.mj_resetData(self.model, self.data)
        mujoco.mj_forward(self.model, self.data)
        self._set_parameters()
        self._time_has_changed()

    def _time_has_changed(self) -> None:
        """Forget what will happen again, and expect it."""
        self.agenda.seek(self.tick)
        self.events = [event for event in self.events if event.time <= self.time]

    def _set_parameters(self) -> None:
        """Set the onboard parameters that the drones were configured with."""
        for drone in self.drones:
            for name, value in drone.config.parameters.items():
                drone.param[name] = value

    def snapshot(self) -> NDArray[np.float64]:
        """Return the whole state of the world: time, motion and every byte of every drone."""
        spec = mujoco.mjtState.mjSTATE_INTEGRATION
        state = np.empty(mujoco.mj_stateSize(self.model, spec))
        mujoco.mj_getState(self.model, self.data, state, spec)
        return state

    def restore(self, snapshot: NDArray[np.float64]) -> None:
        """Make the world what it was."""
        spec = mujoco.mjtState.mjSTATE_INTEGRATION
        if snapshot.shape != (mujoco.mj_stateSize(self.model, spec),):
            raise RangeError(f"snapshot of shape {snapshot.shape} belongs to another world")
        mujoco.mj_setState(self.model, self.data, snapshot, spec)
        self._time_has_changed()

    def render(self, width: int = 960, height: int = 540, camera: str = "follow") -> NDArray[np.uint8]:
        """Return a picture of the present instant, shape (height, width, 3).

        Args:
            width: Width of the picture (pixels).
            height: Height of the picture (pixels).
            camera: ``follow`` sees all drones; else the name of a camera of the model.

        Raises:
            RenderingError: If there is no OpenGL on this machine.
            ValueError: If there is no such camera.
        """
        # drawing is for those who look: importing it takes longer than a flight
        from crazychoir_fw.report.video import picture

        return picture(self.model, self.data, self.positions(), camera=camera, width=width, height=height)


def set_threads(count: int) -> int:
    """Set how many threads of this process share the drones of a world. Returns the number in force."""
    if not (isinstance(count, int) and 1 <= count <= lib.CF_MAX_THREADS):
        raise RangeError(f"threads is {count!r}, allowed: 1 to {lib.CF_MAX_THREADS}")
    return int(lib.cf_threads_set(count))
