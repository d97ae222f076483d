"""A world: one MuJoCo model with its drones, stepped at 1 kHz."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.common.user_code import installed
from crazychoir_fw.onboard.core import register_plugin
from crazychoir_fw.recording.journal import Journal
from crazychoir_fw.simulation.builder import WORTH_IT, build_model, compile_model, give_back_memory
from crazychoir_fw.simulation.cameras import Camera, Cameras
from crazychoir_fw.simulation.drone import Drone
from crazychoir_fw.simulation.drone_config import DroneConfig
from crazychoir_fw.simulation.faults import Fault, FaultSchedule
from crazychoir_fw.simulation.mirrored import MirroredConfig
from crazychoir_fw.simulation.model_doubts import model_doubts
from crazychoir_fw.simulation.model_drones import drones_in
from crazychoir_fw.simulation.motor_ctrl.pilots import Pilots
from crazychoir_fw.simulation.provider_words import load_apps, load_providers
from crazychoir_fw.simulation.recipe import write_recipe
from crazychoir_fw.simulation.snapshot import Snapshot, put, take
from crazychoir_fw.simulation.world_base import WorldBase

SERVERS = "crazychoir.servers"
"""Entry points by which installed packages offer servers of worlds."""

SETTLE_S = 2.0
"""Time (s) that the filter of a drone needs which must find its place by light or radio."""


class World(WorldBase):
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
            is_replay: The world is to be flown from a journal. What sends requests of its own accord looks at
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
        model, data = _model_with_data(with_apps, scene, seed, visuals, mirrored)
        in_scene = drones_in(model, {drone.id for drone in with_apps}, Path(scene).parent)
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

    def _set_up(self, configs: Sequence[DroneConfig], scene: str, seed: int, visuals: bool, *rest: Any) -> None:
        """Bind to a model and its data, see `WorldBase`; a fork does the same with those of another world."""
        super()._set_up(configs, scene, seed, visuals, *rest)
        self._cameras = Cameras(self.model, self.data, self.agenda, visuals)
        for drone in self.drones:
            drone.cameras = self._cameras
        self.faults = FaultSchedule(self)
        """What goes wrong, and when."""
        self.when_forked: list[Callable[[World], None]] = []
        """Called with every fork, to make in it what lives on the agenda or listens to drones."""

    @classmethod
    def from_mjcf(cls, path: str | Path, seed: int = 0, threads: int | None = None) -> World:
        """Make a world of an MJCF file with Crazyflies in it: bodies with the engine plugin.

        Drones are called as their bodies; the attributes of their plugins set type and controller.

        Args:
            path: The model.
            seed: Seed of the noise of drones whose attributes have none.
            threads: Threads that share the drones, for the whole process; None leaves the number as it is.

        Raises:
            RangeError: If the model does not compile, or has no Crazyflie; the message says why.
            UnknownNameError: If there is no such file, or no such motor control.
        """
        return cls([], scene=path, seed=seed, threads=threads)

    def doubts(self) -> list[str]:
        """Return sentences about what of the model is hardly meant: a second drag, no floor below a drone."""
        return model_doubts(self.model, self.data, [drone.id for drone in self.drones])

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
        except where `when_forked` does so. Motor controls begin again.

        Each may be stepped in a thread of its own.

        Raises:
            RangeError: If the count is no positive number.
        """
        if not (isinstance(count, int) and count >= 1):
            raise RangeError(f"fork({count!r}): allowed: 1 or more worlds")
        return [self._fork() for _ in range(count)]

    def _fork(self) -> World:
        other = type(self).__new__(type(self))
        # a copy of mjData holds more than its state: whatever was computed last is there as well
        chosen = (self.configs, self.scene, self.seed, self.visuals, self.is_replay)
        mirrored = [body.config for body in self.mirrored.values()]
        other._set_up(*chosen, self.model, copy.copy(self.data), self.fingerprint, mirrored)
        other.events = list(self.events)
        other.journal = self.journal.copy()
        other.agenda.seek(self.tick)
        other.when_forked = list(self.when_forked)
        for drone, original in zip(other.drones, self.drones, strict=True):
            drone.commander.set_client_xmode(original.commander.is_client_xmode)
        other.faults.go_on_from(self.faults)
        other._pilots = Pilots(other)
        for carry_over in self.when_forked:
            carry_over(other)
        return other

    def release(self) -> None:
        """Give back the memory of model, data and drones at once, where the garbage collector would do it later.

        Neither the world nor its drones can be used afterwards.
        """
        for drone in self.drones:
            vars(drone.uplink).clear()  # its handlers hold the model
            vars(drone).clear()
        vars(self).clear()

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

    def serve(self, *args: Any, **options: Any) -> Any:
        """Return a server of all drones, so that the unmodified cflib flies them; to be used in a with statement.

        The server is a package above the simulation, which offers it as the entry point ``crtp`` of the group
        `SERVERS`. `crazychoir_fw.crtp.server.Server` lists arguments and errors.
        """
        server = installed(SERVERS, "crtp", "a server of worlds")
        return server(self, *args, **options)

    def render(
        self, width: int = 960, height: int = 540, camera: str = "follow", overlays: bool = False
    ) -> NDArray[np.uint8]:
        """Return a picture of the present instant, shape (height, width, 3).

        Args:
            width: Width of the picture (pixels).
            height: Height of the picture (pixels).
            camera: ``follow`` sees all drones; ``fpv:NAME`` and ``chase:NAME`` those of a drone; else the name of a
                camera of the model.
            overlays: Whether to show names, and ghosts at the targets of the drones.

        Raises:
            RenderingError: If there is no OpenGL on this machine.
            ValueError: If there is no such camera.
        """
        # imported here, since the import takes longer than a flight and only pictures need it
        from crazychoir_fw.recording.picture import picture
        from crazychoir_fw.simulation.targets import Targets

        names = [drone.id for drone in self.drones] if overlays else None
        targets = Targets(self.drones).positions() if overlays else None
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


def _model_with_data(*chosen: Any) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = build_model(*chosen)
    try:
        return model, mujoco.MjData(model)
    except mujoco.FatalError:  # a copied model has values that the compiler refuses in a sentence
        model = compile_model(*chosen)
        return model, mujoco.MjData(model)


def _was_failed_by_its_pilot(drone: Drone) -> bool:
    """Whether the motor control of a drone has stopped it, so that no wait for it ends."""
    return drone.motor_ctrl is not None and drone.failure is not None


def set_threads(count: int) -> int:
    """Set how many threads of this process share the drones of a world. Returns the number in force."""
    if not (isinstance(count, int) and 1 <= count <= lib.CF_MAX_THREADS):
        raise RangeError(f"threads is {count!r}, allowed: 1 to {lib.CF_MAX_THREADS}")
    return int(lib.cf_threads_set(count))
