"""Our own C that becomes part of a provider library: where it is, and which files."""

from __future__ import annotations

from pathlib import Path

from crazychoir_fw.common.errors import BuildError
from crazychoir_fw.common.shared_folders import shared_folder


def bindings_folder() -> Path:
    """Return the folder of the C sources, in a source checkout as well as in an installed package.

    Raises:
        BuildError: If the installation came without it.
    """
    folder = shared_folder("bindings")
    if not (folder / "provider.h").is_file():
        raise BuildError(
            f"the C sources of crazychoir_fw are not in {folder}: run `pip install --force-reinstall --no-deps "
            "crazychoir-fw`"
        )
    return folder


def read_list(path: Path) -> list[str]:
    """Return the lines of a list of files, without comments; a missing list is empty."""
    if not path.is_file():
        return []
    lines = (line.partition("#")[0].strip() for line in path.read_text(encoding="utf-8").splitlines())
    return [line for line in lines if line]


def deciding_flags() -> list[str]:
    """Return the flags that decide the bits of our own build; both providers are compiled with them."""
    return (bindings_folder() / "cflags.txt").read_text(encoding="utf-8").split()
