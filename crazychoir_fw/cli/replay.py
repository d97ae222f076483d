"""`crazychoir replay`: fly a recorded flight again from its journal, and compare it bit by bit."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

from crazychoir_fw.cli.console import (
    BAD_INPUT,
    FLIGHT_FAILED,
    about_file,
    complain,
    complain_of,
    complaints,
    console,
    refuse,
)
from crazychoir_fw.common.signals import unwind_at_signals

if TYPE_CHECKING:
    from crazychoir_fw.recording.flight_log import FlightLog

REPLAYED = "replay.npz"


@unwind_at_signals()
def replay(
    log: Annotated[Path, typer.Argument(help="Log of a flight (NPZ), or the folder with its log.npz.", metavar="LOG")],
    check: Annotated[
        bool, typer.Option("--check", help="Only compare: exit code 0 when every bit is the same, 1 when not.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option(help="File for the new log; otherwise, without --check, replay.npz beside LOG.")
    ] = None,
    trust: Annotated[
        bool, typer.Option("--trust", help="Compile and run the C files that LOG names, without asking.")
    ] = False,
    threads: Annotated[int | None, typer.Option(min=1, max=64, help="Worker threads.")] = None,
) -> None:
    """Fly a recorded flight again and compare every signal with the record."""
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.simulation.replay import load_flight
    from crazychoir_fw.simulation.replay import replay as fly_again

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn())
    try:
        recorded = load_flight(log)
        _ask(recorded, trust)
        with Progress(*columns, console=complaints, transient=True, disable=not complaints.is_terminal) as bar:
            task = bar.add_task(f"{len(recorded.drone_ids)} drones, {len(recorded.time)} samples", total=None)
            flown = fly_again(
                recorded, threads, lambda now, end: bar.update(task, completed=now, total=end), _warn, trust=True
            )
        if out is None and not check:
            out = (log if log.is_dir() else log.parent) / REPLAYED
        if out is not None:
            flown.log.save(out)
            console.print(f"Written to {out}", markup=False, highlight=False)
    except CrazychoirError as error:
        complain_of(error)
        raise typer.Exit(BAD_INPUT) from None
    except OSError as error:
        complain(about_file(error, out))
        raise typer.Exit(BAD_INPUT) from None

    if flown.deviation is None:
        requests = recorded.journal.samples[-1] if recorded.journal and recorded.journal.samples else 0
        size = f"{len(recorded.signals)} signals of {len(recorded.drone_ids)} drones at {len(recorded.time)} instants"
        console.print(f"Same to the last bit: {size}, {requests} requests", markup=False, highlight=False)
        return
    complain(f"The replay differs: {flown.deviation}")
    if check:
        raise typer.Exit(FLIGHT_FAILED)


def _ask(recorded: "FlightLog", trust: bool) -> None:
    """Ask on a terminal whether to run what a log names; without one, refuse it."""
    from crazychoir_fw.simulation.recipe import programs_of
    from crazychoir_fw.simulation.replay import untrusted

    programs = programs_of(recorded.journal.recipe) if recorded.journal is not None and not trust else []
    if not programs:
        return
    sentence = untrusted(programs)
    if not _is_terminal():
        refuse(f"{sentence}: read what they do, then add --trust")
    if not typer.confirm(f"{sentence}. Run them?", err=True):
        raise typer.Exit(BAD_INPUT)


def _is_terminal() -> bool:
    return sys.stdin.isatty()


def _warn(sentence: str) -> None:
    complaints.print(f"Note: {sentence}", style="yellow", markup=False, highlight=False, soft_wrap=True)
