"""`--view` of `crazychoir fly` and `run`: which way a flight can be watched here."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable
from contextlib import AbstractContextManager
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

from crazychoir_fw.cli.console import refuse
from crazychoir_fw.common.errors import CrazychoirError

if TYPE_CHECKING:
    from crazychoir_fw.flight.engine import Observer

WAYS = ("auto", "native", "web")
View = Annotated[
    str | None,
    typer.Option(
        help="Watch the flight in real time; alone, it opens a window, or a page where there is no display.",
        metavar="[native|web]",
    ),
]


class ViewCommand(TyperCommand):
    """A command with an option whose value may be left out: `--view` alone means `--view auto`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put in the value that was left out."""
        complete = []
        for word, following in zip_longest(args, args[1:]):
            complete += [word, "auto"] if word == "--view" and not _is_way(following) else [word]
        return super().parse_args(ctx, complete)


def _is_way(word: str | None) -> bool:
    """Tell a way, or a slip in one, from the next option and from the file that a command is about."""
    return word is not None and word.isalnum() and not Path(word).exists()


def require_way(way: str | None) -> None:
    """End the command with one sentence if there is no such way; None shows nothing, and is one."""
    if way is not None and way not in WAYS:
        refuse(f"--view is '{way}', allowed: {', '.join(WAYS)}, or nothing")


def open_view(way: str, say: Callable[[str], None]) -> AbstractContextManager[Observer]:
    """Return a context manager that yields an observer which shows the flight.

    Args:
        way: ``native`` (MuJoCo's window), ``web`` (a page), or ``auto``: the window if there is a display.
        say: Called with one line about what was opened.

    Raises:
        CrazychoirError: If that way is not open here; the text says what is missing.
    """
    if way == "native" and (reason := no_window_because()):
        raise CrazychoirError(f"--view native: {reason}; --view web shows the flight in a browser")
    if way == "native" or (way == "auto" and not no_window_because()):
        from crazychoir_fw.cli.view_native import open_window

        return open_window(say)
    from crazychoir_fw.cli.view_web import open_page

    return open_page(say)


def no_window_because() -> str | None:
    """Return why no window can be opened here, None if one can."""
    if sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return "there is no display"
    if sys.platform == "darwin" and "mjpython" not in os.environ.get("_", ""):
        return "macOS opens MuJoCo's window under mjpython only"
    try:
        import glfw
    except ImportError as error:
        return f"windows need the package glfw ({error})"
    with warnings.catch_warnings(record=True) as complaints:
        warnings.simplefilter("always")
        if glfw.init():
            return None
    said = str(complaints[-1].message) if complaints else "GLFW cannot start"
    return f"no window can be opened ({said})"
