"""One flight of `crazychoir fly`: read the mission, fly it, show how it went, write it down."""

import shlex
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from crazychoir_fw.cli.console import BAD_INPUT, FLIGHT_FAILED, about_file, ask_about, complain, complain_of, console
from crazychoir_fw.cli.records import write_together, writing
from crazychoir_fw.cli.tables import flight_tables, verdict

if TYPE_CHECKING:
    from crazychoir_fw.cli.film import FilmRequest
    from crazychoir_fw.flight.engine import Observer
    from crazychoir_fw.flight.engine import Progress as FlightProgress
    from crazychoir_fw.flight.flight_result import FlightResult
    from crazychoir_fw.mission.schema import Mission
    from crazychoir_fw.recording.log_stream import LogStream
    from crazychoir_fw.simulation import World

SUCCESS = 0


@dataclass(frozen=True)
class FlightRequest:
    """What the command line asks for."""

    mission: Path
    film: "FilmRequest | None"
    """How a film of the flight is to be made, if one is."""
    view: str | None
    """`auto`, `native` or `web`; None shows nothing."""
    out: Path | None
    threads: int | None
    overrides: dict[str, Any]
    """`seed`, `provider`, `app`, `backend` and `changes`, stronger than the mission file."""
    mcap: bool = False
    uri_base: str | None = None
    """URI of the first drone, if the others follow it."""
    hosting: Callable[[], AbstractContextManager[Any]] = nullcontext
    """Gives what makes the experiment while the flight lasts, if its layers are processes of their own."""


def attempt(request: FlightRequest, loaded: "Callable[[Mission], None] | None" = None) -> int:
    """Fly once, show how it went and write it down. Returns the exit code; what went wrong is printed.

    Args:
        request: What to fly.
        loaded: Called with the mission, once its file is known to be good.
    """
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.mission.loader import load_mission

    folder = request.out
    try:
        mission = load_mission(request.mission, request.uri_base, **request.overrides)
        ask_about(mission)
        if loaded is not None:
            loaded(mission)
        folder = folder if folder is not None else Path("out") / mission.name
        folder.mkdir(parents=True, exist_ok=True)  # before a flight that cannot be written down
        if request.mcap:
            from crazychoir_fw.recording.mcap_file import require_mcap

            require_mcap()
        with writing(folder) as stream:
            result = _fly(mission, request, stream)
            unwritten = _write(result, folder, stream, request.mcap)
    except CrazychoirError as error:
        complain_of(error)
        return BAD_INPUT
    except OSError as error:
        complain(about_file(error, folder))
        return BAD_INPUT

    for table in flight_tables(result.summary):
        console.print(table)
    if "link" in result.summary:
        from crazychoir_fw.crtp.link_model.tables import link_tables

        console.print(link_tables(result.summary["link"]))
    console.print(verdict(result.summary, None if unwritten else folder))
    if unwritten is not None:
        complain(unwritten)
    for failure in result.expected_failures:
        console.print(f"{failure}, as it may", style="yellow", markup=False, soft_wrap=True)
    for failure in result.failures:
        complain(failure)
    if unwritten is None and not _film(result, folder, request):
        return BAD_INPUT
    return SUCCESS if result.success else FLIGHT_FAILED


def _film(result: "FlightResult", folder: Path, request: FlightRequest) -> bool:
    """Make the requested film, or print the command that makes one; return whether no film is missing."""
    if request.film is None:
        console.print(f"film: crazychoir film {shlex.quote(str(folder))}", style="dim", markup=False, soft_wrap=True)
        return True
    from crazychoir_fw.cli.film import make_film
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.recording.video import usual_name

    path = folder / usual_name()
    try:
        make_film(result.log, path, request.film)
    except OSError as error:
        complain(about_file(error, path))
    except CrazychoirError as error:
        complain_of(error)
        return False
    return True


def _fly(mission: "Mission", request: FlightRequest, stream: "LogStream") -> "FlightResult":
    """Fly, with a progress bar and perhaps a window or a page."""
    from crazychoir_fw.common.errors import StateError
    from crazychoir_fw.flight.engine import fly

    view: AbstractContextManager[Observer | None] = nullcontext(None)
    if request.view is not None:
        if mission.backend != "sim":
            raise StateError(f"--view shows simulated drones, but the backend is {mission.backend}")
        from crazychoir_fw.cli.view import open_view

        view = open_view(request.view, lambda line: console.print(line, soft_wrap=True, markup=False))
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("{task.fields[pace]}"),
        TimeRemainingColumn(),
    )
    with view as show, Progress(*columns, console=console) as bar:
        task = bar.add_task(f"{mission.name}, {len(mission.fleet)} drones", total=None, pace="getting ready")

        def observe(world: "World | None", progress: "FlightProgress") -> None:
            pace = f"{progress.sim_seconds:.1f} s, {progress.real_time_factor:.1f} x real time"
            bar.update(task, completed=progress.sim_seconds, total=progress.total_seconds, pace=pace)
            if show is not None and world is not None:
                show(world, progress)

        with request.hosting() as make:
            return fly(mission, request.threads, request.view is not None, observe, make=make, stream=stream)


def _write(result: "FlightResult", folder: Path, stream: "LogStream", mcap: bool) -> str | None:
    """Write logs, summary and picture of a flight, all or none. Returns why they are not written, a sentence."""
    from crazychoir_fw.flight.summary import write_summary
    from crazychoir_fw.recording.plot import plot_flight
    from crazychoir_fw.simulation.stage import footprints

    def write(new: Path) -> None:
        result.log.save(new / "log.npz")
        write_summary(new / "summary.json", result.summary)
        if mcap:
            from crazychoir_fw.recording.mcap_file import write_mcap

            write_mcap(result.log, new / "log.mcap")
        title = result.mission.description or result.mission.name
        scenery = () if result.world is None else footprints(result.world.model)
        plot_flight(result.log, new / "flight.png", title, result.curve, result.timeline, scenery)

    return write_together(folder, write, stream)
