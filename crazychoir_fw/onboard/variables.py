"""Parameters and log variables: the C tables as Python dictionaries, by the names that cflib uses."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import UnknownNameError
from crazychoir_fw.onboard.core import check, platform_names, provider_functions

_DTYPES: dict[int, np.dtype] = {
    lib.CF_TYPE_UINT8: np.dtype(np.uint8),
    lib.CF_TYPE_UINT16: np.dtype(np.uint16),
    lib.CF_TYPE_UINT32: np.dtype(np.uint32),
    lib.CF_TYPE_INT8: np.dtype(np.int8),
    lib.CF_TYPE_INT16: np.dtype(np.int16),
    lib.CF_TYPE_INT32: np.dtype(np.int32),
    lib.CF_TYPE_FLOAT: np.dtype(np.float32),
}
_MAX_TABLES = 64


@dataclass(frozen=True)
class Variable:
    """One parameter or log variable of a drone."""

    name: str
    """Complete name as in cflib, e.g. ``stateEstimate.x``."""
    dtype: np.dtype
    """Type on the drone."""
    offset: int
    """Place within ``cf_t`` (bytes)."""
    is_core: bool
    """Part of the firmware's stable API."""
    is_persistent: bool
    """Can be stored on the drone."""
    is_read_only: bool
    """Clients may not write it."""


def read_tables(fill: Callable[[Any, int], int]) -> dict[str, Variable]:
    """Return what a C function lists that fills at most so many tables and returns how many there are."""
    tables = ffi.new("cf_variables_t[]", _MAX_TABLES)
    count = fill(tables, _MAX_TABLES)
    if count > _MAX_TABLES:
        raise RuntimeError(f"{count} tables of variables, room for {_MAX_TABLES}: raise _MAX_TABLES")
    found = {}
    for table in tables[0:count]:
        for row in table.rows[0 : table.count]:
            name = f"{ffi.string(row.group).decode()}.{ffi.string(row.name).decode()}"
            found[name] = Variable(
                name=name,
                dtype=_DTYPES[row.type],
                offset=table.base + row.offset,
                is_core=bool(row.flags & lib.CF_CORE),
                is_persistent=bool(row.flags & lib.CF_PERSISTENT),
                is_read_only=bool(row.flags & lib.CF_READ_ONLY),
            )
    return found


@functools.cache
def parameter_table(provider: int = 0) -> Mapping[str, Variable]:
    """Return all parameters of a drone with this provider, by name, in the order of the drone's table."""
    provider_functions(provider)
    return read_tables(functools.partial(lib.cf_parameters, provider))


@functools.cache
def log_table(provider: int = 0) -> Mapping[str, Variable]:
    """Return all log variables of a drone with this provider, by name, in the order of the drone's table."""
    provider_functions(provider)
    return read_tables(functools.partial(lib.cf_logs, provider))


def factory_values(platform: str, table: Mapping[str, Variable], provider: int = 0) -> dict[str, float | int]:
    """Return the values of parameters or log variables right after boot, by name.

    Args:
        platform: ``cf2`` or ``cf21bl``.
        table: Which variables: `parameter_table()` or `log_table()`.
        provider: Number of the provider.

    Raises:
        UnknownNameError: If there is no such platform or provider.
    """
    names = platform_names()
    if platform not in names:
        raise UnknownNameError(f"no platform named '{platform}', allowed: {', '.join(names)}")
    provider_functions(provider)
    config, block = ffi.new("cf_config_t *"), ffi.new("uint64_t[]", lib.cf_state_bytes(provider) // 8)
    check(lib.cf_config_default(config, names.index(platform)), platform)
    config.provider = provider
    # with motion capture a client would already have told its deviations
    config.vehicle.positioning, config.estimator = lib.CF_POSITIONING_NONE, lib.StateEstimatorTypeKalman
    check(lib.cf_init(ffi.cast("cf_t *", block), config), platform)
    memory = np.frombuffer(ffi.buffer(block), np.uint8)
    return {
        name: memory[row.offset : row.offset + row.dtype.itemsize].view(row.dtype)[0].item()
        for name, row in table.items()
    }


def find(table: Mapping[str, Variable], name: str, kind: str, who: str) -> Variable:
    """Return a variable by name.

    Raises:
        UnknownNameError: If there is none; the message proposes similar names.
    """
    if name in table:
        return table[name]
    import difflib

    similar = difflib.get_close_matches(str(name), table, n=3, cutoff=0.5)
    hint = f"; did you mean {' or '.join(similar)}?" if similar else ""
    raise UnknownNameError(f"{who}: no {kind} named '{name}'{hint}")
