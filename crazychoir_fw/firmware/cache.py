"""What is kept between builds: objects, answers of probes, libraries, modules; found again by content, never by time.

The folder is that of the user's caches, or the one that CRAZYCHOIR_CACHE names. Everything lies in one folder of our
own in it, marked as a cache, and only a marked folder is ever cleaned.
"""

from __future__ import annotations

import functools
import hashlib
import json
import os
import secrets
import shutil
import stat
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import platformdirs

from crazychoir_fw.common.errors import BuildError
from crazychoir_fw.common.replacing import replacing

VARIABLE = "CRAZYCHOIR_CACHE"
"""Environment variable that names another folder for caches."""

FOLDER = "provider-libraries"
_MARK = "CACHEDIR.TAG"
_SIGNATURE = "Signature: 8a477f597d28d172789f06886806bc55\n# Built by crazychoir; may be deleted at any time.\n"

_KEPT_ENTRIES = 8  # of one record: so many versions of a file can be edited back and forth
_KEPT_LIBRARIES = 32
_KEPT_GENERATED = 256  # a library has one, a module a dozen
_KEPT_OBJECTS = 2000


def cache_root() -> Path:
    """Return the folder of everything that is kept, whether it exists or not."""
    named = os.environ.get(VARIABLE)
    caches = Path(named).expanduser().absolute() if named else Path(platformdirs.user_cache_dir("crazychoir_fw"))
    return caches / FOLDER


def digest(*parts: bytes | str) -> str:
    """Return a name for content: equal parts, equal name."""
    name = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        name.update(len(data).to_bytes(8, "little"))
        name.update(data)
    return name.hexdigest()[:40]


def sha256_of(path: Path) -> str:
    """Return the digest of a file that is checked before it is loaded."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def digest_of(value: Any) -> str:
    """Return a name for plain data."""
    return digest(json.dumps(value, sort_keys=True, default=str))


@functools.cache
def digest_of_code(*folders: Path) -> str:
    """Return a name for the Python code in folders: another way to build gives another result."""
    return digest_of(Fingerprints().all_of(str(path) for folder in folders for path in folder.glob("*.py")))


class Fingerprints:
    """Digests of files as they are during one build; each file is read once."""

    def __init__(self) -> None:
        self._began = time.time_ns()
        self._known: dict[str, str | None] = {}

    def of(self, path: str) -> str | None:
        """Return the digest of a file's content; None if it cannot be read."""
        if path not in self._known:
            try:
                self._known[path] = digest(Path(path).read_bytes())
            except OSError:
                self._known[path] = None
        return self._known[path]

    def all_of(self, paths: Iterable[str]) -> dict[str, str | None]:
        """Return the digests of files by path."""
        return {path: self.of(path) for path in sorted(set(paths))}

    def match(self, inputs: Mapping[str, str | None]) -> bool:
        """Return whether all these files have these digests now."""
        return all(self.of(path) == content for path, content in inputs.items())

    def changed_meanwhile(self, paths: Iterable[str]) -> bool:
        """Return whether a file was written during the build: which of its versions was compiled is unknown."""
        now = time.time_ns()
        try:
            return any(self._began < Path(path).stat().st_mtime_ns <= now for path in paths)
        except OSError:
            return True


