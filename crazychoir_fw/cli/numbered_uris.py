"""URIs of a swarm out of that of its first drone."""

import re

from crazychoir_fw.errors import MissionError

_HIGHEST_PORT = 65535


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
