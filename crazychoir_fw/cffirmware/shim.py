"""The plain name `cffirmware`: a file of a few lines in the folder of installed packages, written on request.

It does not come with the installation, because a name of Bitcraze's must not be taken unasked. A real build is found
first wherever PYTHONPATH, or the folder of a script, comes before installed packages.
"""

from __future__ import annotations

import importlib.machinery
import sys
import sysconfig
from dataclasses import dataclass
from pathlib import Path

from crazychoir_fw.common.errors import StateError
from crazychoir_fw.common.replacing import replacing

NAME = "cffirmware"
_MARK = "# Written by `crazychoir firmware install-shim`; `--remove` takes it away again."

TEXT = f'''{_MARK}
"""Stands in for the Python module of Bitcraze's firmware. May be copied into any package."""

from crazychoir_fw.cffirmware import *  # noqa: F403
from crazychoir_fw.cffirmware import __all__  # noqa: F401
'''


@dataclass(frozen=True)
class Shim:
    """Where the shim is, and what else has its name."""

    path: Path
    """The file."""
    real_build: Path | None
    """A real `cffirmware` that Python finds instead."""


def install(folder: Path | None = None) -> Shim:
    """Write the shim into a folder, by default that of installed packages.

    Raises:
        StateError: If a file that we did not write has its name.
    """
    path = _place(folder)
    _demand_ours(path)
    with replacing(path) as temporary:
        temporary.write_text(TEXT, encoding="utf-8")
    return Shim(path, _other(path))


def remove(folder: Path | None = None) -> Shim | None:
    """Delete the shim; returns None if there was none.

    Raises:
        StateError: If the file was not written by us.
    """
    path = _place(folder)
    if not path.exists():
        return None
    _demand_ours(path)
    path.unlink()
    return Shim(path, _other(path))


def _place(folder: Path | None) -> Path:
    return (folder or Path(sysconfig.get_path("purelib"))) / f"{NAME}.py"


def _demand_ours(path: Path) -> None:
    # an extension or a package beside the file would win, or be hidden
    suffixes = (*importlib.machinery.EXTENSION_SUFFIXES, "")
    others = [path.with_name(f"{NAME}{suffix}") for suffix in suffixes]
    others += [path] if path.exists() and not is_ours(path) else []
    if real := [other for other in others if other.exists()]:
        raise StateError(f"{real[0]} is a real {NAME}: run `pip uninstall {NAME}` first, or keep it")


def is_ours(path: Path) -> bool:
    """Return whether we wrote a file."""
    return path.is_file() and path.read_text(encoding="utf-8", errors="replace").startswith(_MARK)


def _other(path: Path) -> Path | None:
    """Return what Python imports under the name, if it is no shim."""
    importlib.machinery.PathFinder.invalidate_caches()
    found = importlib.machinery.PathFinder.find_spec(NAME, [entry for entry in sys.path if entry != str(path.parent)])
    if found is None or found.origin is None or is_ours(Path(found.origin)):
        return None
    return Path(found.origin)
