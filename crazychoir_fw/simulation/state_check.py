"""Whether the memory of a drone that comes from a file can be flown: a forged one must not lead C astray."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.onboard.core import address_of, struct_view
from crazychoir_fw.simulation.state_rules import fields

_FITTED = {
    lib.CF_POSITIONING_MOCAP: "vehicle.mocap.",
    lib.CF_POSITIONING_MOCAP_POSITION: "vehicle.mocap.",
    lib.CF_POSITIONING_FLOW: "vehicle.flow_deck.",
    lib.CF_POSITIONING_LIGHTHOUSE: "vehicle.lighthouse.",
    lib.CF_POSITIONING_LOCO_TWR: "vehicle.loco.",
    lib.CF_POSITIONING_LOCO_TDOA2: "vehicle.loco.",
    lib.CF_POSITIONING_LOCO_TDOA3: "vehicle.loco.",
}
"""Members of the union of positioning systems, of which the one that is fitted counts."""

_PIECE_BYTES, _START_BYTES = ffi.sizeof("struct poly4d"), lib.PPTRAJ_COMPRESSED_START_BYTES
BUILTIN = 0
"""Number of the provider whose memory is known here."""


def check_memory(memory: NDArray[np.uint8], who: str, provider: int, platform: int) -> None:
    """Refuse memory that C could not work with.

    Args:
        memory: Everything that a drone is, a whole ``cf_t``, shape (bytes,).
        who: Name of the drone.
        provider: Number of its provider.
        platform: Number of its platform.

    Raises:
        RangeError: If a value is out of its range; the text names the member, its value and the range. Or if the
            provider is a library: nothing here knows what its memory means.
    """
    check_kind(memory, who, provider, platform)
    if provider != BUILTIN:
        raise RangeError(
            f"{who}: flies a provider library, whose memory in a file cannot be checked; if you know who wrote the "
            "file, load it with trust=True"
        )
    cf = struct_view("cf_t", address_of(memory))
    for field in fields():
        fitted = next((member for member in _FITTED.values() if field.path.startswith(member)), None)
        if fitted is not None and fitted != _FITTED.get(int(cf.vehicle.positioning)):
            continue
        values, (low, high) = field.read(memory), field.allowed
        if values.min() < low or values.max() > high:
            wrong = values.max() if values.max() > high else values.min()
            raise RangeError(f"{who}: the snapshot is damaged: {field.path} is {wrong}, allowed: {low} to {high}")
    _check_queue(cf, who)
    _check_trajectories(cf, who)


def check_kind(memory: NDArray[np.uint8], who: str, provider: int, platform: int) -> None:
    """Refuse the memory of a drone of another provider or platform; arguments as of `check_memory`.

    Raises:
        RangeError: If it is.
    """
    config = struct_view("cf_t", address_of(memory)).config
    if (config.provider, int(config.platform)) != (provider, platform):
        raise RangeError(
            f"{who}: the snapshot is one of provider {config.provider} and platform {int(config.platform)}, "
            f"allowed: {provider} and {platform}"
        )


def _check_queue(cf: Any, who: str) -> None:
    """Refuse sweeps of stations that do not exist: what they point at is looked up by these numbers."""
    for i in range(cf.onboard.estimator.queue_count):
        entry = cf.onboard.estimator.queue[i]
        if entry.type != lib.MeasurementTypeSweepAngle:
            continue
        sweep = entry.data.sweepAngle
        if not (
            sweep.baseStationId < lib.CF_LIGHTHOUSE_STATIONS
            and sweep.sweepId < lib.CF_LIGHTHOUSE_SWEEPS
            and sweep.sensorId < lib.CF_LIGHTHOUSE_SENSORS
        ):
            raise RangeError(f"{who}: the snapshot is damaged: onboard.estimator.queue[{i}] is no sweep of a station")


def _check_trajectories(cf: Any, who: str) -> None:
    """Refuse trajectories that do not lie within the trajectory memory."""
    planner = ffi.cast("cf_builtin_t *", cf.provider_state).planner
    for i, definition in enumerate(cf.onboard.high_level.definitions):
        if definition.location != lib.CF_TRAJECTORY_LOCATION_INVALID:
            is_compressed = definition.type == lib.CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED
            _check_place(f"trajectory {i}", definition, is_compressed, who)
    if planner.source in (lib.CF_PLAN_UPLOADED, lib.CF_PLAN_COMPRESSED):
        _check_place("the plan", planner, planner.source == lib.CF_PLAN_COMPRESSED, who)
    elif planner.n_pieces > 1:
        raise RangeError(f"{who}: the snapshot is damaged: the plan has {planner.n_pieces} pieces, allowed: 1")


def _check_place(what: str, place: Any, is_compressed: bool, who: str) -> None:
    length = _START_BYTES if is_compressed else _PIECE_BYTES * place.n_pieces
    is_aligned = is_compressed or place.offset % 4 == 0
    if not is_aligned or place.offset + length > lib.CF_TRAJECTORY_MEMORY_BYTES:
        raise RangeError(
            f"{who}: the snapshot is damaged: {what} lies at {place.offset} with {length} bytes, "
            f"allowed: within {lib.CF_TRAJECTORY_MEMORY_BYTES}"
        )
