"""Fly a recorded flight again from its journal, and compare both bit by bit.

The world is built from the recipe of the journal. Every request is handed to its drone at its tick, past the radio and
in the order in which they came; plugins of the user's do not run, because what they asked for is among the requests.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.common.reading import show_name
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.journal import Journal, Request
from crazychoir_fw.recording.log_stream import STREAM
from crazychoir_fw.simulation.fingerprint import difference
from crazychoir_fw.simulation.recipe import programs_of, read_drones, scene_differs
from crazychoir_fw.simulation.recorder import FlightRecorder
from crazychoir_fw.simulation.world import World

Progress = Callable[[float, float], None]
"""Called with simulated time and its end (s)."""

LAYERS = "layers."
"""Signals of guidance and control above the drones: those of a replay are requests only."""

SHOWN = 5
"""So many signals are named in a verdict; more are counted."""


class ReplayError(CrazychoirError):
    """A flight cannot be flown again; the text says why."""


@dataclass(frozen=True)
class Deviation:
    """Where two records of a flight part."""

    tick: int
    """First tick (ms) at which they differ."""
    drone: str | None
    """Name of the first drone that differs then; None when the records are not alike in form."""
    signals: tuple[str, ...]
    """What of it differs then."""
    recorded: float | str
    """Value of the first of these signals in the record."""
    replayed: float | str
    """Its value in the replay."""

    def __str__(self) -> str:
        named = ", ".join(self.signals[:SHOWN])
        more = f" and {len(self.signals) - SHOWN} more" if len(self.signals) > SHOWN else ""
        who = f"{self.drone} " if self.drone is not None else ""
        values = f"{self.recorded!r} recorded, {self.replayed!r} replayed"
        return f"at tick {self.tick} {who}{named}{more} differ ({self.signals[0]}: {values})"


@dataclass(frozen=True)
class Replay:
    """A flight that was flown again."""

    world: World
    """As it is after the last sample."""
    log: FlightLog
    """The new record, with the same samples."""
    warnings: tuple[str, ...]
    """What is not as it was when the flight was recorded, one sentence each."""
    deviation: Deviation | None
    """Where record and replay part; None when every signal is the same to the last bit."""


def load_flight(path: str | Path) -> FlightLog:
    """Read the log of a flight: a file, or the folder with a `log.npz`, or with the stream of a flight that was cut.

    Raises:
        ReplayError: If there is none.
    """
    path = Path(path)
    file = path
    if path.is_dir():
        # a stream is newer than what was written at the end of a flight before it
        file = path / STREAM if (path / STREAM).exists() else path / "log.npz"
    try:
        return FlightLog.load(file)
    except (OSError, ValueError) as error:
        raise ReplayError(f"{file} cannot be read: {error}") from error


def check_before(log: FlightLog) -> list[str]:
    """Return in what this installation differs from that of the record, one sentence each.

    Raises:
        ReplayError: If the flight cannot be flown again at all.
    """
    journal = _journal(log)
    from crazychoir_fw.onboard.core import identity

    here = identity()
    warnings = [
        f"recorded with {key} {log.metadata[key]}, this is {here[key]}"
        for key in ("version", "mujoco", "compiler", "flags")
        if key in log.metadata and log.metadata[key] != here[key]
    ]
    warnings += [str(log.metadata["cut"])] if "cut" in log.metadata else []
    try:
        changed = scene_differs(journal.recipe)
    except (TypeError, ValueError, OSError) as error:
        raise ReplayError(f"the recipe of the journal names no scene: {error}") from error
    return [*warnings, changed] if changed else warnings


def replay(
    log: FlightLog | str | Path,
    threads: int | None = None,
    observe: Progress | None = None,
    warn: Callable[[str], None] | None = None,
    trust: bool = False,
) -> Replay:
    """Fly a recorded flight again and compare.

    Args:
        log: A log with a journal, its file, or the folder of a flight.
        threads: Threads that share the drones; the result does not depend on it.
        observe: Called at every sample.
        warn: Called before the flight with everything that is not as it was when it was recorded.
        trust: Compile and run the apps that the log names; a log of others may name any file.

    Raises:
        ReplayError: If it cannot be flown again; the text says why.
        CrazychoirError: If its world cannot be built here.
    """
    if not isinstance(log, FlightLog):
        log = load_flight(log)
    warnings = check_before(log)
    journal = _journal(log)
    if (programs := programs_of(journal.recipe)) and not trust:
        raise ReplayError(f"{untrusted(programs)}: read what they do, then replay with trust")
    world = build(journal, threads)
    # versions have been compared in detail, and what Python classes asked for is in the journal
    compared = {part: world.fingerprint[part] for part in ("versions", "programs")}
    theirs = {**journal.recipe.get("fingerprint", {}), **compared}
    differs = difference(theirs, world.fingerprint)
    if differs is not None:
        warnings.append(f"the recorded world {differs}")
    if warn is not None:
        for warning in warnings:
            warn(warning)

    recorder = FlightRecorder(world)
    reader = _Reader(world, journal)
    for time, count in zip(log.time, journal.samples, strict=True):
        reader.deliver(count)
        reader.advance(round(float(time) * TICKS_PER_SECOND))
        recorder.sample()
        if observe is not None:
            observe(world.time, float(log.time[-1]))
    again = recorder.finish(log.metadata)
    return Replay(world, again, tuple(warnings), compare(log, again))


def untrusted(programs: Sequence[str]) -> str:
    """Return which programs a log of others would run, as the begin of a sentence."""
    shown = ", ".join(show_name(name) for name in programs[:SHOWN])
    more = f" and {len(programs) - SHOWN} more" if len(programs) > SHOWN else ""
    return f"the log names C that a replay compiles and runs, {shown}{more}"


def build(journal: Journal, threads: int | None = None) -> World:
    """Return the world of a journal at its first tick.

    Raises:
        CrazychoirError: If it cannot be built here.
    """
    recipe = journal.recipe
    try:
        changed = scene_differs(recipe)
        if changed is not None and changed.endswith("is gone"):
            raise ReplayError(changed)
        drones = read_drones(recipe)
        return World(drones, recipe["scene"], recipe["seed"], threads=threads, visuals=False, is_replay=True)
    except CrazychoirError:
        raise
    except Exception as error:  # a recipe that was altered makes its readers raise whatever they can
        raise ReplayError(f"the recipe of the journal is damaged: {type(error).__name__}: {error}") from error


class _Reader:
    """Hands the requests of a journal to the drones of a world."""

    def __init__(self, world: World, journal: Journal) -> None:
        self._world = world
        self._requests: Iterator[Request] = iter(journal)
        self._done = 0

    def deliver(self, count: int) -> None:
        """Deliver, each at its tick, until so many have been."""
        while self._done < count:
            request = next(self._requests)
            self.advance(request.tick)
            self._carry_out(request)
            self._done += 1

    def advance(self, tick: int) -> None:
        self._world.step(max(0, tick - self._world.tick))

    def _carry_out(self, request: Request) -> None:
        uplink = self._world.drones[request.drone].uplink
        try:
            if not uplink.is_request(request.verb, tuple(request.arguments)):
                raise AttributeError(request.verb)
            uplink.dispatch(request.verb, *request.arguments)
        except CrazychoirError:
            pass  # the drone refused it in the flight as well
        except (AttributeError, TypeError, IndexError, ValueError, OverflowError) as error:
            where = f"'{request.verb}' at {request.tick / TICKS_PER_SECOND:.3f} s"
            raise ReplayError(f"the journal asks for {where}, which this version does not understand") from error


def _journal(log: FlightLog) -> Journal:
    journal = log.journal
    if journal is None:
        raise ReplayError("the log has no journal: its drones have no onboard software here, or its version is older")
    if journal.gap is not None:
        raise ReplayError(f"the journal has a gap: {journal.gap}")
    if not journal.recipe:
        raise ReplayError("the journal does not say how to build its world")
    samples = np.array(journal.samples, np.int64)
    if len(samples) != len(log.time) or (len(samples) and (samples[0] < 0 or samples[-1] > len(journal))):
        raise ReplayError("journal and signals are not of the same flight")
    if np.any(np.diff(samples) < 0):
        raise ReplayError("the samples of the journal run backwards")
    n = len(log.drone_ids)
    if any(not 0 <= request.drone < n for request in journal):
        raise ReplayError("the journal names drones that the log does not have")
    return journal


# -------------------------------------------------------------------------------------- comparison


def compare(recorded: FlightLog, replayed: FlightLog) -> Deviation | None:
    """Return where two records of a flight part, or None when they are the same to the last bit.

    Events do not count: those that a script noted of its own accord are not noted again.
    """
    if (shape := _shape_deviation(recorded, replayed)) is not None:
        return shape
    first: tuple[int, int] | None = None  # sample, drone
    names: list[str] = []
    for name, samples in recorded.signals.items():
        if name.startswith(LAYERS):
            continue
        at = _first_difference(samples, replayed.signals[name])
        if at is not None and (first is None or at < first):
            first, names = at, []
        if at is not None and at == first:
            names.append(name)
    if first is not None:
        sample, drone = first
        values = [log.signals[names[0]][sample, drone].item() for log in (recorded, replayed)]
        tick = round(float(recorded.time[sample]) * TICKS_PER_SECOND)
        return Deviation(tick, recorded.drone_ids[drone], tuple(names), *values)
    return None


def _first_difference(one: NDArray[Any], other: NDArray[Any]) -> tuple[int, int] | None:
    """Return sample and drone of the first difference in bits."""
    if one.dtype == other.dtype and one.tobytes() == other.tobytes():
        return None
    if one.dtype != other.dtype:
        return (0, 0)
    bits = np.dtype(f"u{one.dtype.itemsize}")
    differs = np.ascontiguousarray(one).view(bits) != np.ascontiguousarray(other).view(bits)
    sample, drone = np.argwhere(differs)[0]
    return int(sample), int(drone)


def _shape_deviation(recorded: FlightLog, replayed: FlightLog) -> Deviation | None:
    if recorded.drone_ids != replayed.drone_ids:
        return Deviation(0, None, ("drones",), ", ".join(recorded.drone_ids), ", ".join(replayed.drone_ids))
    # what layers wanted is nothing that the world knows again
    names = [{name for name in log.signals if not name.startswith(LAYERS)} for log in (recorded, replayed)]
    missing = sorted(names[0] ^ names[1])
    if missing:
        present = ["yes" if missing[0] in log.signals else "no such signal" for log in (recorded, replayed)]
        return Deviation(0, None, tuple(missing), *present)
    if recorded.time.tobytes() != replayed.time.tobytes():
        sample = int(np.argmax(recorded.time != replayed.time))
        times = [float(log.time[sample]) for log in (recorded, replayed)]
        return Deviation(round(times[0] * TICKS_PER_SECOND), None, ("time",), *times)
    return None
