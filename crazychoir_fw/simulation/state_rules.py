"""Which values the integers of a drone's memory may have, so that a damaged or forged one is refused and not flown.

Truth values, enumerations and pointers follow from their C types. Every other integer needs a row here: `fields` raises
for one that has none, and so does a test, which makes a new member of `cf_t` impossible to forget. Real numbers need
none: the core stops a drone whose numbers are not finite.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import CrazychoirError

Range = tuple[int, int]

_ANY = None
_RULES: tuple[tuple[str, Range | None], ...] = (
    # places in arrays, and how much of them is used
    ("onboard.sensors.gyro_bias.next", (0, lib.CF_GYRO_BIAS_SAMPLES - 1)),
    ("onboard.sensors.acc_scale.count", (0, lib.CF_ACC_SCALE_SAMPLES)),
    ("onboard.estimator.queue_count", (0, lib.CF_ESTIMATOR_QUEUE_SIZE)),
    ("onboard.health.motor", (0, 3)),
    ("onboard.high_level.definitions.offset", (0, lib.CF_TRAJECTORY_MEMORY_BYTES)),
    ("onboard.high_level.definitions.n_pieces", (0, 255)),
    ("vehicle.mocap.oldest", (0, lib.CF_MOCAP_CAPACITY - 1)),
    ("vehicle.mocap.waiting", (0, lib.CF_MOCAP_CAPACITY)),
    ("vehicle.loco.next", (0, lib.CF_LOCO_ANCHORS - 1)),
    ("provider_state.planner.offset", (0, lib.CF_TRAJECTORY_MEMORY_BYTES)),
    ("provider_state.planner.n_pieces", (0, 255)),
    # numbers of a kind, and widths of a shift
    ("config.controller", (lib.ControllerTypeAutoSelect, lib.ControllerTypeLee)),
    ("onboard.controller_type", (lib.ControllerTypePID, lib.ControllerTypeLee)),
    ("provider_state.controller_type", (lib.ControllerTypePID, lib.ControllerTypeLee)),
    ("config.estimator", (lib.StateEstimatorTypeAutoSelect, lib.StateEstimatorTypeKalman)),
    ("onboard.estimator_type", (lib.StateEstimatorTypeAutoSelect, lib.StateEstimatorTypeKalman)),
    ("onboard.estimator.type", (lib.StateEstimatorTypeComplementary, lib.StateEstimatorTypeKalman)),
    ("onboard.health.test", (0, 2)),
    ("*rotors*.duty_bits", (0, 16)),
    ("*rotors*.duty_lowest_level", (0, 65535)),
    # how often something is done in one step
    ("config.vehicle.*rate", (0, 1000)),
    ("vehicle.*.config.*rate", (0, 1000)),
    ("vehicle.*.phase", (0, 1999)),
    ("provider_state.collision_avoidance.params.voronoiProjectionMaxIters", (0, 1_000_000)),
    # the other integers lead nowhere: counters, times, samples, generators, parameters and logs of any value
    ("config.provider", _ANY),  # must be that of the drone, see `check_memory`
    ("config.*", _ANY),
    ("configuration", _ANY),
    ("*timestamp", _ANY),
    ("*tick", _ANY),
    ("*_ms", _ANY),
    ("*Ms", _ANY),
    ("*_us", _ANY),
    ("*countdown", _ANY),
    ("*random.state", _ANY),
    ("*.due", _ANY),
    ("*Timeout", _ANY),
    ("onboard.sensors.*", _ANY),
    ("onboard.estimate.*", _ANY),
    ("onboard.control.*", _ANY),
    ("onboard.held_control.*", _ANY),
    ("onboard.control_yaw", _ANY),
    ("onboard.uncapped.*", _ANY),
    ("onboard.compensated.*", _ANY),
    ("onboard.motors.*", _ANY),
    ("onboard.step", _ANY),
    ("onboard.rate_step", _ANY),
    ("onboard.int_to_out", _ANY),
    ("onboard.radio_id", _ANY),
    ("onboard.compressed_*", _ANY),
    ("onboard.supervisor.*", _ANY),
    ("onboard.power.*", _ANY),
    ("onboard.health.*", _ANY),
    ("onboard.commander.*", _ANY),
    ("onboard.estimator.resetEstimation", _ANY),
    ("onboard.estimator.rejected", _ANY),
    ("onboard.estimator.events", _ANY),
    ("onboard.estimator.*SubSampler.count", _ANY),
    ("onboard.estimator.stations.*.uid", _ANY),
    ("onboard.high_level.group_mask", _ANY),
    ("onboard.high_level.definitions.location", _ANY),
    ("onboard.high_level.definitions.type", _ANY),
    ("onboard.high_level.memory", _ANY),
    ("onboard.system.*", _ANY),
    ("onboard.rpyt.*", _ANY),
    ("onboard.decks.*", _ANY),
    ("onboard.peers.peers.id", _ANY),
    ("onboard.console.*", _ANY),
    ("onboard.failure", _ANY),
    ("onboard.lights.*", _ANY),
    ("vehicle.loco.heard", _ANY),
    ("vehicle.mocap.*left", _ANY),
    ("injected.*", _ANY),
    ("contacts.*", _ANY),
    ("provider_state.kalman.*", _ANY),
    ("provider_state.planner.current.next_offset", _ANY),  # compared with the size wherever it is used
    ("provider_state.pid.*", _ANY),
    ("provider_state.power.*", _ANY),
    ("provider_state.motor_override.*", _ANY),
    ("provider_state.complementary.attitude.is*", _ANY),
    ("provider_state.indi.outerLoopActive", _ANY),
    ("provider_state.collision_avoidance.*", _ANY),
)
"""Patterns of members, in the order in which they are asked; indices of arrays are left out."""

_BOOLEAN, _POINTER = (0, 1), (0, 0)


@dataclass(frozen=True)
class Field:
    """An integer of a drone's memory, or an array of them."""

    path: str
    offset: int
    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    strides: tuple[int, ...]
    allowed: Range

    def read(self, memory: NDArray[np.uint8]) -> NDArray[Any]:
        """Return its values."""
        return np.ndarray(self.shape, self.dtype, memory.data, self.offset, self.strides)


