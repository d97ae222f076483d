"""What Kconfig would write for a platform: the values of a checkout's own Kconfig files.

The files are read by kconfiglib. Nothing of the checkout is run: macros that call the shell give nothing, and no
functions are imported.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import kconfiglib

TOP = "Kconfig"
PREFIX = "CONFIG_"

# kconfiglib takes its settings from the environment and from its own module
_lock = threading.Lock()


def read_kconfig(root: Path, defconfig: Path) -> tuple[dict[str, str], set[str]] | None:
    """Return what Kconfig gives, as the generated header would have it, and the names of all symbols that it knows.

    Args:
        root: The checkout; its Kconfig names files relative to it.
        defconfig: Choices of a platform; may be missing.

    Returns:
        Values as C text by symbol, e.g. ``{"CONFIG_PLATFORM_CF2": "1"}``, without those that are off; and all symbols.
        None without a Kconfig, or if it cannot be read.
    """
    if not (root / TOP).is_file():
        return None
    with _lock, _nothing_is_run(root):
        try:
            tree = kconfiglib.Kconfig(str(root / TOP), warn=False)
            if defconfig.is_file():
                tree.load_config(str(defconfig))
            symbols = {f"{PREFIX}{symbol.name}": symbol for symbol in tree.unique_defined_syms}
            values = {name: _c_value(symbol) for name, symbol in symbols.items()}
        except (kconfiglib.KconfigError, OSError, ValueError, RecursionError):
            return None
    return {name: value for name, value in values.items() if value is not None}, set(symbols)


def _c_value(symbol: kconfiglib.Symbol) -> str | None:
    """Return a symbol's value as C text, or None if it is off or has none."""
    value = symbol.str_value
    if symbol.orig_type in (kconfiglib.BOOL, kconfiglib.TRISTATE):
        return "1" if value == "y" else None
    if symbol.orig_type == kconfiglib.STRING:
        return f'"{kconfiglib.escape(value)}"' if symbol.config_string else None
    return value or None


@contextmanager
def _nothing_is_run(root: Path) -> Iterator[None]:
    """Let kconfiglib read files below a folder, and neither run a shell nor import functions."""
    environment = {"srctree": str(root), "KCONFIG_FUNCTIONS": "no.functions", "CONFIG_": PREFIX}
    before = {name: os.environ.get(name) for name in environment}
    shell = kconfiglib._shell_fn
    os.environ.update(environment)
    kconfiglib._shell_fn = lambda *_: ""
    try:
        yield
    finally:
        kconfiglib._shell_fn = shell
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
