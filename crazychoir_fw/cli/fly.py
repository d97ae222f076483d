"""`crazychoir fly`: fly a mission, show how it went, write it down."""

from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from crazychoir_fw.cli.console import FLIGHT_FAILED, complain, console, refuse
from crazychoir_fw.cli.tables import flight_table, verdict

if TYPE_CHECKING:
    from crazychoir_fw.mission.runner import FlightResult, Observer
    from crazychoir_fw.mission.runner import Progress as FlightProgress
    from crazychoir_fw.mission.schema import Mission
    from crazychoir_fw.simulation import World

FRAMES_PER_SECOND = 25


def fly(
    mission: Annotated[Path, typer.Argument(help="Mission file (YAML).", metavar="MISSION.yaml")],
    video: Annotated[bool, typer.Option("--video/--no-video", help="Render flight.mp4.")] = True,
    view: Annotated[bool, typer.Option("--view", help="Watch the flight in a window, in real time.")] = False,
    out: Annotated[Path | None, typer.Option(help="Output folder.  [default: out/<mission name>]")] = None,
    seed: Annotated[int | None, typer.Option(min=0, max=2**32 - 1, help="Seed instead of the mission's.")] = None,
    provider: Annotated[str | None, typer.Option(help="Provider of the onboard software.")] = None,
    threads: Annotated[int | None, typer.Option(min=1, max=64, help="Worker threads.")] = None,
) -> None:
    """Fly a mission in simulation and report on every drone."""
    from crazychoir_fw.errors import CrazychoirError
    from crazychoir_fw.mission import load_mission

    try:
        flown = load_mission(mission, seed=seed, provider=provider)
        folder = _make_folder(out if out is not None else Path("out") / flown.name)
        reason = _no_video_because(video)
        result = _fly(flown, threads, view, FRAMES_PER_SECOND if reason is None else 0)
        _write(result, folder, reason)
    except CrazychoirError as error:
        refuse(str(error))
    except OSError as error:
        refuse(f"{error.filename or folder} cannot be written: {error.strerror}")

    console.print(flight_table(result.summary))
    console.print(verdict(result.summary, folder))
    for failure in result.failures:
        complain(failure)
    if not result.success:
        raise typer.Exit(FLIGHT_FAILED)


def _make_folder(folder: Path) -> Path:
    """Create the output folder, so that a flight is not flown in vain."""
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _no_video_because(wanted: bool) -> str | None:
    """Return why there will be no video, or None if there will be one."""
    if not wanted:
        return "--no-video"
    from crazychoir_fw.report.video import rendering_available

    return rendering_available()


def _fly(mission: "Mission", threads: int | None, view: bool, fps: int) -> "FlightResult":
    """Fly, with a progress bar and perhaps a window."""
    from crazychoir_fw.mission.runner import fly as fly_mission

    window: AbstractContextManager[Observer | None] = nullcontext(None)
    if view:
        from crazychoir_fw.cli.view import open_window

        window = open_window()
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("{task.fields[pace]}"),
        TimeRemainingColumn(),
    )
    with window as show, Progress(*columns, console=console) as bar:
        task = bar.add_task(f"{mission.name}, {len(mission.fleet)} drones", total=None, pace="getting ready")

        def observe(world: "World", progress: "FlightProgress") -> None:
            pace = f"{progress.sim_seconds:.1f} s, {progress.real_time_factor:.1f} x real time"
            bar.update(task, completed=progress.sim_seconds, total=progress.total_seconds, pace=pace)
            if show is not None:
                show(world, progress)

        visuals = view or fps > 0
        return fly_mission(mission, threads=threads, visuals=visuals, frames_per_second=fps, observe=observe)


def _write(result: "FlightResult", folder: Path, no_video_because: str | None) -> None:
    """Write the summary, the log, the picture and the video of a flight."""
    from crazychoir_fw.mission.summary import write_summary
    from crazychoir_fw.report.plot import plot_flight

    title = result.mission.description or result.mission.name
    write_summary(folder / "summary.json", result.summary)
    result.log.save(folder / "log.npz")
    plot_flight(result.log, folder / "flight.png", title)
    if no_video_because is not None or not result.film.times:
        console.print(f"No video: {no_video_because or 'the flight did not begin'}", style="yellow", markup=False)
        return

    from crazychoir_fw.report.video import film_flight

    with console.status("Rendering flight.mp4"):
        film_flight(result.world.model, result.film.qpos, result.film.times, folder / "flight.mp4", fps=result.film.fps)
