"""Parameters and log variables of one drone, as dictionaries."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.onboard.core import provider_functions
from crazychoir_fw.onboard.variables import Variable, find
from crazychoir_fw.simulation.clients.uplink import Uplink

UpdateCallback = Callable[[str, str], None]
"""Called with the complete name of a parameter and its value as text."""

_LAZY_LOG_GROUPS = ("stateEstimateZ.", "ctrltargetZ.", "sim.contacts")
"""Log groups that the core computes only when they are read (`cf_refresh_logs`)."""


def is_computed_when_read(variable: Variable, provider: int) -> bool:
    """Tell whether `cf_refresh_logs` is called before a log variable is read.

    Args:
        variable: One of `log_table(provider)`.
        provider: Number of the provider.
    """
    if variable.name.startswith(_LAZY_LOG_GROUPS):
        return True
    # software that is loaded may compute any of its log variables
    is_of_provider = variable.offset >= ffi.offsetof("cf_t", "provider_state")
    return is_of_provider and bool(provider_functions(provider).refresh_logs != ffi.NULL)


class _Variables(Mapping[str, float]):
    """Values of one drone by name; subclasses say what may be written."""

    _kind = "variable"

    def __init__(self, name: str, memory: NDArray[np.uint8], table: Mapping[str, Variable]) -> None:
        self._name = name
        self._memory = memory
        self._table = table

    def _cell(self, name: str) -> tuple[Variable, NDArray[Any]]:
        variable = find(self._table, name, self._kind, self._name)
        end = variable.offset + variable.dtype.itemsize
        return variable, self._memory[variable.offset : end].view(variable.dtype)

    def __getitem__(self, name: str) -> float | int:
        return self._cell(name)[1][0].item()

    def __iter__(self) -> Iterator[str]:
        return iter(self._table)

    def __len__(self) -> int:
        return len(self._table)

    def __repr__(self) -> str:
        return f"<{len(self)} {self._kind}s of {self._name}>"


class Log(_Variables):
    """Log variables: ``drone.log["stateEstimate.x"]``."""

    _kind = "log variable"

    def __init__(self, name: str, memory: NDArray[np.uint8], table: Mapping[str, Variable], cf: Any) -> None:
        super().__init__(name, memory, table)
        self._cf = cf
        # software that is loaded may compute any of its log variables
        self._is_lazy = provider_functions(cf.config.provider).refresh_logs != ffi.NULL

    def __getitem__(self, name: str) -> float | int:
        if self._is_lazy or str(name).startswith(_LAZY_LOG_GROUPS):
            lib.cf_refresh_logs(self._cf, 1, 0)
        return super().__getitem__(name)


class Param(_Variables):
    """Parameters: ``drone.param["stabilizer.controller"] = 1``, or cflib's `set_value` and `get_value`."""

    _kind = "parameter"

    def __init__(
        self,
        name: str,
        memory: NDArray[np.uint8],
        table: Mapping[str, Variable],
        cf: Any,
        watched: dict[str, Param],
        uplink: Uplink,
    ) -> None:
        super().__init__(name, memory, table)
        self._cf = cf
        self._uplink = uplink
        uplink.handle("param", self._write)
        # what runs when a client writes is rare: drones without it are not asked
        self._is_heard = provider_functions(cf.config.provider).parameter_written != ffi.NULL
        self._watched = watched  # of the world: the parameters with callbacks
        self._callbacks: dict[str, list[UpdateCallback]] = {}
        self._reported: dict[str, float | int] = {}

    def __setitem__(self, name: str, value: float | int | str) -> None:
        variable = find(self._table, name, self._kind, self._name)
        if variable.is_read_only:
            raise StateError(f"{self._name}: parameter {name} is read-only")
        self._uplink.request("param", name, self._converted(variable, value))

    def _write(self, name: str, number: float | int) -> None:
        self._cell(name)[1][0] = number
        if self._is_heard:
            group, _, member = name.partition(".")
            lib.cf_parameter_written(self._cf, group.encode(), member.encode())
        if name in self._callbacks:
            self._report(name)

    def _converted(self, variable: Variable, value: float | int | str) -> float | int:
        try:
            number = float(value)
        except (TypeError, ValueError):
            number = float("nan")
        kind = variable.dtype
        if kind.kind == "f":
            if np.isfinite(number) and abs(number) <= float(np.finfo(kind).max):
                return number
            raise RangeError(f"{self._name}: {variable.name} is {value!r}, allowed: a finite number")
        limits = np.iinfo(kind)
        if not (number.is_integer() and limits.min <= number <= limits.max):
            raise RangeError(
                f"{self._name}: {variable.name} is {value!r}, allowed: a whole number {limits.min} to {limits.max}"
            )
        return int(number)

    def set_value(self, name: str, value: float | int | str) -> None:
        """Write a parameter; text is converted as cflib does."""
        self[name] = value

    def add_update_callback(
        self, group: str | None = None, name: str | None = None, cb: UpdateCallback | None = None
    ) -> None:
        """Have `cb(complete name, value as text)` called, as in cflib.

        It is called at every write of this client, and at the end of every step of the world in which the drone itself
        changed the parameter: a request that cleared itself, a choice that was not accepted.

        Args:
            group: Group of the parameters; None means all parameters.
            name: Name within the group; None means the whole group.
            cb: What to call.

        Raises:
            UnknownNameError: If there is no such parameter or group.
        """
        if cb is None:
            raise RangeError(f"{self._name}: add_update_callback needs a function to call")
        for complete_name in self._names(group, name):
            self._callbacks.setdefault(complete_name, []).append(cb)
            self._reported.setdefault(complete_name, self[complete_name])
        self._watched[self._name] = self

    def remove_update_callback(
        self, group: str | None = None, name: str | None = None, cb: UpdateCallback | None = None
    ) -> None:
        """Stop calling `cb`, or all callbacks where it is None, for the parameters that these names mean."""
        for complete_name in self._names(group, name):
            kept = [known for known in self._callbacks.get(complete_name, []) if cb is not None and known != cb]
            if kept:
                self._callbacks[complete_name] = kept
            else:
                self._callbacks.pop(complete_name, None)
                self._reported.pop(complete_name, None)
        if not self._callbacks:
            self._watched.pop(self._name, None)

    def report_changes(self) -> None:
        """Call back for every parameter that changed since the last call; the world does so at the end of a step."""
        for name in list(self._reported):
            if self[name] != self._reported.get(name):
                self._report(name)

    def _report(self, name: str) -> None:
        self._reported[name] = self[name]
        for callback in list(self._callbacks[name]):
            callback(name, self.get_value(name))

    def _names(self, group: str | None, name: str | None) -> list[str]:
        if group is None:
            return list(self)
        if name is not None:
            return [find(self._table, f"{group}.{name}", self._kind, self._name).name]
        names = [known for known in self if known.startswith(f"{group}.")]
        return names or [find(self._table, f"{group}.", self._kind, self._name).name]

    def get_value(self, name: str) -> str:
        """Return a parameter as text, as cflib does."""
        return str(self[name])
