"""The keys of a mission that say how real drones are seen: by motion capture, and in a simulated world."""

from __future__ import annotations

from typing import Annotated, Any

from crazychoir_fw.common.constraints import choice, number, switch, whole, word
from crazychoir_fw.mission.section import Section

MOCAP_SYSTEMS = (
    "udp",
    "ros",
    "vicon",
    "optitrack",
    "optitrack_closed_source",
    "qualisys",
    "nokov",
    "vrpn",
    "motionanalysis",
)
"""Where poses come from: JSON by UDP, topics of ROS 2, or what the package motioncapture knows."""


class MocapSettings(Section):
    """Motion capture that sees real drones."""

    system: Annotated[str, choice(*MOCAP_SYSTEMS)]
    """`udp` (JSON in datagrams), `ros` (geometry_msgs/PoseStamped, `mocap` of each drone is then a topic), or a system
    that the package motioncapture knows: `vicon`, `optitrack`, `qualisys`, `nokov`, `vrpn`, ..."""

    host: Annotated[str, word(r"[\w.:-]{1,253}", "a host name or an address")] = "127.0.0.1"
    """Computer of the system; for `udp`, the address to listen on."""

    port: Annotated[int, whole(0, 65535)] = 19900
    """Of `udp`."""


class MixedSettings(Section):
    """How the backend `mixed` shows real drones in the simulated world."""

    likeness: Annotated[str, choice("drone", "sphere")] = "drone"
    """What they look like: a green `drone` of their platform, or a green `sphere`."""

    collides: Annotated[bool, switch()] = False
    """Whether simulated drones can hit them; the real ones feel nothing of it."""

    stale_s: Annotated[float, number(0.05, 10.0, "s")] = 0.5
    """Age at which a pose from motion capture counts as unknown (s): the body stays then, and is reported as stale."""


def is_real(drone: Any) -> bool:
    """Tell whether a drone of the backend `mixed` is real."""
    return drone.uri is not None or drone.mocap is not None


def real_part(mission: Any) -> Any:
    """Return a mission of the backend `mixed` with those of its drones only that are reached by radio.

    It is what stands in for them when there are none: served by another process.
    """
    if mission.backend != "mixed":
        return mission
    drones = [entry for entry, drone in zip(entries_of(mission), mission.fleet, strict=True) if drone.uri is not None]
    copy = mission.model_copy(update={"drones": drones, "faults": []})
    copy.__dict__.pop("fleet", None)  # the copy brings along what the original had decided
    return copy


def entries_of(mission: Any) -> list[Any]:
    """Return the drones of a mission as a list, also where they are a layout."""
    return list(mission.drones.entries() if hasattr(mission.drones, "entries") else mission.drones)
