"""Provider libraries for tests: `toy_library.c`, compiled in one variant or another."""

from __future__ import annotations

import functools
import os
import subprocess
import sysconfig
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.onboard.core import load_library

TESTS = Path(__file__).resolve().parent
COMPILER = (sysconfig.get_config_var("CC") or "cc").split()[0]


@dataclass(frozen=True)
class Toy:
    """What `load_library` wants to know; see `crazychoir_fw.onboard.core.ProviderLibrary`."""

    path: Path
    name: str = "toy"
    platform: str | None = None
    ranges: Sequence[tuple[int, int]] = ()
    pointers: Sequence[int] = ()
    identity: Mapping[str, Any] = field(default_factory=lambda: {"version": "toy-1", "compiler": "gcc"})


@functools.cache
def _folder() -> tempfile.TemporaryDirectory:
    return tempfile.TemporaryDirectory(prefix="toy-libraries-")


@functools.cache
def toy_path(*defines: str) -> Path:
    """Return a toy library compiled with these defines, such as ``TOY_GAIN=0.5f``; each variant is built once."""
    os.environ["TOY_BUILTIN"] = hex(int(ffi.cast("uintptr_t", lib.cf_provider(0))))
    target = Path(_folder().name) / ("toy" + "".join(f"-{define}" for define in defines) + ".so")
    options = ["-std=gnu11", "-O1", "-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off"]
    command = [COMPILER, *options, f"-I{TESTS.parent / 'bindings'}", *(f"-D{define}" for define in defines)]
    subprocess.run([*command, str(TESTS / "toy_library.c"), "-o", str(target)], check=True)
    return target


def load_toy(*defines: str, name: str = "toy", platform: str | None = None) -> int:
    """Load a toy library, which is then the newest of its name, and return its number."""
    return load_library(Toy(toy_path(*defines), name=name, platform=platform))
