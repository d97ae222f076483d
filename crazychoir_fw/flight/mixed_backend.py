"""`MixedBackend`: mixed reality. Simulated drones, and real ones that their world shows as mirrored bodies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, TrajectoryPoint, Twist
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.flight.backend import Backend, Indices, one_of
from crazychoir_fw.flight.mirror import Mirror
from crazychoir_fw.flight.sim_backend import SimBackend
from crazychoir_fw.recording.log_stream import FLIGHT, LogStream
from crazychoir_fw.recording.signals import merged

if TYPE_CHECKING:
    from crazychoir_fw.recording.flight_log import FlightLog

Array = NDArray[np.float64]

_GAP = "real drones flew along, and no journal holds their motion"


class MixedBackend:
    """Drones of several backends as one swarm. Time is that of the world, which keeps pace with the real drones."""

    is_real_time = True

    def __init__(self, names: Sequence[str], simulated: SimBackend, real: Sequence[Backend]) -> None:
        """Put them together.

        Args:
            names: All drones, in the order in which layers count them.
            simulated: Backend of the simulated ones; its world has a mirrored body for each of the others.
            real: Backends of the others, whose time goes on by itself.

        Raises:
            RangeError: If a drone is in none of the backends, or in several, or has no mirrored body.
        """
        self.names = list(names)
        self.simulated, self.real = simulated, list(real)
        known = [name for part in self._parts for name in part.names]
        if sorted(known) != sorted(self.names):
            raise RangeError(
                f"backends have the drones {', '.join(known)}, allowed: {', '.join(self.names)}, each once"
            )
        mirrored = [name for part in self.real for name in part.names]
        for name in mirrored:
            if name not in simulated.world.mirrored:
                raise RangeError(f"{name}: the world has no mirrored body of that name")
        self._numbers = [np.array([self.names.index(name) for name in part.names], np.intp) for part in self._parts]
        self.masses = np.full(len(self.names), np.nan)
        for part, numbers in zip(self._parts, self._numbers, strict=True):
            self.masses[numbers] = part.masses
        self._where = {
            int(i): (part, k)
            for part, numbers in zip(self._parts, self._numbers, strict=True)
            for k, i in enumerate(numbers)
        }
        self.world, self.faults = simulated.world, simulated.faults
        self.mirror = Mirror(self.world, [self.world.mirrored[name] for name in mirrored])
        """What moves the mirrored bodies."""
        self.before_flight: Callable[..., None] = lambda **_: None
        self.radio_parts: list[tuple[list[int], Any]] = []  # numbers of drones in the mission, and their commander
        """See `HardwareBackend`."""
        self._real_numbers = np.concatenate([np.zeros(0, np.intp), *self._numbers[1:]])

    def part_of(self, index: int) -> tuple[Backend, int]:
        """Return the backend that a drone is in, and its number there."""
        return self._where[index]

    @property
    def _parts(self) -> list[Backend]:
        return [self.simulated, *self.real]

    @property
    def time(self) -> float:
        """See `Backend`."""
        return self.world.time

    @property
    def radio(self) -> Any:
        """The simulated radios, if requests of simulated drones go through some."""
        return self.simulated.radio

    @property
    def behind_s(self) -> float:
        """How far the world fell behind the clock of the real drones at worst (s)."""
        return max((part.pace.worst_lag_s for part in self.real if hasattr(part, "pace")), default=0.0)

    # ---------------------------------------------------------------- poses

    def poses(self) -> Pose:
        """See `Backend`."""
        count = len(self.names)
        whole = Pose(np.empty((count, 3)), np.empty((count, 4)), np.empty((count, 3)), np.empty((count, 3)), self.time)
        for part, numbers in zip(self._parts, self._numbers, strict=True):
            poses = part.poses()
            for name in ("position", "orientation", "velocity", "angular"):
                getattr(whole, name)[numbers] = getattr(poses, name)
        return whole

    def pose_of(self, index: int) -> Pose:
        """See `Backend`."""
        return one_of(self.poses(), index)

    def true_positions(self) -> Array:
        """See `Backend`: of real drones, what is known of them."""
        positions = np.empty((len(self.names), 3))
        for part, numbers in zip(self._parts, self._numbers, strict=True):
            positions[numbers] = part.true_positions()
        return positions

    # ---------------------------------------------------------------- commands

    def _shared_out(self, indices: Indices) -> list[tuple[Backend, list[int], list[int]]]:
        """Return the drones of each backend: their places in `indices`, and their numbers there."""
        shares: dict[int, tuple[Backend, list[int], list[int]]] = {}
        for place, i in enumerate(indices):
            part, k = self._where[int(i)]
            _, places, numbers = shares.setdefault(id(part), (part, [], []))
            places.append(place)
            numbers.append(k)
        return list(shares.values())

    def unlock(self, indices: Indices) -> list[int]:
        """See `Backend`; the world stands still while real drones get ready."""
        refused = []
        for part, places, numbers in self._shared_out(indices):
            own = dict(zip(numbers, places, strict=True))
            refused += [int(indices[own[k]]) for k in part.unlock(numbers)]
        return sorted(refused)

    def send(self, indices: Indices, twist: Twist, kind: str) -> None:
        """See `Backend`."""
        for part, places, numbers in self._shared_out(indices):
            part.send(np.array(numbers), Twist(twist.linear[places], twist.angular[places]), kind)

    def go_to(self, index: int, point: TrajectoryPoint) -> None:
        """See `Backend`."""
        part, k = self._where[int(index)]
        part.go_to(k, point)

    def land(self, index: int, floor: float, seconds: float) -> None:
        """See `Backend`."""
        part, k = self._where[int(index)]
        part.land(k, floor, seconds)

    def stop(self, indices: Indices) -> None:
        """See `Backend`."""
        for part, _, numbers in self._shared_out(indices):
            part.stop(numbers)

    # ---------------------------------------------------------------- time

    def look(self) -> None:
        """Put the mirrored bodies where the real ones are now, before anything flies."""
        self._see()
        self.mirror.advance(1)

    def _see(self) -> None:
        parts = [part.poses() for part in self.real]
        names = ("position", "orientation", "velocity", "angular")
        if parts:
            self.mirror.see(Pose(*(np.concatenate([getattr(part, name) for part in parts]) for name in names)))

    def advance(self, seconds: float) -> None:
        """See `Backend`: the world goes on, then waits for the clock of the real drones."""
        self._see()
        self.mirror.advance(round(seconds * TICKS_PER_SECOND))
        for part in self.real:
            part.advance(seconds)

    # ---------------------------------------------------------------- what became of them

    def failures(self) -> dict[int, str]:
        """See `Backend`."""
        return {
            int(numbers[k]): sentence
            for part, numbers in zip(self._parts, self._numbers, strict=True)
            for k, sentence in part.failures().items()
        }

    def record(self, extra: dict[str, Array]) -> None:
        """See `Backend`."""
        for part, numbers in zip(self._parts, self._numbers, strict=True):
            part.record({name: values[numbers] for name, values in extra.items()})

    def write_to(self, stream: LogStream, metadata: dict[str, Any]) -> None:
        """See `Backend`."""
        swarm = {"names": self.names, "numbers": [numbers.tolist() for numbers in self._numbers]}
        stream.append_json(b"H", FLIGHT, swarm)
        for part in self._parts:
            part.write_to(stream, metadata)

    def flush(self) -> None:
        """See `Backend`."""
        for part in self._parts:
            part.flush()

    def log(self, metadata: dict[str, Any]) -> FlightLog:
        """See `Backend`: what only simulated drones have is NaN for the others; their truth is what is known."""
        from crazychoir_fw.recording.flight_log import FlightLog

        log, *others = [part.log(metadata) for part in self._parts]
        signals = merged(
            self.names, list(zip(self._numbers, (log.signals, *(one.signals for one in others)), strict=True))
        )
        if log.journal is not None:
            log.journal.gap = _GAP
        return FlightLog(log.time, self.names, signals, log.metadata, log.events, log.journal, log.scenery)

    def close(self) -> None:
        """See `Backend`."""
        for part in self._parts:
            part.close()
