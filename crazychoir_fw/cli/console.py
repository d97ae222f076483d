"""Where the commands write: results to stdout, complaints to stderr."""

import errno
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import typer
from rich.console import Console
from rich.text import Text

from crazychoir_fw.common.errors import BuildError, CrazychoirError
from crazychoir_fw.common.reading import printable

if TYPE_CHECKING:
    from crazychoir_fw.mission.schema import Mission

console = Console()
complaints = Console(stderr=True)

FLIGHT_FAILED = 1
BAD_INPUT = 2

_WRITING = (errno.ENOSPC, errno.EROFS, errno.EDQUOT, errno.EFBIG)


def refuse(sentence: str) -> NoReturn:
    """Print one red sentence and leave: the input is wrong, and a traceback would not help."""
    complain(sentence)
    raise typer.Exit(BAD_INPUT)


def complain_of(error: CrazychoirError) -> None:
    """Print an error: a sentence in red, but what a compiler printed as the compiler printed it."""
    if isinstance(error, BuildError):
        # not through rich, which would wrap lines and expand tabs under a caret
        typer.echo(str(error), err=True)
    else:
        complain(str(error))


def complain(sentence: str) -> None:
    """Print one red sentence."""
    # as Text, so that brackets in a key path are not read as markup
    complaints.print(Text(printable(sentence), style="red"), soft_wrap=True)


def note(sentence: str) -> None:
    """Print one yellow sentence on stderr: what goes on, and may not be meant."""
    complaints.print(Text(f"Note: {printable(sentence)}", style="yellow"), soft_wrap=True)


def ask_about(mission: "Mission") -> None:
    """Print what of a mission may not be meant."""
    from crazychoir_fw.mission.doubts import doubts

    for doubt in doubts(mission):
        note(doubt)


def about_file(error: OSError, out: Path | None) -> str:
    """Return a sentence about a file that the system refused.

    Args:
        error: What the system says; without a file's name it is about `out`.
        out: File or folder that the command writes. Other files may have been read.
    """
    name = out if error.filename is None else os.fsdecode(error.filename)
    ours = out is None or name is out or _around(Path(str(name)).absolute(), out.absolute())
    verb = "written" if ours or error.errno in _WRITING else "read or written"
    return f"{name or 'a file'} cannot be {verb}: {error.strerror or error}"


def _around(path: Path, out: Path) -> bool:
    """Tell whether a file is in a folder, or the other way round."""
    return path.is_relative_to(out) or out.is_relative_to(path)


def echo_json(value: Any) -> None:
    """Print JSON for programs."""
    # not through rich, which would wrap and color it
    typer.echo(json.dumps(value, indent=2))
