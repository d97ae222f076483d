"""A world: one MuJoCo model with its drones, stepped at 1 kHz."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import RangeError, StateError, UnknownNameError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.onboard.core import register_plugin
from crazychoir_fw.recording.journal import Journal
from crazychoir_fw.simulation.builder import build_model
from crazychoir_fw.simulation.cameras import Camera, Cameras
from crazychoir_fw.simulation.clients import Param
from crazychoir_fw.simulation.clients.swarm_uplink import SwarmUplink
from crazychoir_fw.simulation.collisions import Collisions
from crazychoir_fw.simulation.drone import Drone
from crazychoir_fw.simulation.drone_config import DroneConfig
from crazychoir_fw.simulation.event_scheduler import EventScheduler
from crazychoir_fw.simulation.events import Event
from crazychoir_fw.simulation.faults import Fault, FaultSchedule
from crazychoir_fw.simulation.fingerprint import Fingerprint, fingerprint
from crazychoir_fw.simulation.fork import fork
from crazychoir_fw.simulation.heap import WORTH_IT, give_back_memory
from crazychoir_fw.simulation.mirrored import MirroredConfig, mirrored_bodies
from crazychoir_fw.simulation.model_drones import drones_in
from crazychoir_fw.simulation.motor_ctrl.pilots import Pilots
from crazychoir_fw.simulation.provider_words import load_apps, load_providers
from crazychoir_fw.simulation.recipe import write_recipe
from crazychoir_fw.simulation.snapshot import Snapshot, put, take

if TYPE_CHECKING:
    from crazychoir_fw.crtp.link_model import Link
    from crazychoir_fw.crtp.server import Server

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
        is_replay: bool = False,
        mirrored: Sequence[MirroredConfig] = (),
    ) -> None:
        """Build the world.

        Args:
            drones: The drones; names must differ.
            scene: A name of `crazychoir_fw.mujoco_models.SCENES`, such as ``arena`` or ``room``, or the path of an MJCF
                file. Crazyflies in it come after `drones`.
            seed: Seed of all noise; same seed and same commands give the same bits.
            threads: Threads that share the drones, for the whole process; None leaves the number as it is.
            visuals: False leaves out what is only seen, a tenth of the cost of a swarm; not a bit of a flight changes.
            faults: What is to go wrong, see `add_fault`.
            is_replay: The world is to be flown from a journal. Whoever would send requests of its own accord looks at
                `World.is_replay` and stays away.
            mirrored: Bodies that are moved from outside, such as real drones, see `World.mirrored`.

        Raises:
            RangeError: If a value is outside its range; the message names drone, value and range.
            UnknownNameError: If there is no such scene, platform, provider or onboard parameter.
            BuildError: If an app or a provider does not compile.
        """
        register_plugin()
        if threads is not None:
            set_threads(threads)
        with_apps = load_apps(drones)
        load_providers((drone.provider, drone.platform) for drone in with_apps)
        model = build_model(with_apps, scene, seed, visuals, mirrored)
        in_scene = drones_in(model, {drone.id for drone in with_apps}, Path(scene).parent)
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        self._set_up([*with_apps, *in_scene], str(scene), seed, visuals, is_replay, model, data, None, mirrored)
        self._set_parameters()
        # what was set until here comes with the configurations
        self.journal = Journal(write_recipe(drones, scene, seed, self.fingerprint))
        self._pilots = Pilots(self)
        for fault in faults:
            self.add_fault(fault)
        if len(with_apps) >= WORTH_IT:
            give_back_memory()

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
        """Take possession of a model and its data; a fork does the same with those of another world."""
        self.configs = tuple(configs)
        self.scene = scene
        self.seed = seed
        self.visuals = visuals
        self.model = model
        self.data = data
        self._watched: dict[str, Param] = {}  # parameters that somebody listens to
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
        self._cameras = Cameras(model, data, self.agenda, visuals)
        for drone in self.drones:
            drone.cameras = self._cameras
        self.faults = FaultSchedule(self)
        """What goes wrong, and when."""
        self.when_forked: list[Callable[[World], None]] = []
        """Called with every fork, to make anew in it what lives on the agenda or listens to drones."""
        self._steps_per_tick = max(1, round(0.001 / model.opt.timestep))
        self._ticks_per_step = max(1, round(model.opt.timestep / 0.001))

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

    @classmethod
    def from_mjcf(cls, path: str | Path, seed: int = 0, threads: int | None = None) -> World:
        """Make a world of an MJCF file with Crazyflies in it: bodies with the engine plugin.

        Drones are called as their bodies; the attributes of their plugins say what they are, and who flies them.

        Args:
            path: The model.
            seed: Seed of the noise of drones whose attributes have none.
            threads: Threads that share the drones, for the whole process; None leaves the number as it is.

        Raises:
            RangeError: If the model does not compile, or has no Crazyflie; the message says why.
            UnknownNameError: If there is no such file, or no such motor control.
        """
        return cls([], scene=path, seed=seed, threads=threads)

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

    def note(self, kind: str, drone: str | None = None, *, at: float | None = None, **details: Any) -> None:
        """Remember that something happened, at the present instant or `at` an earlier time (s).

        `details` are what JSON can hold.
        """
        self.events.append(Event(round(self.time if at is None else at, 9), kind, drone, details))

    def add_fault(self, fault: Fault) -> None:
        """Let something go wrong: a motor, a sensor, the radio, …, at a simulated time.

        Raises:
            RangeError: If its time is over, or it is no fault.
            UnknownNameError: If it names a drone that does not exist.
            StateError: If a drone cannot have it, such as one that has no payload to drop.
        """
        if not isinstance(fault, Fault):
            raise RangeError(f"add_fault({fault!r}): allowed: a Fault, such as Kick or MotorFault")
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
        self._collisions.note_new(self.note)

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
        while not all(drone.can_fly or _was_failed_by_its_pilot(drone) for drone in self.drones):
            if self.time >= deadline:
                late = next(drone for drone in self.drones if not (drone.can_fly or _was_failed_by_its_pilot(drone)))
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
        self._pilots.begin()

    def _time_has_changed(self) -> None:
        """Forget what will happen again, and expect it."""
        self.agenda.seek(self.tick)
        self._collisions.forget()
        self.events = [event for event in self.events if event.time <= self.time]
        self.journal = self.journal.begin_again()

    def _set_parameters(self) -> None:
        """Set the onboard parameters that the drones were configured with."""
        for drone in self.drones:
            for name, value in drone.config.parameters.items():
                drone.param[name] = value

    def stop_journal(self, why: str = "none was kept") -> None:
        """Write no requests down, now and in the future, for a world that is flown for days; it cannot be replayed.

        Args:
            why: What replay says of a record of this world.
        """
        self.journal.stop(why)

    def snapshot(self) -> Snapshot:
        """Return everything that the world is now: time, motion, every byte of every drone, events, journal.

        It can be saved to a file and restored in another process.
        """
        return take(self.model, self.data, self.fingerprint, tuple(self.events), self.journal)

    def restore(self, snapshot: Snapshot) -> None:
        """Make the world what it was, or what another one like it was. The agenda stays as it is.

        Raises:
            RangeError: If the snapshot is one of another world; the message says in what it differs. Or if it comes
                from a file, and a number that C relies on is out of its range.
        """
        put(snapshot, self.model, self.data, self.fingerprint, self._check_memory)
        self.agenda.seek(self.tick)
        self._collisions.forget()
        self.events = list(snapshot.events)
        before = self.journal
        self.journal = snapshot.journal.copy()
        self.journal.recipe = before.recipe
        if not before.is_kept and before.gap is not None:
            self.journal.stop(before.gap)
        self._pilots.restored()

    def _check_memory(self, plugin_state: NDArray[np.float64]) -> None:
        for drone in self.drones:
            drone.check_memory(plugin_state)

    def fork(self, count: int = 1) -> list[World]:
        """Return worlds that go on from the present instant, independent of this one and of each other.

        They share the compiled model. Drones, events, journal, faults and everything in `mjData` are carried over.
        What else stands on the agenda, requests on their way through a bad radio, and callbacks of parameters are not,
        except where `when_forked` does so. Motor controls begin anew.

        Each may be stepped in a thread of its own.

        Raises:
            RangeError: If the count is no positive number.
        """
        return fork(self, count)

    def camera(
        self,
        name: str | None = None,
        width: int | None = None,
        height: int | None = None,
        *,
        position: ArrayLike | None = None,
        look_at: ArrayLike = (0.0, 0.0, 0.5),
        fov_deg: float | None = None,
    ) -> Camera:
        """Return a camera that stands in the room; `Drone.camera` returns those on board and behind a drone.

        Args:
            name: A camera of the scene (``<camera name="...">``), or None for one at `position`.
            width: Width of its pictures (pixels), 640 by default.
            height: Height of its pictures (pixels), 360 by default.
            position: Where it stands (m, world), shape (3,).
            look_at: What is in the middle of its pictures (m, world), shape (3,).
            fov_deg: Angle between the lower and the upper edge of the picture; by default that of the scene.

        Raises:
            RangeError: If there is neither a name nor a position, or a value is outside its range.
            UnknownNameError: If the scene has no such camera.
        """
        if (name is None) == (position is None):
            raise RangeError("camera: give either the name of a camera of the scene or a position")
        if name is not None:
            return self._cameras.in_room(name, width, height, fov_deg)
        return self._cameras.anywhere(position, look_at, width, height, fov_deg)

    def serve(
        self,
        host: str = "127.0.0.1",
        port: int = 19850,
        speed: float | None = 1.0,
        link: Link | None = None,
        *,
        newest_client_wins: bool = False,
        relax_after_session: bool = True,
        silence: float = 1.0,
        storage: str | Path | None = None,
        reads_ahead: bool = True,
    ) -> Server:
        """Return a server of all drones, so that the unmodified cflib flies them; to be used in a with statement.

        Each drone has its own UDP port: `port`, the next one, and so on in the order of `drones`
        (``udp://127.0.0.1:19850``). `Server.run` lets time go on; who steps the world instead has lockstep.

        Args:
            host: Address of this machine to listen at; whoever reaches it can fly the drones.
            port: Port of the first drone; 0 takes any free ones, see `Server.uris`.
            speed: Simulated seconds per second in `Server.run`; 0 or None is as fast as possible.
            link: What packets go through; by default nothing is late or lost.
            newest_client_wins: Whether a second client takes a drone from the first, instead of waiting for it.
            relax_after_session: Whether the high-level commander has a drone back when its client has gone.
            silence: Time (s) without a packet after which a client has gone.
            storage: Folder of the parameters that clients store on their drones; None keeps them for as long as the
                world lives.
            reads_ahead: Whether a client that downloads a table of contents is sent the next items unasked, and drones
                are read in turns, which halves the time that a swarm takes to connect; never through a link.

        Raises:
            RangeError: If a value is outside its range.
            StateError: If the world is flown from a journal. (Taken ports are told when the server starts.)
        """
        # the radio is a layer above, and only for those who have clients
        from crazychoir_fw.crtp.server import Server

        return Server(
            self,
            host,
            port,
            speed,
            link,
            newest_client_wins=newest_client_wins,
            relax_after_session=relax_after_session,
            silence=silence,
            storage=storage,
            reads_ahead=reads_ahead,
        )

    def render(
        self, width: int = 960, height: int = 540, camera: str = "follow", overlays: bool = False
    ) -> NDArray[np.uint8]:
        """Return a picture of the present instant, shape (height, width, 3).

        Args:
            width: Width of the picture (pixels).
            height: Height of the picture (pixels).
            camera: ``follow`` sees all drones; ``fpv:NAME`` and ``chase:NAME`` those of a drone; else the name of a
                camera of the model.
            overlays: Whether to show names, and as ghosts where the drones are told to be.

        Raises:
            RenderingError: If there is no OpenGL on this machine.
            ValueError: If there is no such camera.
        """
        # drawing is for those who look: importing it takes longer than a flight
        from crazychoir_fw.recording.video import picture
        from crazychoir_fw.simulation.targets import Targets

        names = [drone.id for drone in self.drones] if overlays else None
        targets = Targets(self).positions() if overlays else None
        return picture(
            self.model,
            self.data,
            self.positions(),
            camera=camera,
            width=width,
            height=height,
            names=names,
            targets=targets,
        )


def _was_failed_by_its_pilot(drone: Drone) -> bool:
    """Whether nobody need wait for a drone: its motor control has stopped it, and it alone."""
    return drone.motor_ctrl is not None and drone.failure is not None


def set_threads(count: int) -> int:
    """Set how many threads of this process share the drones of a world. Returns the number in force."""
    if not (isinstance(count, int) and 1 <= count <= lib.CF_MAX_THREADS):
        raise RangeError(f"threads is {count!r}, allowed: 1 to {lib.CF_MAX_THREADS}")
    return int(lib.cf_threads_set(count))
