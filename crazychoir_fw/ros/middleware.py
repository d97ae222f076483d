"""What the middleware is told before rclpy wakes it: to stay on this machine, and to share no memory."""

from __future__ import annotations

import os
from collections.abc import MutableMapping
from pathlib import Path

_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_PROFILES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
_LOOPBACK = Path(__file__).with_name("loopback.xml")


def stay_on_this_machine(environment: MutableMapping[str, str] = os.environ) -> None:
    """Choose how the participants of this process, and of those that it starts, find and reach others.

    Drones of somebody else on the same network should not hear ours: wider discovery is a choice, by
    ``ROS_AUTOMATIC_DISCOVERY_RANGE``. Its ``LOCALHOST`` still makes Fast DDS listen to every network, and share memory
    with locks in it: a process that is killed while it holds one holds up all others for seconds, and leaves its memory
    behind for ever. So Fast DDS is confined to loopback by a profile instead. Flights take as long, up to a tenth more
    or less; others on this machine find them as before.

    Args:
        environment: Where that is written; what its user has chosen is left alone.
    """
    if _RANGE in environment:
        return
    # the profile is known to confine Jazzy's Fast DDS; anything else is told in the words of ROS
    is_known = environment.get("ROS_DISTRO", "jazzy") == "jazzy" and environment.get(
        "RMW_IMPLEMENTATION", "rmw_fastrtps_cpp"
    ).startswith("rmw_fastrtps")
    if is_known and environment.keys().isdisjoint(_PROFILES):
        environment[_RANGE] = "SUBNET"
        environment[_PROFILES[0]] = str(_LOOPBACK)
    else:
        environment[_RANGE] = "LOCALHOST"
