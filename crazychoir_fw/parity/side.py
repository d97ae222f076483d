"""One of the two providers that are compared: its functions, and blocks of state for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import UnknownNameError
from crazychoir_fw.onboard.core import check, platform_names, provider_functions, provider_identity, struct_view
from crazychoir_fw.onboard.variables import Variable, read_tables

PLATFORMS = {name: number for number, name in enumerate(platform_names())}

CONTROLLERS = {"pid": 1, "mellinger": 2, "indi": 3, "brescianini": 4, "lee": 5}
"""Numbers of the controllers by the words of the plugin's attribute."""


class Side:
    """A provider on one platform."""

    def __init__(self, number: int = 0, platform: str = "cf2", parameters: Mapping[str, float] | None = None) -> None:
        """Choose a provider.

        Args:
            number: Its number; 0 is *builtin*.
            platform: ``cf2`` or ``cf21bl``.
            parameters: Values that every block and every drone of this side gets in place of the factory's.

        Raises:
            UnknownNameError: If there is no such provider or platform.
        """
        self.table = provider_functions(number)
        if platform not in PLATFORMS:
            raise UnknownNameError(f"no platform named '{platform}', allowed: {', '.join(PLATFORMS)}")
        self.number = number
        self.name = ffi.string(lib.cf_provider_name(number)).decode()
        self.platform = platform
        self.parameters = dict(parameters or {})
        self.functions: dict[str, Callable[..., Any]] = {
            name: getattr(self.table, name)
            for name, field in ffi.typeof("cf_provider_t").fields
            if field.type.kind in ("function", "pointer") and name != "name" and getattr(self.table, name) != ffi.NULL
        }
        """The functions of the provider's table by name, without those that it lacks."""
        self.parameter_table = read_tables(self.table.parameters)
        self.log_table = read_tables(self.table.logs)

    def __repr__(self) -> str:
        return f"<Side {self.name} on {self.platform}>"

    @property
    def has_own_loop(self) -> bool:
        """Whether the stabilizer loop is the provider's own."""
        return "stabilizer" in provider_identity(self.number).get("modules", ())

    def has(self, *functions: str) -> bool:
        """Return whether the provider's table has all of these functions."""
        return all(name in self.functions for name in functions)

    def has_controller(self, word: str) -> bool:
        """Return whether the provider has the controller ``pid``, ``mellinger`` and so on."""
        return self.table.controller_name(CONTROLLERS[word]) != ffi.NULL

    def boot(self) -> Block:
        """Return a block of state as a drone has it right after boot."""
        return Block(self)

    def factory_values(self) -> dict[str, float | int]:
        """Return the values of the provider's parameters right after boot, without those of this side."""
        block = Block(self, with_parameters=False)
        return {name: block.get(variable) for name, variable in self.parameter_table.items()}


class Block:
    """The state of a provider for one drone."""

    def __init__(self, side: Side, with_parameters: bool = True) -> None:
        self._side = side
        self._is_open = False
        self.functions = side.functions
        # inside a whole drone: a library finds the drone that it stops, or prints for, by the place of its block
        offset = ffi.offsetof("cf_t", "provider_state")
        self._drone = np.zeros(lib.cf_state_bytes(side.number) // 8, np.uint64)
        self.bytes: NDArray[np.uint8] = self._drone.view(np.uint8)[offset:]
        self.state = struct_view("void", self.bytes.ctypes.data)
        self.cf = struct_view("cf_t", self._drone.ctypes.data)
        self.cf.config.provider = side.number
        self.cf.config.platform = PLATFORMS[side.platform]
        check(side.functions["init"](self.state, PLATFORMS[side.platform], 0), f"{side.name} on {side.platform}")
        if with_parameters:
            for name, value in side.parameters.items():
                if name in side.parameter_table:
                    self.set_parameter(name, value)

    def get(self, variable: Variable) -> float | int:
        """Return the value of a parameter or log variable of the provider."""
        return self._cell(variable)[0].item()

    def set_parameter(self, name: str, value: float) -> None:
        """Write a parameter of the provider as a client does."""
        was_open = self._is_open
        self.close()
        self._cell(self._side.parameter_table[name])[0] = value
        written = self._side.functions.get("parameter_written")
        if written is not None:
            group, own = name.split(".", 1)
            written(self.state, group.encode(), own.encode())
        if was_open:
            self.open()

    def open(self) -> None:
        """Begin a series of calls, which saves a provider work; until `close` its variables are not to be read."""
        begin = self._side.functions.get("begin")
        if begin is not None and not self._is_open:
            begin(self.state)
            self._is_open = True

    def close(self) -> None:
        """End a series of calls, if there is one."""
        if self._is_open:
            self._side.functions["end"](self.state)
            self._is_open = False

    def _cell(self, variable: Variable) -> NDArray[Any]:
        return self.bytes[variable.offset : variable.offset + variable.dtype.itemsize].view(variable.dtype)

    @property
    def failure(self) -> str | None:
        """Why the provider gave up on this block, as a sentence, or None."""
        onboard = self.cf.onboard
        if onboard.fault == lib.CF_FAULT_NONE:
            return None
        reason = ffi.string(onboard.failure).decode(errors="replace")
        return reason or ffi.string(lib.cf_fault_text(onboard.fault)).decode()

    def refresh_logs(self) -> None:
        """Bring the log variables up to date that are computed when they are read."""
        refresh = self._side.functions.get("refresh_logs")
        if refresh is not None:
            refresh(self.state)


class LogGatherer:
    """Reads several log variables of a block at once, sample by sample.

    While it is entered, with ``with``, the block is open for a series of calls.
    """

    def __init__(self, side: Side, block: Block, names: list[str], samples: int) -> None:
        self._block = block
        self._variables = [side.log_table[name] for name in names]
        places = [np.arange(v.offset, v.offset + v.dtype.itemsize) for v in self._variables]
        self._index = np.concatenate(places) if places else np.empty(0, np.intp)
        self._rows = np.zeros((samples, len(self._index)), np.uint8)

    def __enter__(self) -> LogGatherer:
        self._block.open()
        return self

    def __exit__(self, *_: object) -> None:
        self._block.close()

    def take(self, sample: int) -> None:
        """Keep the present values as this sample."""
        if not self._variables:
            return
        self._block.refresh_logs()
        self._block.close()
        self._block.bytes.take(self._index, out=self._rows[sample])
        self._block.open()

    def signals(self) -> dict[str, NDArray[Any]]:
        """Return the samples by ``log.group.name``."""
        found, start = {}, 0
        for variable in self._variables:
            end = start + variable.dtype.itemsize
            column = np.ascontiguousarray(self._rows[:, start:end])
            found[f"log.{variable.name}"] = column.view(variable.dtype)[:, 0]
            start = end
        return found
