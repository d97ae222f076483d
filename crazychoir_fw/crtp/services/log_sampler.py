"""Log blocks that run: sampled by simulated time, all drones of a world together.

The simulation thread samples. The radio thread stops blocks and lengthens them while that happens: it changes a `Run`
and then tells the sampler that something has changed, and the next sampling looks at all of it again.
"""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.crtp.service_context import ServiceContext

if TYPE_CHECKING:
    from crazychoir_fw.simulation.event_scheduler import EventScheduler
    from crazychoir_fw.simulation.world import World

SLICE = 10
"""Blocks whose period is at least this long (ticks) begin at multiples of it, so that a swarm with blocks started at
any time stops the world once per slice, and not at every tick: their first packet comes up to one slice late."""


class Value(NamedTuple):
    """One value of a block."""

    offset: int
    """Place within ``cf_t`` (bytes)."""
    stored: int
    """Type on the drone, as the log service numbers them."""
    fetched: int
    """Type in the packet."""
    needs_refresh: bool
    """Whether the drone computes it only when it is read."""


class Run:
    """A block from one start to the next, or to its end."""

    def __init__(self, context: ServiceContext, number: int, period: int, values: Sequence[Value]) -> None:
        """Start a block.

        Args:
            context: Of its drone.
            number: Of the block.
            period: Ticks between two packets; 0 asks for one packet.
            values: What to send, at most 26 bytes.
        """
        self.context = context
        self.number = number
        self.period = period
        self.values = values
        """Replaced as a whole, by the radio thread."""
        self.is_over = False
        """Set by the radio thread."""
        self.first = 0  # [ticks], not sampled before


class LogSampler:
    """All blocks that run in one world; `sampler_of` finds it."""

    def __init__(self, agenda: EventScheduler) -> None:
        # weak, because a group knows its world, and the sampler is kept in a table beside the world
        self._groups: weakref.WeakValueDictionary[tuple[int, int], _Group] = weakref.WeakValueDictionary()
        self.state = object()
        """Another object whenever a run has changed."""
        agenda.when_sought.append(self._sought)

    def changed(self) -> None:
        """Say that runs have changed; any thread may call this."""
        self.state = object()

    def add(self, run: Run) -> None:
        """Sample a block from now on; only the simulation thread calls this."""
        if run.period == 0:
            _Batch([run]).send()
            return
        world = run.context.world
        first = world.tick + run.period
        if run.period >= SLICE:
            first = -(-first // SLICE) * SLICE
        run.first = first
        key = run.period, first % run.period
        group = self._groups.get(key)
        if group is None:
            group = self._groups[key] = _Group(self, world.agenda, *key)
        group.runs.append(run)
        self.changed()

    def forget(self, key: tuple[int, int]) -> None:
        """Remove a group that has nothing left to sample."""
        self._groups.pop(key, None)

    def _sought(self, tick: int) -> None:
        for group in list(self._groups.values()):
            group.begin_anew()
        self.changed()


_samplers: weakref.WeakKeyDictionary[World, LogSampler] = weakref.WeakKeyDictionary()


def sampler_of(world: World) -> LogSampler:
    """Return the sampler of a world."""
    sampler = _samplers.get(world)
    if sampler is None:
        sampler = _samplers[world] = LogSampler(world.agenda)
    return sampler


class _Group:
    """Blocks that are due at the same ticks; the agenda keeps it alive."""

    def __init__(self, sampler: LogSampler, agenda: EventScheduler, period: int, phase: int) -> None:
        self.runs: list[Run] = []
        self._sampler = sampler
        self._key = period, phase
        self._state: object = None  # that of the sampler when the batch was made
        self._batch = _Batch([])
        self._cancel = agenda.every(period, self._sample, phase)

    def begin_anew(self) -> None:
        """Time has changed: wait for no tick, which may be far away now."""
        for run in self.runs:
            run.first = 0

    def _sample(self) -> None:
        if self._state is not self._sampler.state:
            self._make_batch()
        self._batch.send()

    def _make_batch(self) -> None:
        self._state = self._sampler.state  # first, so that what changes meanwhile is seen the next time
        self.runs = [run for run in self.runs if not run.is_over]
        if not self.runs:
            self._batch = _Batch([])
            self._sampler.forget(self._key)
            self._cancel()
            return
        tick = self.runs[0].context.world.tick
        due = [run for run in self.runs if run.first <= tick]
        if len(due) < len(self.runs):
            self._state = None  # look again
        self._batch = _Batch(due)


class _Batch:
    """Blocks made ready for C."""

    def __init__(self, runs: Sequence[Run]) -> None:
        runs = sorted(runs, key=lambda run: run.context.drone.id)  # C refreshes neighbors of one drone once
        self._count = len(runs)
        self._blocks = ffi.new("cf_log_block_t[]", self._count)
        self._packets = ffi.new("uint8_t[]", self._count * lib.CF_LOG_PACKET_BYTES)
        self._bytes = ffi.buffer(self._packets)
        self._parts: dict[ServiceContext, list[slice]] = {}
        for index, run in enumerate(runs):
            values = run.values  # one and the same, whatever the radio thread does
            block = self._blocks[index]
            block.drone = run.context.drone.struct
            block.number = run.number
            block.count = len(values)
            block.needs_refresh = any(value.needs_refresh for value in values)
            length = lib.CF_LOG_HEADER_BYTES
            for place, value in enumerate(values):
                block.values[place] = (value.offset, value.stored, value.fetched)
                length += lib.cf_log_value_bytes(value.fetched)
            start = index * lib.CF_LOG_PACKET_BYTES
            self._parts.setdefault(run.context, []).append(slice(start, start + length))

    def send(self) -> None:
        """Sample and send all."""
        if self._count == 0:
            return
        lib.cf_log_pack(self._blocks, self._count, self._packets)
        packets = self._bytes[:]
        for context, parts in self._parts.items():
            context.put_out([(packets[part], True) for part in parts])
        for context in self._parts:
            context.wake_radio()
