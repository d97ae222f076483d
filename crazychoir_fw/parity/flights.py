"""Whole flights in lockstep: two worlds, one per provider, same seed, compared at every tick."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import lib
from crazychoir_fw.onboard.variables import log_table
from crazychoir_fw.parity.deviation import Deviation, Trace, join, measure, trace
from crazychoir_fw.parity.fleet import FLEET, Formation, Member
from crazychoir_fw.parity.functions import TRACES, Comparison
from crazychoir_fw.parity.manoeuvres import Pilot
from crazychoir_fw.parity.side import Side
from crazychoir_fw.parity.tolerances import FLIGHT, OWN_LOOP, Tolerance, tolerance_of
from crazychoir_fw.recording.signals import roll_pitch_yaw_deg
from crazychoir_fw.simulation.drone import Drone

_CHUNK = 2000  # ticks that are compared at once
_POINTS = 50  # of a chunk, in a picture
_AFTERWARDS = 0.3  # [s], flown after the last leg
_TRUTH = ("true.x", "true.y", "true.z", "true.roll", "true.pitch", "true.yaw")
_OUTCOMES = {"health.motorTestCount", "health.motorPass", "health.batteryPass"}
"""Of tests that move no drone: judged when the flight ends."""

Disturb = Callable[[Drone, int], None]


def compare_flights(
    reference: Side,
    candidate: Side,
    seconds: float,
    seed: int = 1,
    fleet: Sequence[Member] = FLEET,
    disturb: Disturb | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Comparison]:
    """Fly the fleet twice and compare every drone with itself.

    A candidate that brings its own stabilizer loop is compared from the moment when it can fly, by `OWN_LOOP`.

    Args:
        reference: Provider of the first world.
        candidate: Provider of the second world.
        seconds: How long at most, from the moment when the drones can fly.
        seed: Seed of all noise.
        fleet: The drones; those whose controller one side lacks stay at home in both worlds.
        disturb: Called with each drone of the second world and the tick (ms) before every step; None in earnest.
        progress: Told from time to time which share is done, in [0, 1].
    """
    at_home = {
        member.name: tuple(side.name for side in (reference, candidate) if not side.has_controller(member.controller))
        for member in fleet
    }
    found = {
        member.name: Comparison(
            "flight",
            member.name,
            member.shows,
            is_by_number=False,
            missing_in=at_home[member.name],
            modules=member.modules,
        )
        for member in fleet
    }
    fleet = [member for member in fleet if not at_home[member.name]]
    if fleet:
        _fly((reference, candidate), fleet, seconds, seed, disturb, progress, found)
    return list(found.values())


def _fly(
    sides: tuple[Side, Side],
    fleet: Sequence[Member],
    seconds: float,
    seed: int,
    disturb: Disturb | None,
    progress: Callable[[float], None] | None,
    found: dict[str, Comparison],
) -> None:
    worlds = [Formation(fleet, side.name, side.platform, seed, side.parameters) for side in sides]
    for world, side in zip(worlds, sides, strict=True):
        world.check_provider(side.number)
    names = _common_logs(sides)
    samplers = [_Sampler(world, side.number, names) for world, side in zip(worlds, sides, strict=True)]
    judges = _judges(sides, fleet, worlds[0].pilots, found)
    total = round((min(seconds, worlds[0].seconds) + _AFTERWARDS) * 1000)
    # both at the same tick, whatever each thinks about being ready
    while (done := worlds[0].ticks_under_way) < total:
        if progress is not None and done % 100 == 0:
            progress(done / total)
        if disturb is not None:
            for drone in worlds[1].world.drones:
                disturb(drone, worlds[1].tick)
        for world, sampler in zip(worlds, samplers, strict=True):
            world.step()
            sampler.sample()
        if samplers[0].count == _CHUNK:
            _compare_chunk(judges, samplers)
    _compare_chunk(judges, samplers)
    for judge, *drones in zip(judges, *(world.world.drones for world in worlds), strict=True):
        judge.finish()
        for role, drone in zip(("reference", "candidate"), drones, strict=True):
            if drone.failure is not None:
                judge.result.failures[role] = drone.failure


def _judges(
    sides: tuple[Side, Side], fleet: Sequence[Member], pilots: Sequence[Pilot], found: dict[str, Comparison]
) -> list[_Judge]:
    has_own_loop = any(side.has_own_loop for side in sides)
    return [
        _Judge(found[member.name], pilot, round(member.settles_s * 1000) if has_own_loop else None)
        for member, pilot in zip(fleet, pilots, strict=True)
    ]


def _compare_chunk(judges: Sequence[_Judge], samplers: Sequence[_Sampler]) -> None:
    first, second = (sampler.take() for sampler in samplers)
    for index, judge in enumerate(judges):
        judge.look(first.of(index), second.of(index))


def _common_logs(sides: tuple[Side, Side]) -> list[str]:
    first, second = (log_table(side.number) for side in sides)
    return [name for name, variable in first.items() if name in second and second[name].dtype == variable.dtype]


@dataclass(frozen=True)
class _Stretch:
    """A stretch of the flight of one drone."""

    ticks: NDArray[Any]  # (T,)
    truth: NDArray[np.float64]  # (T, 6)
    rows: NDArray[np.uint8]  # (T, bytes of all log variables)
    slots: Mapping[str, tuple[int, int, np.dtype]]  # by name: where a variable lies in a row, and its type
    refused: NDArray[np.int32]  # (T,)

    def until(self, tick: int) -> _Stretch:
        """Return the part up to a tick."""
        count = int(np.searchsorted(self.ticks, tick, "right"))
        ticks, truth, rows, refused = (a[:count] for a in (self.ticks, self.truth, self.rows, self.refused))
        return _Stretch(ticks, truth, rows, self.slots, refused)

    def since(self, tick: int) -> _Stretch:
        """Return the part from a tick on."""
        first = int(np.searchsorted(self.ticks, tick, "left"))
        ticks, truth, rows, refused = (a[first:] for a in (self.ticks, self.truth, self.rows, self.refused))
        return _Stretch(ticks, truth, rows, self.slots, refused)

    def variable(self, name: str) -> NDArray[Any]:
        """Return a log variable, shape (T,)."""
        start, end, dtype = self.slots[name]
        return np.ascontiguousarray(self.rows[:, start:end]).view(dtype)[:, 0]


@dataclass(frozen=True)
class _Chunk:
    """A stretch of a flight of all drones."""

    ticks: NDArray[Any]  # (T,)
    rows: NDArray[np.uint8]  # (T, N, bytes)
    poses: NDArray[np.float64]  # (T, N, 7)
    refused: NDArray[np.int32]  # (T, N)
    slots: Mapping[str, tuple[int, int, np.dtype]]

    def of(self, index: int) -> _Stretch:
        """Return the part of one drone."""
        pose = self.poses[:, index]
        truth = np.column_stack([pose[:, :3], roll_pitch_yaw_deg(pose[:, 3:])])
        return _Stretch(self.ticks, truth, self.rows[:, index], self.slots, self.refused[:, index])


class _Sampler:
    """Keeps all log variables and the true pose of all drones of a world, tick by tick."""

    def __init__(self, formation: Formation, provider: int, names: Sequence[str]) -> None:
        self._formation = formation
        self._drones = formation.world.drones
        table = log_table(provider)
        places, self._slots, start = [], {}, 0
        for name in names:
            variable = table[name]
            size = variable.dtype.itemsize
            places.append(np.arange(variable.offset, variable.offset + size))
            self._slots[name] = (start, start + size, variable.dtype)
            start += size
        self._index = np.concatenate(places)
        self._memory = formation.view(0, self._drones[0].memory.nbytes)
        self._pose_places = np.concatenate([np.arange(d.qpos_address, d.qpos_address + 7) for d in self._drones])
        self._qpos = formation.world.data.qpos
        count = len(self._drones)
        self._rows = np.zeros((_CHUNK, count, start), np.uint8)
        self._poses = np.zeros((_CHUNK, count * 7))
        self._refused = np.zeros((_CHUNK, count), np.int32)
        self._ticks = np.zeros(_CHUNK, np.int64)
        self.count = 0

    def sample(self) -> None:
        """Keep the present instant."""
        i = self.count
        lib.cf_refresh_logs(self._drones[0].struct, len(self._drones), self._memory.strides[0])
        self._memory.take(self._index, axis=1, out=self._rows[i])
        self._qpos.take(self._pose_places, out=self._poses[i])
        self._refused[i] = [len(pilot.refused) for pilot in self._formation.pilots]
        self._ticks[i] = self._formation.tick
        self.count += 1

    def take(self) -> _Chunk:
        """Return what was kept since the last call; it is valid until the next sample."""
        count, self.count = self.count, 0
        poses = self._poses[:count].reshape(count, len(self._drones), 7)
        return _Chunk(self._ticks[:count].copy(), self._rows[:count], poses, self._refused[:count], self._slots)


class _Judge:
    """Compares one drone with itself, stretch by stretch, until shortly after its last leg."""

    def __init__(self, result: Comparison, pilot: Pilot, settles: int | None) -> None:
        """Judge a flight; `settles` (ms) is how long an own loop may take, None: both fly in the same loop."""
        self.result = result
        self._pilot = pilot
        self._settles = settles
        self._deviations: dict[str, Deviation] = {}
        self._traces: dict[str, list[Trace]] = {}
        self._outcomes: dict[str, tuple[NDArray[Any], NDArray[Any], NDArray[Any]]] = {}

    def look(self, reference: _Stretch, candidate: _Stretch) -> None:
        """Compare a stretch."""
        first, second = reference, candidate
        if self._settles is not None:
            if self._pilot.start is None:
                return
            begin = self._pilot.start + self._settles
            first, second = first.since(begin), second.since(begin)
        if self._pilot.start is not None:
            end = self._pilot.start + self._pilot.ticks + round(_AFTERWARDS * 1000)
            first, second = first.until(end), second.until(end)
        if not len(first.ticks):
            return
        for i, name in enumerate(_TRUTH):
            self._compare(name, first.truth[:, i], second.truth[:, i], first.ticks)
            turn = self._deviations[name].tolerance.turn
            piece = trace(first.truth[:, i], second.truth[:, i], first.ticks, turn, _POINTS)
            self._traces.setdefault(name, []).append(piece)
        self._compare("refused commands", first.refused, second.refused, first.ticks)
        # most bytes of most drones are equal, and the others are few
        is_same = (first.rows == second.rows).all(axis=0)
        for name, (begin, end, dtype) in first.slots.items():
            if is_same[begin:end].all():
                self._note(name, dtype, len(first.ticks))
            else:
                self._compare(name, first.variable(name), second.variable(name), first.ticks)
        for name in _OUTCOMES & first.slots.keys():
            self._outcomes[name] = tuple(
                a[-1:].copy() for a in (first.variable(name), second.variable(name), first.ticks)
            )

    def _tolerance(self, name: str, dtype: np.dtype) -> Tolerance:
        known = self._deviations.get(name)
        table = FLIGHT if self._settles is None else OWN_LOOP
        return known.tolerance if known else tolerance_of(name, dtype, table)

    def _note(self, name: str, dtype: np.dtype, samples: int) -> None:
        """Note a stretch without any deviation."""
        ulps = 0 if dtype.kind == "f" else None
        self._add(Deviation(name, self._tolerance(name, dtype), samples=samples, max_ulps=ulps))

    def _compare(self, name: str, first: NDArray[Any], second: NDArray[Any], ticks: NDArray[Any]) -> None:
        self._add(measure(name, first, second, ticks, self._tolerance(name, first.dtype)))

    def _add(self, deviation: Deviation) -> None:
        known = self._deviations.get(deviation.signal)
        self._deviations[deviation.signal] = join(known, deviation) if known else deviation

    def finish(self) -> None:
        """Judge outcomes, put the worst first, and keep pictures of the motion where it deviates."""
        for name, (first, second, tick) in self._outcomes.items():
            self._compare(f"outcome of {name}", first, second, tick)
        deviations = sorted(self._deviations.values(), key=lambda deviation: deviation.severity, reverse=True)
        self.result.deviations = deviations
        moved = [deviation.signal for deviation in deviations if deviation.signal in _TRUTH and deviation.deviating]
        for name in moved[:TRACES]:
            pieces = self._traces[name]
            self.result.traces[name] = Trace(
                *(np.concatenate([getattr(piece, part) for piece in pieces]) for part in Trace.__dataclass_fields__)
            )
