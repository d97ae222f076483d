"""Where the commands write: results to stdout, complaints to stderr."""

import json
from typing import Any, NoReturn

import typer
from rich.console import Console
from rich.text import Text

from crazychoir_fw.common.errors import BuildError, CrazychoirError

console = Console()
complaints = Console(stderr=True)

FLIGHT_FAILED = 1
BAD_INPUT = 2


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
    complaints.print(Text(sentence, style="red"), soft_wrap=True)


def echo_json(value: Any) -> None:
    """Print JSON for programs."""
    # not through rich, which would wrap and color it
    typer.echo(json.dumps(value, indent=2))
