"""`crazychoir film`: a film of a recorded flight, from its log alone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from crazychoir_fw.cli.console import BAD_INPUT, complain_of, complaints, console

if TYPE_CHECKING:
    from crazychoir_fw.recording.flight_log import FlightLog

FOLLOW = "follow"
CAMERA_HELP = "Camera of the film: follow, fpv:DRONE, chase:DRONE or one of the scene."
_SMALL = (480, 270, 12.5)
"""Width, height (pixels) and pictures per second of what goes into a README."""


@dataclass(frozen=True)
class FilmRequest:
    """How a film is to be."""

    camera: str = FOLLOW
    speed: float | None = None
    """Seconds of flight per second of film; None: as fast as it must be to end in time."""
    size: tuple[int, int] = (768, 432)
    """Width and height (pixels)."""
    fps: float = 25.0
    begin: float | None = None
    """Of the part of the flight that is shown (s)."""
    end: float | None = None
    """(s)"""
    is_bare: bool = False
    """Whether title, clock, names, trails and the rest are left out."""
    is_true_size: bool = False
    """Whether drones are drawn as large as they are."""


def film(
    log: Annotated[Path, typer.Argument(help="Folder of a flight, or its log (NPZ).", metavar="FOLDER|LOG")],
    camera: Annotated[str, typer.Option(help=CAMERA_HELP, metavar="NAME")] = FOLLOW,
    speed: Annotated[
        float | None,
        typer.Option(
            min=0.01, max=1000.0, help="Seconds of flight per second of film; otherwise 1, more above 20 s of film."
        ),
    ] = None,
    gif: Annotated[
        bool, typer.Option("--gif", help="Write flight.gif for a README: 480 x 270, 12.5 pictures per second.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            help="File, .mp4, .gif or .webp; otherwise flight.mp4 beside the log, or flight.gif without ffmpeg."
        ),
    ] = None,
    size: Annotated[
        str | None, typer.Option(help="Width and height in pixels; otherwise 768x432.", metavar="WxH")
    ] = None,
    fps: Annotated[float | None, typer.Option(min=1.0, max=120.0, help="Pictures per second; otherwise 25.")] = None,
    begin: Annotated[float | None, typer.Option("--from", help="Begin at this time of the log (s).")] = None,
    end: Annotated[float | None, typer.Option("--to", help="End at this time of the log (s).")] = None,
    bare: Annotated[bool, typer.Option("--bare", help="No title, clock, names, trails and marks.")] = False,
    true_size: Annotated[
        bool, typer.Option("--true-size", help="Draw small drones of a wide swarm no larger than they are.")
    ] = False,
) -> None:
    """Make a film of a recorded flight, by any camera and at any speed."""
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.recording.video import usual_name
    from crazychoir_fw.simulation.replay import load_flight

    folder = log if log.is_dir() else log.parent
    path = out if out is not None else folder / ("flight.gif" if gif else usual_name())
    is_small = path.suffix.lower() != ".mp4"
    width, height, rate = _SMALL if is_small else (768, 432, 25.0)
    try:
        request = FilmRequest(
            camera,
            speed,
            _size(size) if size is not None else (int(width), int(height)),
            fps if fps is not None else rate,
            begin,
            end,
            bare,
            true_size,
        )
        make_film(load_flight(log), path, request)
    except CrazychoirError as error:
        complain_of(error)
        raise typer.Exit(BAD_INPUT) from None
    console.print(f"Written to {path}", markup=False, highlight=False, soft_wrap=True)


def _size(words: str) -> tuple[int, int]:
    from crazychoir_fw.common.errors import RangeError

    width, _, height = words.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal() and 64 <= int(width) <= 3840 and 64 <= int(height) <= 2160):
        raise RangeError(f"--size is {words}, allowed: 64x64 to 3840x2160, such as 1280x720")
    return int(width), int(height)


def make_film(log: FlightLog, path: Path, request: FilmRequest) -> None:
    """Make a film of a log, with a progress bar.

    Raises:
        CrazychoirError: If it cannot be made; the text says why.
    """
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.recording.film import LONGEST_S, film_flight
    from crazychoir_fw.recording.opengl import RenderingError
    from crazychoir_fw.recording.storyboard import Storyboard
    from crazychoir_fw.simulation.stage import stage_of

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    try:
        log = log.between(request.begin, request.end)
        stage = stage_of(log)
        for warning in stage.warnings:
            complaints.print(f"Note: {warning}", style="yellow", markup=False, highlight=False, soft_wrap=True)
        span = float(stage.times[-1] - stage.times[0])
        speed = request.speed if request.speed is not None else float(max(1, math.ceil(span / LONGEST_S - 1e-6)))
        with Progress(*columns, console=complaints, transient=True, disable=not complaints.is_terminal) as bar:
            task = bar.add_task(path.name, total=None)
            film_flight(
                stage.model,
                stage.qpos,
                stage.times,
                path,
                camera=request.camera,
                width=request.size[0],
                height=request.size[1],
                fps=request.fps,
                speed=speed,
                trail_s=0.0 if request.is_bare else 3.0,
                drones=stage.drones,
                story=None if request.is_bare else Storyboard.of(log),
                targets=None if request.is_bare else stage.targets,
                painted=stage.painted,
                magnify=not request.is_true_size,
                progress=lambda done, count: bar.update(task, completed=done, total=count),
            )
    except RenderingError as error:
        raise CrazychoirError(f"no film: {error}") from error
    except ValueError as error:
        raise CrazychoirError(str(error)) from error
    except OSError as error:
        raise CrazychoirError(f"{error.filename or path} cannot be written: {error.strerror}") from error
