"""What both providers are fed with: flights of the reference, recorded tick by tick, in a file that can be replayed."""

from __future__ import annotations

import hashlib
import json
import zipfile
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.onboard.core import identity
from crazychoir_fw.parity.fleet import FLEET, Formation, Member
from crazychoir_fw.parity.side import Side
from crazychoir_fw.parity.structs import columns, dtype_of

FORMAT = "crazychoir-fw parity inputs 1"

# what is kept of a drone at the end of every tick: name to (C type, member of cf_t)
_ALWAYS = {
    "tick": ("uint32_t", "onboard.tick"),
    "step": ("stabilizerStep_t", "onboard.step"),
    "is_flying": ("uint8_t", "onboard.supervisor.is_flying"),
}
_LOOP = {
    "sensors": ("sensorData_t", "onboard.sensors.data"),
    "estimate": ("state_t", "onboard.estimate"),
    "commanded": ("setpoint_t", "onboard.commander.setpoint"),
    "setpoint": ("setpoint_t", "onboard.setpoint"),
    "control": ("control_t", "onboard.control"),
    "uncapped": ("motors_thrust_uncapped_t", "onboard.uncapped"),
    "compensated": ("motors_thrust_uncapped_t", "onboard.compensated"),
    "motors": ("motors_thrust_pwm_t", "onboard.motors"),
    "supply_voltage": ("float", "onboard.supply_voltage"),
    "battery_voltage": ("float", "onboard.power.voltage"),
}
_PEERS = {"peers": ("cf_peer_localization_t", "onboard.peers")}
_QUEUE = "onboard.estimator.queue"
_AFTERWARDS = 300  # [ms], what is kept after the last leg of a flight
_NOTHING = 0xFFFFFFFF  # a type that no measurement has


