"""All names of the module, over one provider."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np

from crazychoir_fw.cffirmware.additions import additions
from crazychoir_fw.cffirmware.constants import constants
from crazychoir_fw.cffirmware.function_table import FUNCTIONS
from crazychoir_fw.cffirmware.functions import FunctionMaker
from crazychoir_fw.cffirmware.high_level_commander import high_level_names
from crazychoir_fw.cffirmware.signatures import with_old_forms
from crazychoir_fw.cffirmware.structs import StructClasses


def firmware_names(ffi: Any, lib: Any, classes: StructClasses, c_globals: Any = None) -> dict[str, Any]:
    """Return classes, functions and constants by name.

    Args:
        ffi: Of a provider.
        lib: Its functions.
        classes: Its structs.
        c_globals: Pointer to what the provider keeps in place of file-scope variables; None if it has some.
    """
    maker = FunctionMaker(ffi, lib, classes, c_globals)
    names: dict[str, Any] = {"np": np, **constants(lib), **classes.by_name}
    # without a name in some releases, which SWIG calls after struct and member
    mode = classes.of(dict(ffi.typeof("setpoint_t").fields)["mode"].type)
    names |= {"setpoint_mode_t": mode, "setpoint_t_mode": mode}
    for function in FUNCTIONS:
        if (made := maker.make(function)) is not None:
            names[function.name] = made
    names |= additions(ffi, names, maker.find)
    names |= with_old_forms(names, lib)
    names |= high_level_names(names)
    return names


def as_module(
    names: dict[str, Any], title: str, provider: str, platform: str, again: Callable[[], ModuleType]
) -> ModuleType:
    """Return names as a module.

    Args:
        names: See `firmware_names`.
        title: Name of the module.
        provider: "builtin" or "bitcraze".
        platform: For example "cf2".
        again: Makes another module of the same kind with file-scope variables of its own.
    """

    def instance() -> ModuleType:
        """Return another module of the same kind whose controllers remember things of their own."""
        return again()

    module = ModuleType(title, f"The firmware's functions in Python: provider {provider}, platform {platform}.")
    module.__dict__.update(names)
    module.__dict__.update(provider=provider, platform=platform, instance=instance)
    module.__dict__["__all__"] = [name for name in module.__dict__ if not name.startswith("_")]
    return module
