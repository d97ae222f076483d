"""Drones of two providers, asked the same questions."""

from typing import Any

import numpy as np

from crazychoir_fw._core import ffi, lib

C_TYPES = {
    lib.CF_TYPE_UINT8: "uint8_t *",
    lib.CF_TYPE_UINT16: "uint16_t *",
    lib.CF_TYPE_UINT32: "uint32_t *",
    lib.CF_TYPE_INT8: "int8_t *",
    lib.CF_TYPE_INT16: "int16_t *",
    lib.CF_TYPE_INT32: "int32_t *",
    lib.CF_TYPE_FLOAT: "float *",
}


class Drone:
    """One drone of a provider, whose functions are called by hand.

    Functions of the provider are methods: the block is passed for them.
    """

    def __init__(self, provider: int, platform: int = lib.CF_PLATFORM_CF2) -> None:
        config = ffi.new("cf_config_t *")
        assert lib.cf_config_default(config, platform) == lib.CF_OK
        config.provider = provider
        self.provider = provider
        self.known = {}
        self.memory = ffi.new("double[]", lib.cf_state_bytes(provider) // 8)
        self.cf = ffi.cast("cf_t *", self.memory)
        assert lib.cf_init(self.cf, config) == lib.CF_OK
        self.said_at_boot = len(self.console())

    def __getattr__(self, name: str) -> Any:
        function = getattr(lib.cf_provider(self.provider), name)
        return lambda *arguments: function(self.cf.provider_state, *arguments)

    @property
    def table(self) -> Any:
        """The provider's table, for this thread."""
        return lib.cf_provider(self.provider)

    def variables(self, which: str) -> dict[str, tuple[int, int, int]]:
        """Return type, flags and offset of every parameter (`parameters`) or log variable (`logs`) by its name."""
        if which in self.known:
            return self.known[which]
        tables = ffi.new("cf_variables_t[]", 2 * lib.CF_PROVIDER_MAX_TABLES)
        count = getattr(lib, f"cf_{which}")(self.provider, tables, len(tables))
        rows = [(table.base, table.rows[i]) for table in tables[0:count] for i in range(table.count)]
        self.known[which] = {
            f"{ffi.string(row.group).decode()}.{ffi.string(row.name).decode()}": (
                row.type,
                row.flags,
                base + row.offset,
            )
            for base, row in rows
        }
        return self.known[which]

    def variable(self, which: str, name: str) -> Any:
        """Return a pointer to a variable."""
        type_, _, offset = self.variables(which)[name]
        return ffi.cast(C_TYPES[type_], ffi.cast("char *", self.cf) + offset)

    said_at_boot = 0

    def console(self) -> str:
        """Return what was printed since the drone booted."""
        text = ffi.new("char[]", 4096)
        length = lib.cf_console_read(ffi.addressof(self.cf.onboard.console), 0, text, len(text), ffi.new("uint32_t *"))
        return ffi.buffer(text, length)[:].decode()[self.said_at_boot :]


def as_floats(value: Any) -> np.ndarray:
    """Return a C value that has only floats, and integers that are zero, as an array."""
    return np.frombuffer(ffi.buffer(value), dtype=np.float32).copy()


def same(one: Any, other: Any) -> bool:
    """Return whether two such values are equal bit by bit, but for the sign of zero and the bits of NaN."""
    return np.array_equal(as_floats(one), as_floats(other), equal_nan=True)
