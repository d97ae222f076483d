"""What all kinds of faults have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, ClassVar

from crazychoir_fw._core import lib
from crazychoir_fw.common.constraints import constrained, names, number, refusal_of
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.simulation.drone import Drone


@dataclass(frozen=True, kw_only=True)
class Fault(ABC):
    """Something that goes wrong at a simulated time.

    What a fault does to a drone goes through `Uplink.dispatch`, past the radio, so that a journal of requests holds it.

    Raises:
        RangeError: If a value is outside its range; the message names fault, member, value and range.
    """

    kind: ClassVar[str]
    """Its word in mission files and logs."""

    is_instant: ClassVar[bool] = False
    """Whether it happens at once and has no end."""

    at: float = constrained(number(0.0, 1e6, "s"), 0.0)
    """When it begins: simulated time (s) in a script, seconds since the first phase in a mission file."""

    duration: float | None = constrained(number(0.001, 1e6, "s"), None)
    """How long it lasts (s); without it, to the end."""

    drones: Sequence[str] | None = constrained(names(), None)
    """Ids of the drones with the fault; without it, all."""

    def __post_init__(self) -> None:
        for member in fields(self):
            value = getattr(self, member.name)
            if allowed := refusal_of(member, value):
                raise RangeError(f"{self.kind}: {member.name} is {value!r}, allowed: {allowed}")
        if self.is_instant and self.duration is not None:
            raise RangeError(f"{self.kind}: duration is {self.duration!r}, but it happens at once and has no end")

    @property
    def begin_tick(self) -> int:
        """Tick at which it begins; not 0, so that a world that goes back to its start meets it again."""
        return max(1, round(self.at * TICKS_PER_SECOND))

    @property
    def end_tick(self) -> int | None:
        """Tick at which it ends, if it does."""
        if self.duration is None:
            return None
        return self.begin_tick + max(1, round(self.duration * TICKS_PER_SECOND))

    def details(self) -> dict[str, Any]:
        """Return what is special about it, as JSON can hold it: its members that are not at their defaults."""
        common = {member.name for member in fields(Fault)}
        return {
            member.name: list(value) if isinstance(value, tuple) else value
            for member in fields(self)
            if member.name not in common and (value := getattr(self, member.name)) != member.default
        }

    def as_dict(self) -> dict[str, Any]:
        """Return all of it, as JSON can hold it."""
        drones = None if self.drones is None else list(self.drones)
        return {"kind": self.kind, "at": self.at, "duration": self.duration, "drones": drones, **self.details()}

    def check(self, drone: Drone) -> None:  # noqa: B027 - most kinds suit every drone
        """Raise a `CrazychoirError` when this drone cannot have the fault."""

    @abstractmethod
    def begin(self, drone: Drone, seed: int) -> None:
        """Let it happen to one drone; `seed` is that of this fault in this world."""

    def end(self, drone: Drone) -> None:  # noqa: B027 - some end by themselves
        """Make the drone well again."""


def longest_delay(drone: Drone) -> float:
    """Return how late (s) poses of motion capture can be: the simulation remembers a number of them."""
    mocap = drone.struct.config.vehicle.mocap
    return lib.CF_MOCAP_CAPACITY / max(mocap.rate, 1) - 0.001 * (mocap.latency_ms + 1)
