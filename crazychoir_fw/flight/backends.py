"""Where the drones of a mission are: simulated, integrated, real, or some of each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from crazychoir_fw.common.errors import CrazychoirError, MissionError
from crazychoir_fw.flight.agents import masses_of, names_of, starts_of
from crazychoir_fw.flight.backend import Backend
from crazychoir_fw.flight.odometry import MocapPoses
from crazychoir_fw.mission.fleet import drone_settings
from crazychoir_fw.mission.schema import LayeredMission, Mission

if TYPE_CHECKING:
    from crazychoir_fw.crtp.link_model import SimulatedRadios
    from crazychoir_fw.flight.integrator_backend import IntegratorBackend
    from crazychoir_fw.flight.sim_backend import SimBackend
    from crazychoir_fw.simulation import World
    from crazychoir_fw.simulation.mirrored import MirroredConfig

READY_TIMEOUT = 10.0
"""Longest time until all drones are ready to fly (s, simulated)."""


def make_backend(mission: Mission, threads: int | None = None, visuals: bool = False) -> Backend:
    """Return the backend of a mission; drones that layers fly are ready, others get ready in their flight.

    Raises:
        CrazychoirError: If it cannot be made as the mission says.
    """
    return _MAKERS[mission.backend](mission, threads, visuals)  # type: ignore[arg-type]


# -------------------------------------------------------------------------------- simulated worlds


def build_world(
    mission: Mission,
    threads: int | None = None,
    visuals: bool = True,
    mirrored: Sequence[MirroredConfig] = (),
) -> World:
    """Return the world of a mission with its drones on the floor, but for those that are mirrored."""
    from crazychoir_fw.simulation import DroneConfig, World

    elsewhere = {body.id for body in mirrored}
    drones = [DroneConfig(**drone_settings(drone)) for drone in mission.fleet if drone.id not in elsewhere]
    return World(drones, scene=mission.scene, seed=mission.seed, threads=threads, visuals=visuals, mirrored=mirrored)


def simulated_radios(mission: Mission) -> SimulatedRadios | None:
    """Return the radios of a mission, if it has any."""
    if not mission.radios:
        return None
    from crazychoir_fw.crtp.link_model import SimulatedRadios

    return SimulatedRadios(mission.radios, [drone.id for drone in mission.fleet], mission.seed)


def add_faults(mission: Mission, world: World) -> list[dict[str, Any]]:
    """Let go wrong what is to, counted from now; returns what was planned, in times of the world.

    Raises:
        MissionError: If a drone cannot have it.
    """
    planned = []
    for number, entry in enumerate(mission.faults):
        fault = replace(entry.fault, at=round(entry.fault.at + world.time, 6))
        with _about_fault(number, entry.name):
            world.add_fault(fault)
        planned.append(fault.as_dict())
    return planned


@contextmanager
def _about_fault(number: int, name: str) -> Iterator[None]:
    try:
        yield
    except CrazychoirError as error:
        raise MissionError(f"faults[{number}].{name}: {error}") from None


def _sim(mission: Mission, threads: int | None, visuals: bool, mirrored: Sequence[MirroredConfig] = ()) -> SimBackend:
    """Return the simulated drones of a mission: those that are not mirrored."""
    from crazychoir_fw.flight.sim_backend import SimBackend, truth

    world = build_world(mission, threads, visuals, mirrored)
    for number, entry in enumerate(mission.faults):
        with _about_fault(number, entry.name):
            world.faults.check(entry.fault)
    radio, radios = None, simulated_radios(mission)
    if radios is not None:
        from crazychoir_fw.crtp.link_model.flight_radio import FlightRadio

        radio = FlightRadio(world, radios)
    if mission.layers is None:
        backend = SimBackend(world)
    else:
        world.wait_until_ready(timeout_s=READY_TIMEOUT)
        faults, odometry = add_faults(mission, world), mission.layers.odometry
        backend = SimBackend(world, "estimate" if odometry == "estimate" else "truth", mission.log_rate)
        backend.faults = faults
        if odometry == "mocap":
            backend.read_poses = MocapPoses(truth(world), mission.seed)
    backend.radio = radio
    return backend


# -------------------------------------------------------------------------------- point masses


def _integrator(mission: LayeredMission, threads: int | None, visuals: bool) -> IntegratorBackend:
    from crazychoir_fw.flight.integrator_backend import IntegratorBackend
    from crazychoir_fw.simulation.integrator import RandomForce

    settings = mission.integrator
    disturbance = None
    if settings.disturbance is not None:
        given = settings.disturbance
        disturbance = RandomForce(given.sigma, given.time_constant, mission.seed)
    platforms = {drone.platform for drone in mission.fleet}
    if len(platforms) > 1:
        raise MissionError(
            f"backend integrator flies one platform at a time, but there are {', '.join(sorted(platforms))}"
        )
    backend = IntegratorBackend(
        names_of(mission),
        starts_of(mission),
        yaw=np.radians([drone.yaw_deg for drone in mission.fleet]),
        mass=masses_of(mission),
        platform=platforms.pop(),
        drag=settings.drag,
        disturbance=disturbance,
    )
    if mission.layers.odometry == "mocap":
        backend.read_poses = MocapPoses(backend.read_poses, mission.seed)
    return backend


# -------------------------------------------------------------------------------- real drones


def _hardware(mission: LayeredMission, threads: int | None, visuals: bool) -> Backend:
    del threads, visuals
    from crazychoir_fw.flight.real_drones import over_the_radio

    return over_the_radio(mission)


def _mixed(mission: LayeredMission, threads: int | None, visuals: bool) -> Backend:
    from crazychoir_fw.flight.real_drones import mixed_reality

    return mixed_reality(mission, partial(_sim, mission, threads, visuals))


_MAKERS = {"sim": _sim, "integrator": _integrator, "hardware": _hardware, "mixed": _mixed}
