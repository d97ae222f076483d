"""The log variables of a whole swarm as strided views of the world's memory.

A log variable is one number at a fixed place of a drone's memory. Drones with one provider are alike, and where they
stand at equal distances one view is that variable of all of them. Drones with different providers have different
variables and different sizes, so that a mixed swarm falls into parts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.onboard.arrays import filled_by_core
from crazychoir_fw.onboard.variables import log_table

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone
    from crazychoir_fw.simulation.world import World


_GAP = 12  # [bytes] between variables that are copied along: they cost less than another stretch
_WORD = 4  # [bytes] to which stretches are widened, so that readers of a copy may take it word by word


@cache
def _stretches_of(provider: int) -> tuple[list[tuple[int, int]], dict[str, list[Any]]]:
    """Return the stretches of memory that hold log variables, and where in a copy each variable is, of what type.

    Both depend on the provider alone; finding them takes longer than everything else that a part needs.
    """
    table = log_table(provider)
    stretches: list[list[int]] = []
    for offset, size in sorted((variable.offset, variable.dtype.itemsize) for variable in table.values()):
        begin, end = offset - offset % _WORD, -(-(offset + size) // _WORD) * _WORD
        if stretches and begin <= stretches[-1][1] + _GAP:
            stretches[-1][1] = max(stretches[-1][1], end)
        else:
            stretches.append([begin, end])
    begins = np.array([begin for begin, _ in stretches])
    sizes = np.array([end - begin for begin, end in stretches])
    copied = np.concatenate([[0], np.cumsum(sizes)])
    places = {}
    for name, variable in table.items():
        at = int(np.searchsorted(begins, variable.offset, side="right")) - 1
        places[name] = [int(copied[at]) + variable.offset - stretches[at][0], variable.dtype.str]
    return [(begin, end) for begin, end in stretches], places


class SwarmPart:
    """Drones of a world with the same provider, at equal distances in memory."""

    def __init__(self, numbers: Sequence[int], drones: Sequence[Drone]) -> None:
        self.numbers = np.array(numbers)
        """Which drones of the world, shape (n,)."""
        self._first = drones[0]
        self._stride = _distance(drones[0], drones[1]) if len(drones) > 1 else drones[0].memory.nbytes
        self._bounds, self._places = _stretches_of(drones[0].provider_number)
        self._c_bounds = ffi.new("uint32_t[]", [edge for bounds in self._bounds for edge in bounds])

    @cached_property
    def views(self) -> dict[str, NDArray[Any]]:
        """Each log variable of these drones as a live view of the world's memory, shape (n,)."""
        return {
            name: self._view(variable.offset, variable.dtype)
            for name, variable in log_table(self._first.provider_number).items()
        }

    def _view(self, offset: int, dtype: np.dtype) -> NDArray[Any]:
        cell = self._first.memory[offset : offset + dtype.itemsize].view(dtype)
        return as_strided(cell, shape=(len(self.numbers),), strides=(self._stride,), writeable=False)

    @property
    def copy_shape(self) -> tuple[int, int]:
        """Number of drones, and of the bytes of each in a copy."""
        return len(self.numbers), sum(end - begin for begin, end in self._bounds)

    def fill(self, part: Any) -> None:
        """Fill a ``cf_sampled_part_t``, which copies the memory that all log variables live in, up to date.

        `layout` says where each of them is in a copy. Variables lie in a few stretches: copying those costs a tenth of
        copying each variable.
        """
        part.first, part.stride, part.count = self._first.struct, self._stride, len(self.numbers)
        part.bounds, part.stretches, part.bytes = self._c_bounds, len(self._bounds), self.copy_shape[1]

    def gather(self, names: Sequence[str]) -> Callable[[], NDArray[np.float64]]:
        """Return what reads some log variables of these drones, shape (n, len(names)).

        Where all of them are floats, one call copies them all; copying each view takes ten times as long.
        """
        found = [log_table(self._first.provider_number)[name] for name in names]
        if any(variable.dtype != np.float32 for variable in found):
            return lambda: np.stack([np.asarray(self.views[name], float) for name in names], axis=1)
        offsets = ffi.new("uint32_t[]", [variable.offset for variable in found])
        first, stride, shape = self._first.struct, self._stride, (len(self.numbers), len(found))

        def read() -> NDArray[np.float64]:
            values = np.empty(shape)
            lib.cf_gather_floats(filled_by_core(values), first, shape[0], stride, offsets, shape[1])
            return values

        return read

    @property
    def layout(self) -> dict[str, Any]:
        """Which drones of the world these are, and where in a copy each log variable is, of what type."""
        return {"numbers": self.numbers.tolist(), "places": self._places}

    def refresh(self) -> None:
        """Bring those log variables up to date that are only computed for readers."""
        lib.cf_refresh_logs(self._first.struct, len(self.numbers), self._stride)


def swarm_parts(world: World) -> list[SwarmPart]:
    """Return the parts of a world; a swarm with one provider is one part."""
    parts = []
    for provider in dict.fromkeys(drone.provider_number for drone in world.drones):
        alike = [i for i, drone in enumerate(world.drones) if drone.provider_number == provider]
        parts += [SwarmPart(run, [world.drones[i] for i in run]) for run in _runs(alike, world.drones)]
    return parts


def swarm_views(world: World) -> dict[str, NDArray[Any]]:
    """Return each log variable of all drones as a live view of the world's memory, shape (N,).

    The groups `stateEstimateZ` and `ctrltargetZ` are as old as the latest call of `cf_refresh_logs`.

    Raises:
        RangeError: If there is no such view, because the drones have different providers.
    """
    parts = swarm_parts(world)
    if len(parts) != 1:
        raise RangeError("the drones have different providers, or other engine plugins stand between them")
    return parts[0].views


def _runs(numbers: Sequence[int], drones: Sequence[Drone]) -> Iterator[list[int]]:
    """Split drones into runs at equal distances."""
    run = [numbers[0]]
    for number in numbers[1:]:
        distance = _distance(drones[run[-1]], drones[number])
        if len(run) > 1 and distance != _distance(drones[run[0]], drones[run[1]]):
            yield run
            run = []
        run.append(number)
    yield run


def _distance(one: Drone, other: Drone) -> int:
    """Return how far apart two drones stand in memory (bytes)."""
    return int(other.memory.ctypes.data - one.memory.ctypes.data)
