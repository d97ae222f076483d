"""One flight of `crazychoir fly`: read the mission, fly it, show how it went, write it down."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from crazychoir_fw.cli.console import BAD_INPUT, FLIGHT_FAILED, about_file, complain, complain_of, console
from crazychoir_fw.cli.tables import flight_tables, verdict

if TYPE_CHECKING:
    from crazychoir_fw.flight.engine import Observer
    from crazychoir_fw.flight.engine import Progress as FlightProgress
    from crazychoir_fw.flight.flight_result import FlightResult
    from crazychoir_fw.mission.schema import Mission
    from crazychoir_fw.simulation import World

FRAMES_PER_SECOND = 25
SUCCESS = 0


@dataclass(frozen=True)
class FlightRequest:
    """What the command line asks for."""

    mission: Path
    video: bool
    camera: str
    """Of the film."""
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
        if loaded is not None:
            loaded(mission)
        folder = folder if folder is not None else Path("out") / mission.name
        folder.mkdir(parents=True, exist_ok=True)  # before a flight that cannot be written down
        if request.mcap:
            from crazychoir_fw.recording.mcap_file import require_mcap

            require_mcap()
        reason = _no_video_because(request.video)
        result = _fly(mission, request, FRAMES_PER_SECOND if reason is None else 0)
        _write(result, folder, reason, request)
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
    console.print(verdict(result.summary, folder))
    for failure in result.expected_failures:
        console.print(f"{failure}, as it may", style="yellow", markup=False, soft_wrap=True)
    for failure in result.failures:
        complain(failure)
    return SUCCESS if result.success else FLIGHT_FAILED


def _no_video_because(wanted: bool) -> str | None:
    """Return why there will be no video, or None if there will be one."""
    if not wanted:
        return "--no-video"
    from crazychoir_fw.recording.video import rendering_available

    return rendering_available()


def _fly(mission: "Mission", request: FlightRequest, fps: int) -> "FlightResult":
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
            if fps > 0 and progress.sim_seconds == 0.0 and world is not None:
                _check_camera(world, request.camera)
            pace = f"{progress.sim_seconds:.1f} s, {progress.real_time_factor:.1f} x real time"
            bar.update(task, completed=progress.sim_seconds, total=progress.total_seconds, pace=pace)
            if show is not None and world is not None:
                show(world, progress)

        visuals = request.view is not None or fps > 0
        with request.hosting() as make:
            return fly(mission, request.threads, visuals, fps, observe, make=make)


def _check_camera(world: "World", camera: str) -> None:
    """Refuse a camera that is not there before the flight, and not when it is over."""
    from crazychoir_fw.common.errors import UnknownNameError
    from crazychoir_fw.recording.shots import find_shot

    try:
        find_shot(world.model, camera)
    except ValueError as error:
        raise UnknownNameError(f"--camera: {error}") from None


def _write(result: "FlightResult", folder: Path, no_video_because: str | None, request: FlightRequest) -> None:
    """Write the summary, the logs, the picture and the video of a flight."""
    from crazychoir_fw.flight.summary import write_summary
    from crazychoir_fw.recording.plot import plot_flight

    title, film, timeline = result.mission.description or result.mission.name, result.film, result.timeline
    write_summary(folder / "summary.json", result.summary)
    result.log.save(folder / "log.npz")
    if request.mcap:
        from crazychoir_fw.recording.mcap_file import write_mcap

        write_mcap(result.log, folder / "log.mcap")
    plot_flight(result.log, folder / "flight.png", title, result.curve, timeline)
    reason = no_video_because or film.missing
    if reason is not None:
        console.print(f"No video: {reason}", style="yellow", markup=False)
        return

    from crazychoir_fw.recording.video import film_flight

    hint = f" ({film.speed:g} x speed)" if film.speed != 1.0 else ""
    with console.status(f"Rendering flight.mp4{hint}"):
        film_flight(
            result.film_model,
            film.qpos,
            film.times,
            folder / "flight.mp4",
            camera=request.camera,
            fps=film.fps,
            speed=film.speed,
            links=film.links,
            marks=[*film.marks, *(() if timeline is None else timeline.marks)],
            drones=film.drones,
        )
