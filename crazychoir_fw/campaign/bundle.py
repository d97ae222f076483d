"""The files of a campaign as bytes, for machines that do not have them: sources with their digest, no pickled code."""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath

from crazychoir_fw.campaign.campaign import Job
from crazychoir_fw.common.errors import StateError

SUFFIXES = {".yaml", ".yml", ".csv", ".py", ".c", ".h", ".xml", ".obj", ".stl", ".png", ".json", ".npz"}
MAX_BYTES = 64_000_000
_HIDDEN = ("__pycache__", "out", "build", "node_modules")


@dataclass(frozen=True)
class Bundle:
    """Files below a folder."""

    root: str
    """The folder, where they come from."""
    files: dict[str, bytes]
    """Content by relative name, with slashes."""
    digest: str

    def unpack(self) -> Path:
        """Write the files into a private folder of this machine, once per content; returns it.

        Raises:
            StateError: If the content is not that of the digest.
        """
        if _digest(self.files) != self.digest:
            raise StateError("the files of the campaign arrived damaged")
        folder = private_folder("campaigns") / self.digest
        if folder.is_dir():
            return folder
        temporary = Path(tempfile.mkdtemp(dir=folder.parent))
        for name, content in self.files.items():
            relative = PurePosixPath(name)
            if relative.is_absolute() or ".." in relative.parts:
                raise StateError(f"the files of the campaign hold '{name}', which lies outside of their folder")
            path = temporary / relative
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        try:
            temporary.rename(folder)
        except OSError:  # another worker was first
            shutil.rmtree(temporary, ignore_errors=True)
        return folder

    def moved(self, job: Job, folder: Path) -> Job:
        """Return a flight with its files in another folder."""

        def there(path: str) -> str:
            return str(folder / Path(path).resolve().relative_to(self.root))

        app = None if job.app is None else tuple(there(file) for file in job.app)
        return replace(job, mission=there(job.mission), app=app)


def pack(jobs_files: Iterable[Path]) -> Bundle:
    """Return the folder that all of some files have in common, with what missions name.

    Raises:
        StateError: If that is more than `MAX_BYTES`.
    """
    paths = [path.resolve() for path in jobs_files]
    root = Path(os.path.commonpath([path.parent for path in paths]))
    files, size = {}, 0
    for folder, names, entries in os.walk(root):
        names[:] = sorted(name for name in names if name not in _HIDDEN and not name.startswith("."))
        for entry in sorted(entries):
            path = Path(folder) / entry
            if path.suffix not in SUFFIXES or not path.is_file():
                continue
            size += path.stat().st_size
            if size > MAX_BYTES:
                raise StateError(
                    f"{root} has more than {MAX_BYTES // 1_000_000} MB of missions and what they name; "
                    "put the mission of the campaign into a folder of its own"
                )
            files[path.relative_to(root).as_posix()] = path.read_bytes()
    return Bundle(str(root), files, _digest(files))


def _digest(files: dict[str, bytes]) -> str:
    digest = hashlib.sha256()
    for name, content in sorted(files.items()):
        digest.update(f"{len(name)} {name} {len(content)} ".encode())
        digest.update(content)
    return digest.hexdigest()


def private_folder(name: str) -> Path:
    """Return a folder for copies of files, which only this user may enter.

    Raises:
        StateError: If it belongs to another user.
    """
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "crazychoir_fw" / name
    base.mkdir(parents=True, exist_ok=True, mode=0o700)
    if base.stat().st_uid != os.getuid():
        raise StateError(f"{base} belongs to another user")
    base.chmod(0o700)
    return base