@cache
def fields() -> tuple[Field, ...]:
    """Return all integers whose values matter.

    Raises:
        CrazychoirError: If an integer has no rule.
    """
    provider_state = ffi.offsetof("cf_t", "provider_state")
    found = [*_walk(ffi.typeof("cf_t"), "", 0, (), ())]
    found += _walk(ffi.typeof("cf_builtin_t"), "provider_state", provider_state, (), ())
    return tuple(field for field in found if field is not None)


def _walk(
    kind: Any, path: str, offset: int, shape: tuple[int, ...], strides: tuple[int, ...]
) -> Iterator[Field | None]:
    if path == "provider_state" and kind.kind == "array":
        return  # opaque here; the builtin provider's is walked by its own type
    if kind.kind in ("struct", "union"):
        if path == "onboard.estimator.queue.data":
            return  # which of its members counts, the type says; `_measurements` checks it
        for name, member in kind.fields:
            yield from _walk(member.type, f"{path}.{name}".lstrip("."), offset + member.offset, shape, strides)
    elif kind.kind == "array":
        size = ffi.sizeof(kind.item)
        yield from _walk(kind.item, path, offset, (*shape, kind.length), (*strides, size))
    elif (allowed := _allowed(kind, path)) is not None:
        # an enumeration may come as any number of bytes that its compiler chose
        dtype = np.dtype("u1") if kind.cname == "_Bool" else _integer(kind)
        yield Field(path, offset, dtype, shape, strides, allowed)


def _allowed(kind: Any, path: str) -> Range | None:
    if kind.kind == "enum":
        return min(kind.elements), max(kind.elements)
    if kind.kind in ("pointer", "function"):
        return _POINTER
    if kind.cname == "_Bool":
        return _BOOLEAN
    if kind.cname in ("float", "double"):
        return None
    for pattern, allowed in _RULES:
        if fnmatchcase(path, pattern):
            return allowed
    raise CrazychoirError(f"the member {path} of a drone's memory has no rule in {__name__}")


def _integer(kind: Any) -> np.dtype[Any]:
    is_signed = kind.kind == "primitive" and int(ffi.cast(kind, -1)) < 0
    return np.dtype(f"{'i' if is_signed or kind.kind == 'enum' else 'u'}{ffi.sizeof(kind)}")
