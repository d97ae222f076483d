"""URIs of a swarm out of that of its first drone."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.mission.loader import load_mission
from crazychoir_fw.mission.schema import Mission

_HIGHEST_PORT = 65535


def load_numbered(path: Path, base: str | None, overrides: Mapping[str, Any]) -> Mission:
    """Return a mission whose drones have their URIs by number.

    Args:
        path: The mission file.
        base: URI of the first drone; None leaves them as the file has them.
        overrides: What is stronger than the file, for `load_mission`.

    Raises:
        MissionError: If the file cannot be flown, or no drone of it is real.
    """
    if base is None:
        return load_mission(path, **overrides)
    # how many drones there are is known before where they are
    simulated = load_mission(path, **{**overrides, "backend": "sim"})
    mission = load_mission(path, **overrides, uris=numbered_uris(base, len(simulated.fleet)))
    if mission.backend not in ("hardware", "mixed"):
        raise MissionError(
            f"--uri-base is for real drones, but the backend is {mission.backend}: add --backend hardware"
        )
    return mission


def numbered_uris(base: str, count: int) -> list[str]:
    """Return the URIs of so many drones: each has the port, or the address, after that of the one before.

    ``udp://127.0.0.1:19850`` goes on with ``udp://127.0.0.1:19851``, ``radio://0/80/2M/E7E7E7E701`` with
    ``radio://0/80/2M/E7E7E7E702``.

    Raises:
        MissionError: If it ends in neither, or the numbers do not suffice.
    """
    port = re.fullmatch(r"(udp://[^\s:/]+):(\d{1,5})", base)
    if port:
        first = int(port[2])
        if not 1 <= first <= _HIGHEST_PORT - count + 1:
            raise MissionError(f"--uri-base {base}: {count} drones need ports up to {first + count - 1}, at most 65535")
        return [f"{port[1]}:{first + i}" for i in range(count)]
    address = re.fullmatch(r"(radio://[^\s]+/)([0-9A-Fa-f]{10})", base)
    if address:
        first = int(address[2], 16)
        if first + count - 1 > 0xFFFFFFFFFF:
            raise MissionError(f"--uri-base {base}: there are no {count} addresses from there on")
        return [f"{address[1]}{first + i:010X}" for i in range(count)]
    raise MissionError(
        f"--uri-base is {base[:60]!r}, but must be one such as udp://127.0.0.1:19850 or radio://0/80/2M/E7E7E7E701"
    )
