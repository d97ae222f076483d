"""Read files of others: regular ones of a limited size, or one sentence that names the file, on one line."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from crazychoir_fw.common.errors import CrazychoirError


def read_bytes(path: Path, largest: int, error: type[CrazychoirError]) -> bytes:
    """Return the content of a file; a pipe or a device is refused at once.

    Args:
        path: The file.
        largest: Size (bytes) from which on the file is refused.
        error: Raised if the file cannot be read.
    """
    try:
        # without waiting for a writer of a pipe
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | getattr(os, "O_NONBLOCK", 0))
    except OSError as reason:
        raise error(f"{show_name(path)} cannot be read: {reason.strerror}") from None
    except ValueError:  # a name with a null character
        raise error(f"{show_name(path)} is no file name") from None
    status = os.fstat(descriptor)
    if not stat.S_ISREG(status.st_mode):
        os.close(descriptor)
        raise error(f"{show_name(path)} cannot be read: it is {_kind(status.st_mode)}, but must be a regular file")
    with os.fdopen(descriptor, "rb") as file:
        content = file.read(largest + 1)
    if len(content) > largest:
        raise error(f"{show_name(path)} is larger than {largest} bytes, the allowed maximum")
    return content


def read_text(path: Path, largest: int, error: type[CrazychoirError]) -> str:
    """Return the text of a file in UTF-8, as `read_bytes` reads it."""
    try:
        return read_bytes(path, largest, error).decode("utf-8")
    except UnicodeDecodeError:
        raise error(f"{show_name(path)} is not a text file in UTF-8") from None


def _kind(mode: int) -> str:
    names = {
        stat.S_ISDIR: "a folder",
        stat.S_ISFIFO: "a pipe",
        stat.S_ISSOCK: "a socket",
        stat.S_ISCHR: "a device",
        stat.S_ISBLK: "a device",
    }
    return next((name for test, name in names.items() if test(mode)), "no regular file")


def show_name(path: str | Path) -> str:
    """Return a path as a sentence can hold it."""
    return printable(str(path), 300)


def printable(text: str, longest: int = 2000) -> str:
    """Return a text of others on one line: without control characters, cut at a length."""
    text = text if len(text) <= longest else f"{text[: longest - 1]}…"
    return "".join(c if c.isprintable() else " " if c.isspace() else ascii(c)[1:-1] for c in text)
