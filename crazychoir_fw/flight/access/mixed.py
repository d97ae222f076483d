"""Simulated and real drones as one swarm: each is asked where it is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.flight.access.access import Access, DroneState, Variable

if TYPE_CHECKING:
    from collections.abc import Callable

    from crazychoir_fw.planning import Polynomial


class MixedAccess(Access):
    """The accesses of the parts of a mixed backend."""

    no_rewind = "the time of real drones cannot be turned back"
    knows_truth = False
    has_software = True

    def __init__(self, backend: Any, open_part: Callable[[Any], Access]) -> None:
        super().__init__(backend)
        parts = {id(part): open_part(part) for part in (backend.simulated, *backend.real)}
        places = [backend.part_of(i) for i in range(len(self.names))]
        self._where = [(parts[id(part)], k) for part, k in places]
        self._parts = list(parts.values())

    def is_slow(self, index: int) -> bool:
        """See `Access`."""
        part, k = self._where[index]
        return part.is_slow(k)

    def state(self, index: int) -> DroneState:
        """See `Access`."""
        part, k = self._where[index]
        return part.state(k)

    def batteries(self) -> NDArray[np.float64]:
        """See `Access`."""
        of_parts = {id(part): part.batteries() for part in self._parts}
        return np.array([of_parts[id(part)][k] for part, k in self._where])

    def refusal(self, index: int) -> str | None:
        """See `Access`."""
        part, k = self._where[index]
        return part.refusal(k)

    def cannot_follow(self, index: int) -> str | None:
        """See `Access`."""
        part, k = self._where[index]
        return part.cannot_follow(k)

    def arm(self, index: int, is_armed: bool) -> None:
        """See `Access`."""
        part, k = self._where[index]
        part.arm(k, is_armed)

    def reboot(self, index: int) -> str:
        """See `Access`."""
        part, k = self._where[index]
        return part.reboot(k)

    def stop_now(self, indices: list[int]) -> None:
        """See `Access`."""
        for index in indices:
            part, k = self._where[index]
            part.stop_now([k])

    def parameters(self, index: int) -> list[Variable]:
        """See `Access`."""
        part, k = self._where[index]
        return part.parameters(k)

    def set_parameter(self, index: int, name: str, value: float) -> float:
        """See `Access`."""
        part, k = self._where[index]
        return part.set_parameter(k, name, value)

    def log_names(self) -> list[str]:
        """See `Access`: what any of them has."""
        return sorted({name for part in self._parts for name in part.log_names()})

    def log_value(self, index: int, name: str) -> float:
        """See `Access`; NaN where only others have such a variable."""
        part, k = self._where[index]
        if name not in part.log_names() and name in self.log_names():
            return float("nan")
        return part.log_value(k, name)

    def console(self, index: int) -> str:
        """See `Access`."""
        part, k = self._where[index]
        return part.console(k)

    def begin_upload(self, index: int, curve: Polynomial) -> None:
        """See `Access`."""
        part, k = self._where[index]
        part.begin_upload(k, curve)

    def is_uploaded(self, index: int) -> bool:
        """See `Access`."""
        part, k = self._where[index]
        return part.is_uploaded(k)

    def fly_uploaded(self, index: int) -> None:
        """See `Access`."""
        part, k = self._where[index]
        part.fly_uploaded(k)