class Cache:
    """One folder of kept things.

    Several processes may work in it at once: files appear whole or not at all, and a name stands for its content.
    """

    def __init__(self, root: Path | None = None) -> None:
        self.root = root if root is not None else cache_root()
        self.objects = self.root / "objects"
        self.libraries = self.root / "libraries"
        self.modules = self.root / "modules"
        self._generated = self.root / "generated"
        self._records = self.root / "records"
        try:
            self.root.parent.mkdir(parents=True, exist_ok=True)
            for folder in (self.root, self.objects, self.libraries, self.modules, self._generated, self._records):
                folder.mkdir(mode=0o700, exist_ok=True)
                make_private(folder)
            if not (self.root / _MARK).is_file():
                write_text(self.root / _MARK, _SIGNATURE)
        except OSError as error:
            raise BuildError(
                f"the cache {self.root} cannot be written ({error.strerror}): name another folder with {VARIABLE}"
            ) from None

    def recall(
        self, key: str, fingerprints: Fingerprints, path_of: Callable[[str], str] = str
    ) -> dict[str, Any] | None:
        """Return what was remembered under a key for the files as they are now, or None.

        Args:
            key: The key.
            fingerprints: Of the files as they are now.
            path_of: Gives the path of a file by the name under which it was remembered.
        """
        for entry in self._entries(key):
            if fingerprints.match({path_of(name): content for name, content in entry["inputs"].items()}):
                return entry["value"]
        return None

    def remember(self, key: str, inputs: Mapping[str, str | None], value: Mapping[str, Any]) -> None:
        """Keep a value under a key, for files of this content; a few older ones stay."""
        older = [entry for entry in self._entries(key) if entry["inputs"] != inputs]
        entries = [{"inputs": dict(inputs), "value": dict(value)}, *older][:_KEPT_ENTRIES]
        write_text(self._record(key), json.dumps(entries))

    def _record(self, key: str) -> Path:
        return self._records / f"{key}.json"

    def _entries(self, key: str) -> list[dict[str, Any]]:
        try:
            entries = json.loads(self._record(key).read_bytes())
            return [one for one in entries if isinstance(one["inputs"], dict) and isinstance(one["value"], dict)]
        except (OSError, ValueError, TypeError, KeyError):
            return []

    def write_generated(self, texts: Mapping[str, str]) -> Path:
        """Write files by name, unless they are there already, and return their folder, which is named by content."""
        folder = self._generated / digest_of(dict(texts))
        for name, text in texts.items():
            if not (folder / name).is_file():
                write_text(folder / name, text)
        used(folder)
        return folder

    @contextmanager
    def alone(self, key: str) -> Iterator[None]:
        """Hold the lock of a key: a second process waits, and then finds what the first one built."""
        with (self._records / f"{key}.lock").open("w") as lock:
            # where the file system has no locks, the same thing is built twice and the second one wins
            with suppress(ImportError, OSError):
                import fcntl

                fcntl.flock(lock, fcntl.LOCK_EX)
            yield

    @contextmanager
    def workspace(self, beside: Path) -> Iterator[Path]:
        """Give a folder within `beside`, which is gone afterwards unless it was renamed."""
        folder = beside / f".{secrets.token_hex(6)}"
        folder.mkdir()
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def prune(self) -> None:
        """Forget what has not been used for longest."""
        _keep_newest(self.libraries, _KEPT_LIBRARIES)
        _keep_newest(self.modules, _KEPT_LIBRARIES)
        _keep_newest(self._generated, _KEPT_GENERATED)
        _keep_newest(self.objects, _KEPT_OBJECTS)
        _keep_newest(self._records, 2 * _KEPT_OBJECTS)


def make_private(folder: Path) -> None:
    """Make a folder with executable content private to this user.

    Raises:
        BuildError: If it belongs to another user, others could have written into it, or it is a link of another user.
    """
    status = folder.lstat()
    if stat.S_ISLNK(status.st_mode) and status.st_uid == os.geteuid():
        status = folder.stat()  # to another disk, for instance
    if not stat.S_ISDIR(status.st_mode):
        trouble = "is no folder"
    elif status.st_uid != os.geteuid():
        trouble = f"belongs to user {status.st_uid}"
    elif status.st_mode & 0o022:
        trouble = f"may be written by others (mode {stat.S_IMODE(status.st_mode):o})"
    else:
        if status.st_mode & 0o077:
            folder.chmod(0o700)
        return
    raise BuildError(
        f"the cache {folder} {trouble}, and what is in it would be executed: delete it, or name another with {VARIABLE}"
    )


def used(path: Path) -> None:
    """Mark something kept as used now."""
    with suppress(OSError):
        os.utime(path)


def write_text(path: Path, text: str) -> None:
    """Write a file so that readers see the old one or the new one."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def clean() -> int:
    """Delete everything that is kept. Returns the bytes that it took."""
    root = cache_root()
    if not root.exists():
        return 0
    if not (root / _MARK).is_file():
        raise BuildError(f"{root} is not a cache of crazychoir: nothing was deleted")
    size = sum(path.lstat().st_size for path in root.rglob("*") if not path.is_dir())
    shutil.rmtree(root)
    return size


def _keep_newest(folder: Path, count: int) -> None:
    ages = []
    for path in folder.iterdir():
        with suppress(OSError):
            ages.append((path.stat().st_mtime, path))
    # a process that found it within the hour may be about to load it
    deadline = time.time() - 3600.0
    for modified, path in sorted(ages, reverse=True)[count:]:
        if modified > deadline:
            continue
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            with suppress(OSError):
                path.unlink()
