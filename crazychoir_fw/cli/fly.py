"""`crazychoir fly`: fly a mission, show how it went, write it down."""

from pathlib import Path
from typing import Annotated

import typer

from crazychoir_fw.cli.attempt import FlightRequest, attempt
from crazychoir_fw.cli.film import CAMERA_HELP, FOLLOW, FilmRequest
from crazychoir_fw.cli.shared_options import PROCESSES, Processes, Provider, Restart, Seed, Threads, UriBase, need_ros
from crazychoir_fw.cli.view import View, require_way
from crazychoir_fw.common.signals import held_signals, unwind_at_signals

MissionFile = Annotated[Path, typer.Argument(help="Mission file (YAML).", metavar="MISSION.yaml")]
Video = Annotated[
    bool | None,
    typer.Option("--video/--no-video", help="Make flight.mp4 at once; otherwise `crazychoir film` makes it."),
]
Camera = Annotated[str | None, typer.Option(help=f"{CAMERA_HELP} Means --video.", metavar="NAME")]
Out = Annotated[Path | None, typer.Option(metavar="DIR", help="Output folder; otherwise out/ and the mission's name.")]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", help="A value of the mission, such as layers.rate=50; repeatable.", metavar="KEY=VALUE"),
]
Apps = Annotated[
    list[Path] | None,
    typer.Option(help="C file with a controller or an estimator of yours; repeatable.", metavar="FILE.c"),
]
Mcap = Annotated[bool, typer.Option("--mcap", help="Write log.mcap too, for Foxglove, PlotJuggler and rosbag.")]
Watch = Annotated[bool, typer.Option("--watch", help="Fly again whenever the app or the mission is saved.")]
BackendName = Annotated[
    str | None,
    typer.Option(help="Where a mission with layers is flown, instead of its own.", metavar="sim|integrator|hardware"),
]
Ros = Annotated[bool, typer.Option("--ros", help="Fly the layers as ROS 2 nodes in processes of their own.")]
Domain = Annotated[int | None, typer.Option(help="With --ros, the ROS domain; otherwise a free one.", min=0, max=232)]
PaceFactor = Annotated[
    float | None,
    typer.Option(
        help="With --ros, simulated seconds per second; otherwise in lockstep, as fast as all can answer.",
        metavar="FACTOR",
    ),
]


def fly(
    mission: MissionFile,
    video: Video = None,
    camera: Camera = None,
    view: View = None,
    out: Out = None,
    seed: Seed = None,
    changes: Changes = None,
    provider: Provider = None,
    threads: Threads = None,
    app: Apps = None,
    mcap: Mcap = False,
    watch: Watch = False,
    backend: BackendName = None,
    uri_base: UriBase = None,
    ros: Ros = False,
    processes: Processes = PROCESSES,
    domain: Domain = None,
    pace: PaceFactor = None,
    restart: Restart = False,
) -> None:
    """Fly a mission and report on every drone."""
    overrides = {"seed": seed, "provider": provider, "app": app or None, "backend": backend, "changes": changes}
    require_way(view)
    with held_signals():
        import crazychoir_fw.mission.loader  # noqa: F401 pydantic reports Ctrl-C as a mistake in its models
    wants_film = camera is not None if video is None else video
    film = FilmRequest(camera or FOLLOW) if wants_film else None
    request = FlightRequest(mission, film, view, out, threads, overrides, mcap, uri_base)
    if ros:
        from crazychoir_fw.cli.fly_ros import fly_as_nodes

        if watch:
            raise typer.BadParameter("does not go with --ros", param_hint="--watch")
        if code := fly_as_nodes(request, processes, domain, pace, restart):
            raise typer.Exit(code)
        return
    need_ros(processes=processes != PROCESSES, domain=domain is not None, pace=pace is not None, restart=restart)
    if watch:
        from crazychoir_fw.cli.again import fly_again_on_save

        fly_again_on_save(request)
        return
    with unwind_at_signals():
        code = attempt(request)
    if code:
        raise typer.Exit(code)
