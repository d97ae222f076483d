"""A provider library on disk: the shared object and, beside it, its manifest."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from crazychoir_fw.common.errors import BuildError
from crazychoir_fw.firmware.cache import sha256_of, write_text

MANIFEST = "library.json"
BUILD_LOG = "build.log"
_FORM = 2  # of the manifest


@dataclass(frozen=True)
class Library:
    """A compiled provider, ready to be loaded by the core."""

    path: Path
    """The shared object."""
    name: str
    """Name of the provider: ``bitcraze``, or ``builtin+my_controller`` with an app."""
    platform: str | None
    """Platform that it was built for, e.g. ``cf2``; None is every one."""
    ranges: list[tuple[int, int]] = field(repr=False)
    """Pieces of the library that belong to a drone: (offset, bytes), ascending."""
    pointers: list[int] = field(repr=False)
    """Offsets of words in the ranges that hold a pointer."""
    identity: dict[str, Any] = field(repr=False)
    """What it was made of: provider, version, content, platform, features, compiler, flags, and more; plain data."""

    def save(self) -> None:
        """Write the manifest beside the shared object."""
        manifest = {
            "form": _FORM,
            "file": self.path.name,
            "sha256": sha256_of(self.path),
            "name": self.name,
            "platform": self.platform,
            "ranges": [list(piece) for piece in self.ranges],
            "pointers": self.pointers,
            "identity": self.identity,
        }
        write_text(self.path.parent / MANIFEST, json.dumps(manifest))

    @classmethod
    def load(cls, folder: Path) -> Library:
        """Return the library in a folder.

        Raises:
            BuildError: If there is none that this version understands.
        """
        try:
            manifest = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
            if manifest["form"] != _FORM or not (folder / manifest["file"]).is_file():
                raise ValueError("another form")
            if manifest["sha256"] != sha256_of(folder / manifest["file"]):
                raise ValueError(f"{manifest['file']} is not the file that was built")
            return cls(
                path=folder / manifest["file"],
                name=manifest["name"],
                platform=manifest["platform"],
                ranges=[(int(offset), int(size)) for offset, size in manifest["ranges"]],
                pointers=[int(offset) for offset in manifest["pointers"]],
                identity=dict(manifest["identity"]),
            )
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise BuildError(f"{folder} holds no provider library ({error}): build it again with --force") from None


def kept_libraries(cache: Path) -> list[Library]:
    """Return the libraries of a cache folder, the one used last first."""
    found = []
    for manifest in (cache / "libraries").glob(f"[!.]*/{MANIFEST}"):
        try:
            found.append((manifest.parent.stat().st_mtime, Library.load(manifest.parent)))
        except (BuildError, OSError):
            continue
    return [library for _, library in sorted(found, key=lambda one: -one[0])]
