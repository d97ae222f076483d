"""The C compiler of this machine."""

from __future__ import annotations

import functools
import os
import shlex
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass

from crazychoir_fw.common.errors import BuildError

# texts of compilers are shown to people in their own words, but read by us as well
ENVIRONMENT = {"LC_ALL": "C.UTF-8", "LANGUAGE": "C"}


@dataclass(frozen=True)
class Compiler:
    """A C compiler that can be run."""

    command: tuple[str, ...]
    """Program and the arguments that belong to it, e.g. of ``CC="ccache gcc"``."""
    version: str
    """First line of what it says about itself."""


def find_compiler() -> Compiler:
    """Return the compiler of the environment variable CC, else cc, gcc or clang.

    Raises:
        BuildError: If there is none, or CC names something that cannot be run.
    """
    chosen = os.environ.get("CC", "").strip()
    for candidate in [chosen] if chosen else ["cc", "gcc", "clang"]:
        words = shlex.split(candidate)
        if program := shutil.which(words[0]):
            return Compiler((program, *words[1:]), _version((program, *words[1:])))
    if chosen:
        raise BuildError(f"the C compiler that CC names, {chosen!r}, is not there: correct or unset CC")
    raise BuildError("no C compiler found: run `apt install build-essential` (Debian, Ubuntu), or name one with CC")


def run(command: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """Run a compiler or a linker, and return how it ended and what it printed."""
    return subprocess.run(
        command, capture_output=True, text=True, errors="replace", check=False, env={**os.environ, **ENVIRONMENT}
    )


@functools.cache
def _version(command: tuple[str, ...]) -> str:
    try:
        told = subprocess.run([*command, "--version"], capture_output=True, text=True, check=False, timeout=60)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise BuildError(f"the C compiler {shlex.join(command)} cannot be run: {error}") from None
    lines = told.stdout.splitlines()
    if told.returncode != 0 or not lines:
        raise BuildError(f"the C compiler {shlex.join(command)} does not tell its version")
    return lines[0]
