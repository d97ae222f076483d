"""Folders of the repository that the installed package reads: `bindings`, `examples` and `mujoco_models`.

In a checkout they stand beside the package; `setup.py` copies their files into a wheel, below `SHARED`.
No symbolic links do this, because checkouts on Windows and unpacked archives have none.
"""

from pathlib import Path

SHARED = "_shared"
"""Folder inside an installed package, which holds the folders of the repository."""

_PACKAGE = Path(__file__).resolve().parents[1]


def shared_folder(name: str) -> Path:
    """Return a folder of the repository by its name, in a source checkout as well as in an installed package."""
    installed = _PACKAGE / SHARED
    return (installed if installed.is_dir() else _PACKAGE.parent) / name
