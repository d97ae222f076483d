"""Log variables of one drone that are listened to for a while."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from crazychoir_fw.radio.logs import log_blocks, start_logs

if TYPE_CHECKING:
    from crazychoir_fw.radio import RadioDrone

_RATE_HZ = 10.0
_TIMEOUT_S = 5.0


class Readings:
    """The newest values; a context that ends with the log.

    Args:
        drone: A connected drone that has these variables.
        names: Variables by ``group.name``.

    Raises:
        CrazychoirError: If the drone does not log them.
    """

    def __init__(self, drone: RadioDrone, names: Sequence[str]) -> None:
        self.latest: dict[str, float] = {}
        self._names = tuple(names)
        who = f"{drone.agent_id} ({drone.uri})"
        blocks = log_blocks(who, dict.fromkeys(names, _RATE_HZ), drone.cf.log.toc)
        self._configs = start_logs(drone.cf, who, blocks, self._take, _TIMEOUT_S)

    def _take(self, _stamp_ms: int, values: dict[str, float | int]) -> None:
        self.latest |= {name: float(value) for name, value in values.items()}

    @property
    def is_complete(self) -> bool:
        """Whether each variable was received."""
        return all(name in self.latest for name in self._names)

    def __enter__(self) -> Readings:
        return self

    def __exit__(self, *_: object) -> None:
        for config in self._configs:
            config.delete()
