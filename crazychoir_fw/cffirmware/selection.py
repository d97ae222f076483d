"""Which provider the module is made over."""

from __future__ import annotations

import functools
import os
from pathlib import Path
from types import ModuleType

from crazychoir_fw.cffirmware.assembly import as_module, firmware_names
from crazychoir_fw.cffirmware.structs import StructClasses
from crazychoir_fw.common.errors import UnknownNameError

PROVIDER_VARIABLE = "CRAZYCHOIR_PROVIDER"
"""Environment variable that chooses the provider of `import crazychoir_fw.cffirmware`."""

PLATFORM_VARIABLE = "CRAZYCHOIR_PLATFORM"
"""Environment variable that chooses its platform."""

_PACKAGE = "crazychoir_fw.cffirmware"


def over(provider: str = "builtin", platform: str = "cf2", checkout: Path | str | None = None) -> ModuleType:
    """Return the module over a provider: the same names, other algorithms behind them.

    The same arguments give the same module, so that what is at file scope in C is there once. Its function
    ``instance()`` returns one more with variables of its own.

    Args:
        provider: "builtin", our own implementation, or "bitcraze", the sources of a firmware checkout, compiled when
            they are asked for the first time.
        platform: "cf2" or "cf21bl", and "bolt" over bitcraze: gains, mass and thrust.
        checkout: Folder of the checkout; by default the one that CRAZYFLIE_FIRMWARE names, else the submodule
            ``firmware/``.

    Raises:
        UnknownNameError: If there is no such provider or platform.
        CheckoutError: If there is no usable checkout.
        BuildError: If it does not compile.
    """
    if provider == "builtin":
        return _builtin(platform)
    if provider == "bitcraze":
        return _bitcraze(platform, None if checkout is None else str(Path(checkout).expanduser().absolute()))
    raise UnknownNameError(f"no provider named {provider!r}, allowed: builtin, bitcraze")


def chosen() -> ModuleType:
    """Return the module that the environment asks for; builtin for a cf2 if it does not say."""
    return over(os.environ.get(PROVIDER_VARIABLE) or "builtin", os.environ.get(PLATFORM_VARIABLE) or "cf2")


@functools.cache
def _builtin(platform: str) -> ModuleType:
    return _make_builtin(platform)


def _make_builtin(platform: str) -> ModuleType:
    from crazychoir_fw._core import ffi, lib

    names = [ffi.string(lib.cf_platform_facts(i).name).decode() for i in range(lib.CF_PLATFORM_COUNT)]
    if platform not in names:
        raise UnknownNameError(f"provider builtin has no platform named {platform!r}, allowed: {', '.join(names)}")
    c_globals = ffi.new("cf_upstream_globals_t *")
    lib.cf_upstream_boot(c_globals, names.index(platform))
    firm = firmware_names(ffi, lib, _builtin_classes(), c_globals)
    return as_module(firm, f"{_PACKAGE}.builtin", "builtin", platform, lambda: _make_builtin(platform))


@functools.cache
def _builtin_classes() -> StructClasses:
    from crazychoir_fw._core import ffi, lib

    return StructClasses(ffi, lib)


@functools.cache
def _bitcraze(platform: str, checkout: str | None) -> ModuleType:
    from crazychoir_fw.cffirmware.build import build_module

    return _make_bitcraze(build_module(checkout, platform), platform)


def _make_bitcraze(path: Path, platform: str) -> ModuleType:
    from crazychoir_fw.cffirmware.loading import load

    ffi, lib = load(path)
    firm = firmware_names(ffi, lib, StructClasses(ffi, lib))
    return as_module(firm, f"{_PACKAGE}.bitcraze", "bitcraze", platform, lambda: _make_bitcraze(path, platform))
