"""Where the drones of a mission with layers are: simulated, integrated, real, or some of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from crazychoir_fw.common.errors import CrazychoirError, MissionError
from crazychoir_fw.flight.agents import masses_of, names_of, starts_of
from crazychoir_fw.flight.backend import Backend
from crazychoir_fw.flight.odometry import MocapPoses
from crazychoir_fw.flight.runner import READY_TIMEOUT, build_world, turn_on_radios
from crazychoir_fw.mission.schema import LayeredMission

if TYPE_CHECKING:
    from crazychoir_fw.flight.integrator_backend import IntegratorBackend
    from crazychoir_fw.flight.sim_backend import SimBackend
    from crazychoir_fw.simulation.mirrored import MirroredConfig


def make_backend(mission: LayeredMission, threads: int | None = None, visuals: bool = False) -> Backend:
    """Return the backend of a mission, its drones ready to fly.

    Raises:
        CrazychoirError: If it cannot be made as the mission says.
    """
    if mission.backend == "hardware":
        from crazychoir_fw.flight.real_drones import over_the_radio

        return over_the_radio(mission)
    if mission.backend == "mixed":
        from crazychoir_fw.flight.real_drones import mixed_reality

        return mixed_reality(mission, partial(_sim, mission, threads, visuals))
    return {"sim": _sim, "integrator": _integrator}[mission.backend](mission, threads, visuals)


def _sim(
    mission: LayeredMission, threads: int | None, visuals: bool, mirrored: Sequence[MirroredConfig] = ()
) -> SimBackend:
    """Return the simulated drones of a mission: those that are not mirrored."""
    from crazychoir_fw.flight.sim_backend import SimBackend, truth

    world = build_world(mission, threads, visuals, mirrored)
    radio = turn_on_radios(mission, world)
    world.wait_until_ready(timeout_s=READY_TIMEOUT)
    for number, entry in enumerate(mission.faults):
        try:
            world.add_fault(replace(entry.fault, at=round(entry.fault.at + world.time, 6)))
        except CrazychoirError as error:
            raise MissionError(f"faults[{number}].{entry.name}: {error}") from None
    odometry = mission.layers.odometry
    backend = SimBackend(world, "estimate" if odometry == "estimate" else "truth", mission.log_rate)
    if odometry == "mocap":
        backend.read_poses = MocapPoses(truth(world), mission.seed)
    backend.radio = radio
    return backend


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
