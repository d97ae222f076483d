"""Records every log variable of every drone, and the true motion, at a fixed rate.

A sample is one call of the core, which copies the stretches of memory that hold log variables (see `swarm_views`) into
rows whose place it knows. Drones with different providers have different variables: a signal that a drone lacks is NaN
in its column, and one that counts in whole numbers becomes a float for the others then, without losing a digit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.onboard.core import identity, provider_identity
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.journal import Journal
from crazychoir_fw.recording.log_archive import archive
from crazychoir_fw.recording.log_stream import LogStream
from crazychoir_fw.recording.record_output import TAKEN_BACK, RecordOutput
from crazychoir_fw.recording.samples import Fields, Samples
from crazychoir_fw.recording.signals import EXTRA, LazySignals, scenery_of, signals_of
from crazychoir_fw.recording.spill_file import SpillFile
from crazychoir_fw.simulation.stage import scenery_columns
from crazychoir_fw.simulation.swarm_views import swarm_parts
from crazychoir_fw.simulation.world import World

_NUMBERS = {"time": "double *", "requests": "int64_t *", "qpos": "double *", "motion": "double *"}
_FLUSH_BYTES = 1 << 24
_SPILL_BYTES = 1 << 26  # in memory, without a stream; a thousand drones at 100 Hz fill them in half a second


class FlightRecorder:
    """Collects samples of a world; `finish` makes a `FlightLog` of them."""

    def __init__(self, world: World, rate_hz: int = 100) -> None:
        """Prepare to record.

        Args:
            world: The world.
            rate_hz: Samples per simulated second; a divisor of 1000.

        Raises:
            RangeError: If the rate does not divide 1000.
        """
        if not (1 <= rate_hz <= TICKS_PER_SECOND and TICKS_PER_SECOND % rate_hz == 0):
            raise RangeError(f"rate_hz is {rate_hz}, allowed: a divisor of {TICKS_PER_SECOND}")
        self._world = world
        self.ticks_per_sample = TICKS_PER_SECOND // rate_hz
        self._parts = swarm_parts(world)
        self._scenery = np.intersect1d(  # columns of qpos of what moves beside drones and mirrored bodies
            scenery_columns(world.model, [drone.id for drone in world.drones]),
            scenery_columns(world.model, world.mirrored),
        ).tolist()
        self._samples: Samples | None = None  # its fields are known at the first sample
        self._rows: dict[str, NDArray[Any]] = {}  # where the next samples go
        self._place = 0  # of the next sample in them
        self._free = 0  # from there on
        self._extra: tuple[str, ...] = ()
        self._journal: Journal | None = None  # of the world; another one after a return to a snapshot
        self._was_taken_back = False
        self._output: RecordOutput | None = None
        self._spill = SpillFile()
        self._bind()

    def sample(self, extra: Mapping[str, NDArray[Any]] | None = None) -> None:
        """Take one sample of the present instant.

        Args:
            extra: Further signals by name, shape (N,) each; the same names with every sample.
        """
        if not self._free:
            self._make_room(tuple(extra or ()))
        lib.cf_sample(self._sampler, self._place, len(self._world.journal))
        for name in self._extra:
            self._rows[EXTRA + name][self._place] = extra[name]  # type: ignore[index]
        self._samples.take()  # type: ignore[union-attr]
        self._place += 1
        self._free -= 1
        if self._journal is not self._world.journal:
            self._was_taken_back = self._journal is not None
            self._journal = self._world.journal

    def run_alone(self, count: int) -> tuple[int, float]:
        """Advance the world and sample while Python has nothing to do, in one call of the core.

        Args:
            count: How many samples to take.

        Returns:
            How many were taken, possibly none, and the wall time of that (s). All but the last one saw neither contact
            nor failure.
        """
        if not self._free or self._extra or self._journal is not self._world.journal:
            return 0, 0.0
        begun = self._world.tick
        rounds = self._world.rounds_alone(self.ticks_per_sample, min(count, self._free))
        if not rounds:
            return 0, 0.0
        taken, seconds = self._world.fly_and_sample(self.ticks_per_sample, rounds, self._sampler, self._place)
        self._samples.take(taken)  # type: ignore[union-attr]
        self._place += taken
        self._free -= taken
        if self._world.tick > begun + taken * self.ticks_per_sample:  # the round behind them had no sample yet
            self.sample()
            taken += 1
        return taken, seconds

    def _make_room(self, extra: tuple[str, ...]) -> None:
        """Find memory for the next samples: what lies in memory moves to a file first when it is much.

        Memory that is used again costs less than new memory.
        """
        if self._samples is None:
            self._samples = self._make_samples(extra)
        limit = _SPILL_BYTES if self._output is None else _FLUSH_BYTES
        is_full = self._samples.bytes_in_memory + self._samples.row_bytes > limit
        if is_full and self._output is not None:
            self.flush()  # at hundred times real time half a second of wall time is much
        elif is_full:
            self._samples.write(self._spill, 0)
        self._rows = self._samples.free()
        rows_to_limit = (limit - self._samples.bytes_in_memory) // self._samples.row_bytes
        self._place, self._free = 0, min(len(self._rows["time"]), max(1, rows_to_limit))
        sampler = self._sampler
        for column, name in (("times", "time"), ("requests",) * 2, ("qpos_rows", "qpos"), ("motion_rows", "motion")):
            setattr(sampler, column, ffi.cast(_NUMBERS[name], self._rows[name].ctypes.data))
        for k in range(len(self._parts)):
            self._c_parts[k].rows = ffi.cast("uint8_t *", self._rows[f"part{k}"].ctypes.data)

    def _bind(self) -> None:
        """Tell the core what a sample reads."""
        data, drones = self._world.data, self._world.drones
        self._c_dofs = ffi.new("int32_t[]", [drone.qvel_address for drone in drones])
        self._c_parts = ffi.new("cf_sampled_part_t[]", len(self._parts))
        for part, c_part in zip(self._parts, self._c_parts, strict=True):
            part.fill(c_part)
        self._sampler = ffi.new("cf_sampler_t *")
        sampler = self._sampler
        sampler.time = lib.cf_plugin_clock(data._address)
        sampler.qpos = ffi.cast("double *", data.qpos.ctypes.data)
        sampler.qvel = ffi.cast("double *", data.qvel.ctypes.data)
        sampler.dofs, sampler.drones, sampler.nq = self._c_dofs, len(drones), len(data.qpos)
        sampler.parts, sampler.part_count = self._c_parts, len(self._parts)

    def _make_samples(self, extra: tuple[str, ...]) -> Samples:
        self._extra = extra
        parts: Fields = {f"part{k}": (part.copy_shape, np.uint8) for k, part in enumerate(self._parts)}
        rest: Fields = {
            "qpos": (self._world.data.qpos.shape, float),
            "motion": ((len(self._world.drones), 6), float),
            **{EXTRA + name: ((len(self._world.drones),), np.float32) for name in extra},
        }
        return Samples({"time": ((), float), "requests": ((), np.int64), **parts, **rest})

    def run(self, seconds: float) -> None:
        """Advance the world and sample on the way."""
        for _ in range(max(1, round(seconds * TICKS_PER_SECOND / self.ticks_per_sample))):
            self._world.step(self.ticks_per_sample)
            self.sample()

    @property
    def qpos(self) -> NDArray[np.float64]:
        """Positions of the whole model at each sample, shape (T, nq)."""
        return self._column("qpos")

    @property
    def times(self) -> NDArray[np.float64]:
        """Simulated time of each sample (s), shape (T,)."""
        return self._column("time")

    def _column(self, name: str) -> NDArray[Any]:
        if self._samples is None:
            self._samples = self._make_samples(())
        return self._samples.column(name)

    # ---------------------------------------------------------------- to disk while it flies

    def write_to(self, stream: LogStream, metadata: Mapping[str, Any]) -> None:
        """Have `flush` move samples, requests and events to a stream; memory does not grow with the flight then.

        Args:
            stream: Where to.
            metadata: What a log says that is cut off.
        """
        self._output = RecordOutput(stream, {**self._provenance(), **metadata})

    def flush(self) -> None:
        """Move what was recorded since the last call to the stream, if there is one."""
        if self._output is None or self._samples is None:
            return
        world, self._free = self._world, 0
        self._output.begin(self._layout(), self._samples, [d.id for d in world.drones], world.journal.recipe)
        self._output.write(self._samples, world.journal, [event.as_dict() for event in world.events])

    def _layout(self) -> dict[str, Any]:
        return {
            "parts": [part.layout for part in self._parts],
            "drones": len(self._world.drones),
            "qpos": [drone.qpos_address for drone in self._world.drones],
            "extra": list(self._extra),
            "scenery": self._scenery,
        }

    def finish(self, metadata: Mapping[str, Any] | None = None) -> FlightLog:
        """Return everything recorded so far; the metadata also says what flew, how it was built, and the seed."""
        times = self.times
        journal = self._world.journal.copy() if self._output is None else self._output.journal(self._world.journal)
        journal.samples = self._column("requests").tolist()
        if self._was_taken_back:
            journal.gap = TAKEN_BACK
        # samples stay beside lazy signals: of many, that is too much memory
        is_small = self._samples is None or len(self._samples) * self._samples.row_bytes < _SPILL_BYTES
        signals = LazySignals if is_small else signals_of
        return FlightLog(
            time=times,
            drone_ids=[drone.id for drone in self._world.drones],
            signals=signals(self._layout(), self._column),
            metadata={**self._provenance(), **(metadata or {})},
            events=[event.as_dict() for event in self._world.events],
            journal=journal,
            scenery=scenery_of(self._layout(), self._column),
        )

    @property
    def keeps_journal(self) -> bool:
        """Whether the requests of the flight are written down, so that it can be flown again."""
        return self._world.journal.is_kept

    def save(
        self,
        path: Path,
        metadata: Mapping[str, Any] | None = None,
        tell: Callable[[float], object] = lambda share: None,
    ) -> FlightLog:
        """Write the log to a file, out of the stream where there is one: memory does not grow with the flight.

        Args:
            path: The file.
            metadata: What the log says about the flight.
            tell: Called with the share that is done, 0 to 1, now and then.

        Returns:
            A log for plots; of a flight with a stream, some thousand samples of it, without a journal.

        Raises:
            OSError: If it cannot be written.
        """
        self.flush()
        is_streamed = self._output is not None and self._samples is not None and not self._samples.bytes_in_memory
        if self._output is not None and is_streamed and not self._was_taken_back and self._output.is_complete:
            events = [event.as_dict() for event in self._world.events]
            return archive(self._output.path, path, {**self._provenance(), **(metadata or {})}, events, tell)
        log = self.finish(metadata)
        log.save(path)
        tell(1.0)
        return log

    def _provenance(self) -> dict[str, Any]:
        drones = {d.id: {"provider": d.config.provider, "platform": d.config.platform} for d in self._world.drones}
        return {
            **identity(),
            "scene": self._world.scene,
            "seed": self._world.seed,
            "drones": drones,
            "providers": provider_identities(self._world),
        }


def provider_identities(world: World) -> list[dict[str, Any]]:
    """Return what flies the drones of a world, once per provider, in the order of the drones."""
    return [provider_identity(number) for number in dict.fromkeys(drone.provider_number for drone in world.drones)]