@dataclass
class FlightInputs:
    """One drone's flight, from the first tick of its loop on."""

    name: str
    controller: str
    estimator: str
    """``kalman`` or ``complementary``."""
    parameters: dict[str, float]
    """Those that were set before the flight, by name."""
    tracks: dict[str, NDArray[Any]]
    """Per tick, shape (T,): ``tick`` (ms), ``step``, ``is_flying`` and, for whole loops, structs of the firmware's
    types, as they were at the end of the tick."""
    measurements: NDArray[Any]
    """What the estimator took from its queue, shape (M,): ``tick``, and ``measurement`` with the bytes of
    `measurement_t`; pointers of sweep angles are null."""
    base_stations: NDArray[Any]
    """What sweep angles refer to, one `cf_base_stations_t`, shape (1,)."""

    @property
    def has_loop(self) -> bool:
        """Whether sensors, set-points and motors were recorded as well."""
        return "setpoint" in self.tracks

    def measurements_at(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return where the measurements of each tick begin and end, each shape (T,)."""
        ticks = self.tracks["tick"]
        taken = self.measurements["tick"]
        return np.searchsorted(taken, ticks, "left"), np.searchsorted(taken, ticks, "right")


@dataclass
class Inputs:
    """Everything recorded."""

    flights: dict[str, FlightInputs]
    metadata: dict[str, Any] = field(default_factory=dict)
    """Provider that flew, platform, seed, seconds, versions."""

    @property
    def digest(self) -> str:
        """SHA-256 over all numbers, so that two reports can say that they speak of the same inputs."""
        found = hashlib.sha256()
        for key, array in self._members().items():
            found.update(key.encode())
            # without the padding between members, which files do not keep
            for column in columns(array).values() if array.dtype.names else [array]:
                found.update(column.tobytes())
        return found.hexdigest()

    def _members(self) -> dict[str, NDArray[Any]]:
        members = {}
        for name, flight in self.flights.items():
            for track, array in flight.tracks.items():
                members[f"{name}/{track}"] = array
            members[f"{name}/measurements"] = flight.measurements
            members[f"{name}/base_stations"] = flight.base_stations
        return members

    def save(self, path: Path) -> None:
        """Write an NPZ file; *path* is replaced in one step, or left alone if writing fails."""
        facts = {
            "format": FORMAT,
            "metadata": self.metadata,
            "flights": {
                flight.name: {
                    "controller": flight.controller,
                    "estimator": flight.estimator,
                    "parameters": flight.parameters,
                }
                for flight in self.flights.values()
            },
        }
        with replacing(path) as temporary, temporary.open("wb") as file:
            np.savez_compressed(file, facts=np.array(json.dumps(facts)), **self._members())


def load(path: Path) -> Inputs:
    """Read a file written by `Inputs.save`; nothing in it is ever executed.

    Raises:
        CrazychoirError: If there is no such file, it is something else, or it was recorded by a version whose structs
            have another layout.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            facts = json.loads(str(file["facts"]))
            if facts["format"] != FORMAT:
                raise ValueError(f"its format is '{facts['format']}', not '{FORMAT}'")
            arrays = {key: file[key] for key in file.files if key != "facts"}
            flights = {name: _assemble(name, about, arrays) for name, about in facts["flights"].items()}
            return Inputs(flights, facts["metadata"])
    except OSError as error:
        raise CrazychoirError(f"{path} cannot be read: {error.strerror or error}") from error
    except (ValueError, KeyError, TypeError, AttributeError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise CrazychoirError(f"{path} holds no inputs for this version: {error}; record them again") from error


def _assemble(name: str, about: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> FlightInputs:
    prefix = f"{name}/"
    tracks = {key[len(prefix) :]: array for key, array in arrays.items() if key.startswith(prefix)}
    measurements, stations = tracks.pop("measurements"), tracks.pop("base_stations")
    expected = {track: dtype_of(c_type) for track, (c_type, _) in {**_ALWAYS, **_LOOP, **_PEERS}.items()}
    checked = {track: (array.dtype, expected.get(track, array.dtype)) for track, array in tracks.items()}
    checked["measurements"] = (measurements.dtype, _measurement_dtype())
    checked["base_stations"] = (stations.dtype, dtype_of("cf_base_stations_t"))
    for track, (found, wanted) in checked.items():
        if found != wanted:
            raise ValueError(f"{prefix}{track} has another layout")
    return FlightInputs(
        name, about["controller"], about["estimator"], about["parameters"], tracks, measurements, stations
    )


def _measurement_dtype() -> np.dtype:
    return np.dtype([("tick", "<u4"), ("measurement", np.uint8, (ffi.sizeof("measurement_t"),))])


def record(
    reference: Side,
    seconds: float,
    seed: int = 1,
    fleet: Sequence[Member] = FLEET,
    progress: Callable[[float], None] | None = None,
) -> Inputs:
    """Fly the fleet with the reference provider and keep what its functions were given.

    Args:
        reference: Provider of the world.
        seconds: How long at most, from the moment when the drones can fly.
        seed: Seed of all noise.
        fleet: The drones; those whose controller the provider lacks stay at home.
        progress: Told from time to time which share is done, in [0, 1].
    """
    fleet = [member for member in fleet if reference.has_controller(member.controller)]
    formation = Formation(fleet, reference.name, reference.platform, seed, reference.parameters)
    formation.check_provider(reference.number)
    recorder, queue = _Recorder(formation), _Queue(formation)
    total = round(min(seconds, formation.seconds) * 1000) + _AFTERWARDS
    while (done := formation.ticks_under_way) < total:
        queue.forget()
        formation.step()
        queue.collect(formation.tick)
        recorder.sample()
        if progress is not None and done % 100 == 0:
            progress(done / total)
    recorder.finish()
    queue.finish()
    flights = {}
    for index, member in enumerate(fleet):
        pilot = formation.pilots[index]
        tracks = recorder.tracks(index, (pilot.start or 0) + pilot.ticks + _AFTERWARDS)
        if len(tracks["tick"]):
            measurements = queue.of(index, int(tracks["tick"][0]), int(tracks["tick"][-1]))
            stations = recorder.base_stations(index)
            flights[member.name] = FlightInputs(
                name=member.name,
                controller=member.controller,
                estimator=member.estimator or "kalman",
                parameters=_told(formation, index),
                tracks=tracks,
                measurements=measurements,
                base_stations=stations,
            )
    about = {"provider": reference.name, "platform": reference.platform, "seed": seed, "seconds": seconds}
    return Inputs(flights, {**about, **identity()})


def _told(formation: Formation, index: int) -> dict[str, float]:
    """Return the parameters that were set before the flight: the member's, and where the filter starts."""
    param = formation.world.drones[index].param
    names = [f"kalman.initial{axis}" for axis in ("X", "Y", "Z", "Yaw") if f"kalman.initial{axis}" in param]
    return {name: float(param[name]) for name in [*formation.fleet[index].parameters, *names]}


def _wanted(member: Member) -> dict[str, tuple[str, str]]:
    """Return what is kept of a drone: whole loops only where they are looked at, they take ten times the room."""
    wants_loop = member.positioning == "mocap" or member.estimator == "complementary"
    wants_peers = member.parameters.get("colAv.enable", 0)
    return {**_ALWAYS, **(_LOOP if wants_loop else {}), **(_PEERS if wants_peers else {})}


class _Recorder:
    """Keeps the tracks of all drones: one copy per member and tick, whatever the number of drones."""

    def __init__(self, formation: Formation) -> None:
        self._drones = formation.world.drones
        self._members = [_wanted(member) for member in formation.fleet]
        self._views: dict[str, NDArray[np.uint8]] = {}
        self._owners: dict[str, list[int]] = {}
        for track, (c_type, path) in {**_ALWAYS, **_LOOP, **_PEERS}.items():
            owners = [index for index, members in enumerate(self._members) if track in members]
            if owners:
                offset = ffi.offsetof("cf_t", *path.split("."))
                self._views[track] = formation.view(offset, ffi.sizeof(c_type))
                self._owners[track] = owners
        self._rows: dict[str, list[NDArray[np.uint8]]] = {track: [] for track in self._views}
        self._whole: dict[str, NDArray[np.uint8]] = {}

    def sample(self) -> None:
        """Keep the present instant."""
        for track, view in self._views.items():
            self._rows[track].append(view[self._owners[track]])

    def finish(self) -> None:
        """Put the instants together, before `tracks` is called."""
        self._whole = {track: np.array(rows) for track, rows in self._rows.items()}  # (T, owners, size)
        self._rows.clear()

    def tracks(self, index: int, end: int) -> dict[str, NDArray[Any]]:
        """Return the tracks of one drone, from the first tick of its loop to the tick `end` or its failure."""
        found = {}
        for track, (c_type, _) in self._members[index].items():
            column = self._owners[track].index(index)
            rows = np.ascontiguousarray(self._whole[track][:, column])
            found[track] = rows.view(dtype_of(c_type))[:, 0]
        onboard = self._drones[index].struct.onboard
        last = min(end, onboard.fault_tick - 1) if onboard.fault else end
        is_kept = (found["step"] > 0) & (found["tick"] <= last)
        found = {track: rows[is_kept] for track, rows in found.items()}
        # the loop counts its steps at the end of a tick; its functions got the number before
        found["step"] = found["step"] - np.uint32(1)
        return found

    def base_stations(self, index: int) -> NDArray[Any]:
        """Return what the sweeps of one drone refer to, shape (1,)."""
        offset = ffi.offsetof("cf_t", "onboard", "estimator", "stations")
        rows = self._drones[index].memory[offset : offset + ffi.sizeof("cf_base_stations_t")].copy()
        return rows.view(dtype_of("cf_base_stations_t"))


class _Queue:
    """Sees what passes through the estimators' queues, which are empty at the begin and at the end of a tick.

    What was taken still lies in the memory of the queue: a type that no measurement has marks what was never there.
    """

    def __init__(self, formation: Formation) -> None:
        count = len(formation.world.drones)
        capacity, size = lib.CF_ESTIMATOR_QUEUE_SIZE, ffi.sizeof("measurement_t")
        whole = formation.view(ffi.offsetof("cf_t", *_QUEUE.split(".")), capacity * size)
        self._queues = as_strided(whole, (count, capacity, size), (whole.strides[0], size, 1))
        words = whole[:, :4].view(np.uint32)
        self._types = as_strided(words, (count, capacity), (whole.strides[0], size))
        waiting = formation.view(ffi.offsetof("cf_t", "onboard", "estimator", "queue_count"), 4)
        self._waiting = waiting.view(np.uint32)  # (N, 1)
        self._places = np.arange(capacity)
        self._pieces: list[tuple[int, NDArray[np.intp], NDArray[np.uint8]]] = []
        self._drones = np.empty(0, np.intp)
        self._taken = np.empty(0, _measurement_dtype())

    def forget(self) -> None:
        """Mark what is free, before a tick."""
        self._types[self._places >= self._waiting] = _NOTHING

    def collect(self, tick: int) -> None:
        """Keep what was taken in this tick."""
        drones, places = np.nonzero((self._types != _NOTHING) & (self._waiting == 0))
        if len(drones):
            self._pieces.append((tick, drones, self._queues[drones, places]))

    def finish(self) -> None:
        """Put everything together, before `of` is called."""
        if not self._pieces:
            return
        ticks, drones, rows = zip(*self._pieces, strict=True)
        self._drones = np.concatenate(drones)
        self._taken = np.empty(len(self._drones), _measurement_dtype())
        self._taken["tick"] = np.repeat(ticks, [len(piece) for piece in drones])
        self._taken["measurement"] = np.concatenate(rows)

    def of(self, drone: int, first_tick: int, last_tick: int) -> NDArray[Any]:
        """Return what one drone took, in order."""
        ticks = self._taken["tick"]
        return self._taken[(self._drones == drone) & (ticks >= first_tick) & (ticks <= last_tick)]
