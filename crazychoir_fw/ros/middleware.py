"""Environment of the middleware, set before rclpy starts it: stay on this machine, and use no shared memory."""

from __future__ import annotations

import os
from collections.abc import MutableMapping
from pathlib import Path

_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_PROFILES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
_LOOPBACK = Path(__file__).with_name("loopback.xml")


def stay_on_this_machine(environment: MutableMapping[str, str] = os.environ) -> None:
    """Choose how the participants of this process, and of those that it starts, find and reach others.

    Drones of other users on the same network should not receive our messages: wider discovery is a choice, by
    ``ROS_AUTOMATIC_DISCOVERY_RANGE``. Its ``LOCALHOST`` still makes Fast DDS listen to every network, and use shared
    memory with locks in it. A process that is killed while it holds a lock blocks all others for seconds, and never
    frees its memory. So Fast DDS is confined to loopback by a profile instead. Flights take as long, up to a tenth more
    or less; others on this machine find them as before.

    Args:
        environment: Variables to set; those that the user has set are kept.
    """
    if _RANGE in environment:
        return
    # the profile is tested with Jazzy's Fast DDS; any other middleware gets the variable of ROS
    is_known = environment.get("ROS_DISTRO", "jazzy") == "jazzy" and environment.get(
        "RMW_IMPLEMENTATION", "rmw_fastrtps_cpp"
    ).startswith("rmw_fastrtps")
    if is_known and environment.keys().isdisjoint(_PROFILES):
        environment[_RANGE] = "SUBNET"
        environment[_PROFILES[0]] = str(_LOOPBACK)
    else:
        environment[_RANGE] = "LOCALHOST"
