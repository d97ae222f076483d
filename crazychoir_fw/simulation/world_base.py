"""What stands behind every world: a model with its data, drones, one clock, events and a journal."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.recording.journal import Journal
from crazychoir_fw.simulation.clients import Param
from crazychoir_fw.simulation.clients.swarm_uplink import SwarmUplink
from crazychoir_fw.simulation.collisions import Collisions
from crazychoir_fw.simulation.drone import Drone
from crazychoir_fw.simulation.drone_config import DroneConfig
from crazychoir_fw.simulation.event_scheduler import EventScheduler
from crazychoir_fw.simulation.events import Event
from crazychoir_fw.simulation.fingerprint import Fingerprint, fingerprint
from crazychoir_fw.simulation.mirrored import MirroredConfig, mirrored_bodies


class WorldBase:
    """Drones that are stepped, as faults and motor controls see them; `World` builds it and adds the rest."""

    def _set_up(
        self,
        configs: Sequence[DroneConfig],
        scene: str,
        seed: int,
        visuals: bool,
        is_replay: bool,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        known: Fingerprint | None = None,
        mirrored: Sequence[MirroredConfig] = (),
    ) -> None:
        """Bind to a model and its data."""
        self.configs = tuple(configs)
        self.scene = scene
        self.seed = seed
        self.visuals = visuals
        self.model = model
        self.data = data
        self._watched: dict[str, Param] = {}  # parameters with callbacks
        self.drones = tuple(Drone(model, data, config, self._watched) for config in configs)
        self._by_id = {drone.id: drone for drone in self.drones}
        self.mirrored = mirrored_bodies(model, data, mirrored)
        """Bodies that are moved from outside, by name."""
        self.fingerprint = known or fingerprint(model, dict.fromkeys(drone.provider_number for drone in self.drones))
        """What the world is; worlds with equal ones understand each other's snapshots."""
        self.is_replay = is_replay
        """Whether its requests come from a journal."""
        self.journal = Journal()
        """Every request so far, and how to build the world."""
        for number, drone in enumerate(self.drones):
            drone.uplink.listeners.append(partial(self._write_down, number))
        self._swarm_uplink = SwarmUplink(self.drones)
        self.agenda = EventScheduler()
        """What happens at simulated times: faults, plugins, replays."""
        self.events: list[Event] = []
        """What has happened so far."""
        self._collisions = Collisions(model, data)
        self._model_address, self._data_address = model._address, data._address
        self._clock = lib.cf_plugin_clock(data._address)  # a tenth of the time that `data.time` takes
        self._steps_per_tick = max(1, round(0.001 / model.opt.timestep))
        self._ticks_per_step = max(1, round(model.opt.timestep / 0.001))

    def __repr__(self) -> str:
        return f"<World {self.scene} with {len(self.drones)} drones at {self.time:.3f} s>"

    def __getitem__(self, drone_id: str) -> Drone:
        if drone_id not in self._by_id:
            raise UnknownNameError(f"no drone named '{drone_id}', there are: {', '.join(self._by_id)}")
        return self._by_id[drone_id]

    @property
    def time(self) -> float:
        """Simulated time (s)."""
        return float(self._clock[0])

    @property
    def tick(self) -> int:
        """Whole milliseconds since the start."""
        return round(self._clock[0] * TICKS_PER_SECOND)

    def note(self, kind: str, drone: str | None = None, *, at: float | None = None, **details: Any) -> None:
        """Remember that something happened, at the present instant or `at` an earlier time (s).

        `details` are what JSON can hold.
        """
        self.events.append(Event(round(self.time if at is None else at, 9), kind, drone, details))

    def step(self, n_ticks: int = 1) -> None:
        """Advance by whole milliseconds.

        Raises:
            RangeError: If that is no whole number of the scene's time steps.
        """
        if n_ticks < 0 or n_ticks % self._ticks_per_step:
            raise RangeError(f"step({n_ticks}): allowed: 0 or more ticks, a multiple of {self._ticks_per_step}")
        agenda, tick = self.agenda, self.tick
        agenda.keep(tick)
        tick, end = self.tick, tick + n_ticks
        while tick < end:
            # appointments between two steps of the scene are kept after the later one
            ticks = agenda.next_stop(end) - tick
            self._advance(-(-ticks // self._ticks_per_step) * self._ticks_per_step)
            agenda.keep(self.tick)
            tick = self.tick
        if self._watched:
            for param in list(self._watched.values()):
                param.report_changes()

    def _advance(self, n_ticks: int) -> None:
        """Let MuJoCo and all drones go on for whole milliseconds.

        While nothing can touch anything, the plugin makes steps without MuJoCo, which change no bit.
        """
        self._advance_motion(n_ticks)
        self._collisions.note_new(self.note)

    def step_motion(self, n_ticks: int) -> None:
        """Advance by whole milliseconds like `step`, and leave out what only others look at.

        Motion and drones are those of `step`, bit for bit. Appointments of the agenda wait for the end, collisions are
        not noted, and no parameter is watched. For learners, which step a world a thousand times a second.

        Raises:
            RangeError: If that is no whole number of the scene's time steps.
        """
        if n_ticks < 0 or n_ticks % self._ticks_per_step:
            raise RangeError(f"step_motion({n_ticks}): allowed: 0 or more ticks, a multiple of {self._ticks_per_step}")
        self._advance_motion(n_ticks)
        self.agenda.keep(self.tick)

    def _advance_motion(self, n_ticks: int) -> None:
        left = n_ticks * self._steps_per_tick // self._ticks_per_step
        self._complete(left, lib.cf_plugin_window(self._model_address, self._data_address, left))

    def _complete(self, left: int, flown: int) -> None:
        """Make the rest of so many steps, of which the plugin has made `flown`, see `_advance_by_mujoco`."""
        model, data = self._model_address, self._data_address
        if flown < left:
            lib.cf_plugin_overlap(model, data, True)
            try:
                self._advance_by_mujoco(left, flown)
            finally:
                lib.cf_plugin_overlap(model, data, False)

    def _advance_by_mujoco(self, left: int, flown: int) -> None:
        """Make so many steps, of which the plugin has made `flown`, or asks MuJoCo for as many if that is negative."""
        while True:
            if flown < 0:
                mujoco.mj_step(self.model, self.data, nstep=min(-flown, left))
            left -= abs(flown)
            if left <= 0:
                return
            flown = lib.cf_plugin_window(self._model_address, self._data_address, left)

    def rounds_alone(self, ticks: int, count: int) -> int:
        """Return how many rounds of so many ticks, at most `count`, can be flown before Python has something to do."""
        if self._watched or ticks % self._ticks_per_step:
            return 0
        tick = self.tick
        return max(0, (self.agenda.next_stop(tick + ticks * count + 1) - tick - 1) // ticks)

    def fly_and_sample(self, ticks: int, count: int, sampler: Any, row: int) -> tuple[int, float]:
        """Fly and sample rounds that `rounds_alone` found, in one call of the core.

        Args:
            ticks: Of a round.
            count: How many rounds.
            sampler: What a sample reads and where it goes, a ``cf_sampler_t``.
            row: Number of the next sample there.

        Returns:
            How many samples were taken, and the wall time of that (s). They are fewer where a contact began, a drone
            failed, or MuJoCo had to make steps: the world has then flown the round behind the last sample.
        """
        steps = ticks * self._steps_per_tick // self._ticks_per_step
        done = lib.cf_fly_and_sample(
            self._model_address, self._data_address, steps, count, sampler, row, len(self.journal)
        )
        if done.flown != steps:
            self._complete(steps, done.flown)
        self._collisions.note_new(self.note)
        self.agenda.keep(self.tick)
        return done.samples, done.sampling

    def run(self, seconds: float) -> None:
        """Advance by seconds, rounded to whole milliseconds."""
        if not (np.isfinite(seconds) and seconds >= 0):
            raise RangeError(f"run({seconds}): allowed: 0 s or more")
        self.step(round(seconds * TICKS_PER_SECOND))

    def positions(self) -> NDArray[np.float64]:
        """Return the true positions of all drones (m, world), shape (N, 3)."""
        return np.array([drone.true_position for drone in self.drones])

    def _write_down(self, drone: int, verb: str, arguments: tuple[Any, ...]) -> None:
        self.journal.add(self.tick, drone, verb, arguments)

    def send_setpoints(self, drones: Sequence[int], setpoints: bytes) -> None:
        """Send a setpoint each to several drones, in one call: see `SwarmUplink`.

        Args:
            drones: Their numbers.
            setpoints: A ``setpoint_t`` for each, one behind the other.

        Raises:
            RangeError: If a number in one is not finite.
            StateError: If a drone has failed.
        """
        self._swarm_uplink.send_setpoints(drones, setpoints, self.journal, self.tick)

    def stop_journal(self, why: str = "none was kept") -> None:
        """Write no requests down, now and in the future, for a world that is flown for days; it cannot be replayed.

        Args:
            why: What replay says of a record of this world.
        """
        self.journal.stop(why)
