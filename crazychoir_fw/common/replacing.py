"""Write files so that readers only ever see them whole."""

import os
import re
import secrets
import shutil
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

_TEMPORARY = re.compile(r"\..+\.([0-9a-f]{8})-([0-9]+)-[0-9a-f]{6}(\.[^.]*)?")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a temporary name beside *path*, which takes the place of *path* when the block ends well.

    The temporary name keeps the suffix of *path*, because some writers choose their format by it.
    If the block raises, the temporary file is removed and *path* stays as it was. What killed processes of this
    machine left beside *path* is removed as well. Missing folders are created.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    remove_stale(path.parent)
    temporary = path.with_name(_temporary(path.stem, path.suffix))
    try:
        yield temporary
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def replacing_together(folder: Path, marks: Sequence[str]) -> Iterator[Path]:
    """Give a temporary folder in *folder*; when the block ends well, its files take the place of those in *folder*.

    If the block raises, *folder* stays as it was. Files that say what the others are, as a summary does, are removed
    first and put in place last, so that a power cut never leaves one of them beside files that it does not speak of.

    Args:
        folder: Which exists.
        marks: Names of these files.
    """
    remove_stale(folder)
    temporary = folder / _temporary("new", "")
    temporary.mkdir()
    try:
        yield temporary
        for name in marks:
            (folder / name).unlink(missing_ok=True)
        for file in sorted(temporary.iterdir(), key=lambda file: file.name in marks):
            file.replace(folder / file.name)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def remove_stale(folder: Path) -> None:
    """Remove temporary files that processes of this machine left when they were killed."""
    for path in folder.glob(".*"):
        found = _TEMPORARY.fullmatch(path.name)
        if found is None or found[1] != _machine() or _lives(int(found[2])):
            continue
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)


def _temporary(stem: str, suffix: str) -> str:
    return f".{stem}.{_machine()}-{os.getpid()}-{secrets.token_hex(3)}{suffix}"


def _machine() -> str:
    return f"{zlib.crc32(os.uname().nodename.encode()):08x}"


def _lives(process: int) -> bool:
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        pass  # another user's
    return True
