"""The backends of a mission whose drones are real, all of them or some: `hardware` and `mixed`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from crazychoir_fw.flight.agents import is_only_watched, masses_of, names_of, starts_of
from crazychoir_fw.flight.hardware_backend import HardwareBackend
from crazychoir_fw.flight.mixed_backend import MixedBackend
from crazychoir_fw.flight.pose_forwarder import PoseForwarder
from crazychoir_fw.flight.roll_call import Part, roll_call
from crazychoir_fw.flight.watched_backend import WatchedBackend
from crazychoir_fw.mission.mixed import is_real
from crazychoir_fw.mocap.sources import MotionCapture, PoseSource, UdpPoses, installed_source

if TYPE_CHECKING:
    from crazychoir_fw.flight.backend import Backend
    from crazychoir_fw.flight.sim_backend import SimBackend
    from crazychoir_fw.mission.schema import LayeredMission
    from crazychoir_fw.simulation.mirrored import MirroredConfig

MakeSimulated = Callable[[Sequence["MirroredConfig"]], "SimBackend"]
"""Makes the simulated drones in a world with such mirrored bodies."""


def over_the_radio(mission: LayeredMission) -> Backend:
    """Return the backend `hardware`, once all drones have said where they are.

    Raises:
        CrazychoirError: If drones or motion capture are not reached.
    """
    source = _mocap(mission, range(len(mission.fleet)))
    numbers = list(range(len(mission.fleet)))
    backend = _radio(mission, numbers, mission.layers.commands[0], source)
    backend.radio_parts = [(numbers, backend)]
    backend.before_flight = partial(roll_call, mission, backend.radio_parts)
    return backend


def radio_parts(mission: LayeredMission) -> list[Part]:
    """Return the drones of a mission that are flown over the radio, once all of them have said where they are.

    Raises:
        CrazychoirError: If drones or motion capture are not reached.
    """
    numbers = [i for i, drone in enumerate(mission.fleet) if drone.uri is not None and not is_only_watched(mission, i)]
    source, parts = _mocap(mission, numbers), []
    try:
        for kind, those in _by_kind(mission, numbers).items():
            parts.append((those, _radio(mission, those, kind, source)))
    except BaseException:
        for _, backend in parts:
            backend.close()
        raise
    return parts


def mixed_reality(mission: LayeredMission, simulated: MakeSimulated) -> MixedBackend:
    """Return the backend `mixed`, its simulated drones ready, once all real drones have said where they are.

    Args:
        mission: The mission.
        simulated: Makes the simulated drones.

    Raises:
        CrazychoirError: If drones or motion capture are not reached, or the world cannot be built.
    """
    count = len(mission.fleet)
    real = [i for i in range(count) if is_real(mission.fleet[i])]
    watched = [i for i in real if is_only_watched(mission, i)]
    by_kind = _by_kind(mission, [i for i in real if i not in watched])
    world = simulated([_likeness(mission, i) for i in real])
    source = _mocap(mission, real)
    parts: list[Backend] = []
    flown: list[Part] = []
    try:
        for kind, numbers in by_kind.items():
            flown.append((numbers, _radio(mission, numbers, kind, source)))
            parts.append(flown[-1][1])
        if watched:
            parts.append(_watched(mission, watched, source))
        backend = MixedBackend(names_of(mission), world, parts)
        backend.radio_parts = flown
        backend.before_flight = partial(roll_call, mission, flown)
        backend.look()
    except BaseException:
        for part in parts:
            part.close()
        raise
    return backend


def _by_kind(mission: LayeredMission, numbers: Iterable[int]) -> dict[str, list[int]]:
    """Return the numbers of commanded drones by the kind of command that their controllers send."""
    by_kind: dict[str, list[int]] = {}
    for i in numbers:
        control = mission.layers.control_of(mission.fleet[i].id)
        by_kind.setdefault("xyz" if control is None else control.command, []).append(i)
    return by_kind


def _watched(mission: LayeredMission, numbers: list[int], source: PoseSource | None) -> WatchedBackend:
    """Return the part of the drones that motion capture sees and nothing here commands."""
    assert source is not None
    bodies = {mission.fleet[i].id: mission.fleet[i].mocap for i in numbers}
    masses = [masses_of(mission)[i] for i in numbers]
    return WatchedBackend(bodies, source, masses=masses, stale_s=mission.mixed.stale_s)  # type: ignore[arg-type]


def _likeness(mission: LayeredMission, i: int) -> MirroredConfig:
    from crazychoir_fw.simulation.mirrored import SPHERE, MirroredConfig

    drone, how = mission.fleet[i], mission.mixed
    likeness = SPHERE if how.likeness == "sphere" else drone.platform
    return MirroredConfig(drone.id, tuple(starts_of(mission)[i]), likeness, collides=how.collides)


def _mocap(mission: LayeredMission, drones: Iterable[int]) -> PoseSource | None:
    """Return the motion capture of a mission; None unless one of these drones is tracked by it."""
    settings = mission.hardware.mocap
    bodies = [mission.fleet[i].mocap for i in drones if mission.fleet[i].mocap is not None]
    if settings is None or not bodies:
        return None
    if settings.system == "udp":
        return UdpPoses(settings.port, settings.host)
    if settings.system == "ros":
        return installed_source("ros")(bodies)
    return MotionCapture(settings.system, settings.host)


def _radio(mission: LayeredMission, numbers: list[int], kind: str, source: PoseSource | None) -> HardwareBackend:
    settings = mission.hardware
    options: dict[str, Any] = dict(settings.radio)
    if settings.safety_area is not None:
        from crazychoir_fw.radio import SafetyArea

        box = settings.safety_area
        options["safety_area"] = SafetyArea(box.low, box.high, breach=box.breach)
    drones = [mission.fleet[i] for i in numbers]
    if kind in ("fpqr", "frpy"):
        options.setdefault("thrust", {drone.id: drone.platform for drone in drones})
    masses = masses_of(mission)
    backend = HardwareBackend(
        {drone.id: drone.uri for drone in drones},  # type: ignore[misc]
        kind,
        masses=[masses[i] for i in numbers],
        odometry_hz=settings.odometry_hz,
        **options,
    )
    try:
        told = {drone.mocap: backend.handler[drone.id].external_pose for drone in drones if drone.mocap is not None}
        if source is not None and told:
            forwarder = PoseForwarder(source, told)  # type: ignore[arg-type]
            backend.when_closed += [forwarder.close, source.close]
        backend.wait_for_poses()
    except BaseException:
        backend.close()
        raise
    return backend
