"""A radio that loses requests of clients, or is late with them.

What is lost is a pure function of seed, fault, drone, time and order within a tick. What is under way is remembered
here, by the tick of its sending, so that a world that goes back in time finds it under way again; requests of the very
tick that it goes back to count as not yet sent.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, ClassVar

from crazychoir_fw.common.constraints import constrained, number, switch
from crazychoir_fw.common.errors import CrazychoirError, RangeError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.onboard.core import check
from crazychoir_fw.simulation.clients.uplink import FaultFilter
from crazychoir_fw.simulation.drone import Drone
from crazychoir_fw.simulation.faults.fault import Fault, longest_delay
from crazychoir_fw.simulation.world_base import WorldBase


@dataclass(frozen=True, kw_only=True)
class RadioFault(Fault):
    """Requests of clients to the drone get lost for good, or arrive later, in the order of their sending.

    Requests are all that clients ask for: setpoints, plans, parameters, external positions and packets. Answers that a
    client reads from the drone are not disturbed. Poses of the simulated motion capture come by radio as well.
    """

    kind: ClassVar[str] = "radio"

    loss: float = constrained(number(0.0, 1.0), 0.0)
    """Share of the requests that never arrive, after all tries of the link; 1 is silence."""

    latency: float = constrained(number(0.0, 10.0, "s"), 0.0)
    """Added to the time that a request takes (s)."""

    poses: bool = constrained(switch(), True)
    """Whether poses of the motion capture suffer as well."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.loss and not self.latency:
            raise RangeError("radio: nothing is wrong with it; allowed: loss or latency above 0")

    def check(self, drone: Drone) -> None:
        """Refuse a latency that is longer than the simulation remembers poses.

        Raises:
            RangeError: If poses are to be that late.
        """
        if self._spoils_poses(drone) and self.latency:
            longest = longest_delay(drone)
            if self.latency > longest + 1e-9:
                raise RangeError(
                    f"{drone.id}: latency is {self.latency} s, allowed at this rate of poses: {longest:.3f} s or less, "
                    f"or poses: false"
                )

    def begin(self, drone: Drone, seed: int) -> None:
        """Spoil the poses; requests are judged one by one (`Radio`)."""
        if self._spoils_poses(drone):
            self._spoil_poses(drone, self.loss, self.latency)

    def end(self, drone: Drone) -> None:
        """Let poses pass again."""
        if self._spoils_poses(drone):
            self._spoil_poses(drone, 0.0, 0.0)

    def _spoils_poses(self, drone: Drone) -> bool:
        return self.poses and (drone.config.positioning or "mocap").startswith("mocap")

    def _spoil_poses(self, drone: Drone, loss: float, latency: float) -> None:
        late = round(latency * TICKS_PER_SECOND)
        check(drone.uplink.dispatch("cf_inject_positioning_dropout", loss), f"{drone.id}: loss of poses")
        check(drone.uplink.dispatch("cf_inject_positioning_delay", late), f"{drone.id}: late poses")

    def is_on(self, tick: int) -> bool:
        """Tell whether it disturbs requests that are sent at a tick."""
        return self.begin_tick <= tick and (self.end_tick is None or tick < self.end_tick)


@dataclass
class _Request:
    """One that is under way, or was."""

    sent: int  # [ticks]
    due: int  # [ticks]
    verb: str
    arguments: tuple[Any, ...]
    is_real: bool = True  # False: sent in a future that never came


class Radio:
    """The link to one drone while faults are planned for it: the fault filter of its uplink."""

    def __init__(self, world: WorldBase, drone: Drone, number: int) -> None:
        self._world = world
        self._drone = drone
        self._number = number
        self._faults: list[tuple[RadioFault, int]] = []
        self._queue: list[_Request] = []
        self._tick = -1
        self._count = 0  # requests of this tick
        self._before: FaultFilter | None = drone.uplink.fault_filter
        drone.uplink.fault_filter = self._let_pass

    def add(self, fault: RadioFault, seed: int) -> None:
        """Plan a fault."""
        self._faults.append((fault, seed))

    @property
    def under_way(self) -> int:
        """Number of requests that are under way."""
        return sum(request.is_real and request.due > self._world.tick for request in self._queue)

    def _let_pass(self, verb: str, arguments: tuple[Any, ...]) -> bool:
        now = self._world.tick
        if self._before is not None and not self._before(verb, arguments):
            return False
        active = [(fault, seed) for fault, seed in self._faults if fault.is_on(now)]
        if active and self._is_lost(active, now):
            return False
        latency = max((round(fault.latency * TICKS_PER_SECOND) for fault, _ in active), default=0)
        # nothing overtakes what is still under way
        last = max((request.due for request in self._queue if request.is_real), default=now)
        due = max(now + latency, last)
        if due <= now:
            return True
        request = _Request(now, due, verb, arguments)
        self._queue.append(request)
        self._expect(request)
        return False

    def _expect(self, request: _Request) -> None:
        def arrive() -> None:
            if request.is_real:
                # the client has gone on and hears of no refusal
                with suppress(CrazychoirError):
                    self._drone.uplink.send(request.verb, *request.arguments)

        self._world.agenda.at(request.due, arrive)

    def _is_lost(self, active: Iterable[tuple[RadioFault, int]], now: int) -> bool:
        self._count = self._count + 1 if now == self._tick else 0
        self._tick = now
        return any(share_of(seed, self._number, now, self._count) < fault.loss for fault, seed in active)

    def time_has_changed(self, tick: int) -> None:
        """Forget what was sent from this tick on; it will be sent again, or never."""
        for request in self._queue:
            request.is_real = request.is_real and request.sent < tick
        self._queue = [request for request in self._queue if request.is_real]
        self._tick = -1


def share_of(seed: int, *numbers: int) -> float:
    """Return a number in [0, 1) that depends on all of these and nothing else."""
    packed = struct.pack(f"<{1 + len(numbers)}Q", seed, *numbers)
    digest = hashlib.blake2b(packed, digest_size=8).digest()
    return float(int.from_bytes(digest, "little") >> 11) * 2.0**-53
