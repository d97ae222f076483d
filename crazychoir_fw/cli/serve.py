"""`crazychoir serve`: let scripts with the unmodified cflib fly the drones of a mission."""

import json
import time
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crazychoir_fw.cli.console import (
    BAD_INPUT,
    FLIGHT_FAILED,
    about_file,
    ask_about,
    complain,
    complain_of,
    console,
    refuse,
)
from crazychoir_fw.cli.records import write_together, writing
from crazychoir_fw.cli.serve_texts import STATUS_S, Status, announce, summary
from crazychoir_fw.cli.shared_options import Provider, Seed, Threads
from crazychoir_fw.cli.view import View, require_way
from crazychoir_fw.common.signals import stop_at_signals

if TYPE_CHECKING:
    from crazychoir_fw.crtp.server import Server
    from crazychoir_fw.crtp.server_statistics import Statistics
    from crazychoir_fw.flight.engine import Observer
    from crazychoir_fw.mission.schema import Mission
    from crazychoir_fw.recording.log_stream import LogStream
    from crazychoir_fw.simulation import FlightRecorder, World

BOOT_S = 5.0
"""So long drones may take to boot (s, simulated)."""
_FRAME_S = 1.0 / 60.0
_NO_JOURNAL = "the drones were served with --no-journal"


@dataclass(frozen=True)
class ServeRequest:
    """What the command line asks for."""

    host: str
    port: int
    speed: float
    seconds: float | None
    out: Path | None
    view: str | None
    threads: int | None
    newest_wins: bool
    keep_priority: bool
    storage: Path | None
    reads_ahead: bool
    keeps_journal: bool
    clients: int


Drones = Annotated[
    int | None,
    typer.Option("--count", min=1, max=1000, help="Serve a grid of so many default drones instead of a mission."),
]
Port = Annotated[
    int, typer.Option(min=0, max=65535, metavar="PORT", help="UDP port of the first drone; 0 takes any free ones.")
]
Speed = Annotated[
    float,
    typer.Option(min=0.0, max=1000.0, metavar="FACTOR", help="Simulated seconds per second; 0 is as fast as possible."),
]
Seconds = Annotated[
    float | None,
    typer.Option(min=0.0, max=1e6, metavar="SECONDS", help="Simulated time to serve (s); otherwise until Ctrl-C."),
]
NewestWins = Annotated[
    bool, typer.Option("--newest-wins", help="A second client takes a drone from the first; otherwise it waits.")
]
KeepPriority = Annotated[
    bool,
    typer.Option("--keep-priority", help="Do not relax the priority of set-points when a client has gone."),
]
Storage = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Folder of what clients store on their drones, from one run to the next."),
]
AsAsked = Annotated[
    bool,
    typer.Option("--as-asked", help="Send tables of contents item by item, to all clients at once."),
]
WaitFor = Annotated[
    int, typer.Option(min=0, metavar="N", help="Let time stand still until so many drones have a client.")
]
NoJournal = Annotated[
    bool,
    typer.Option("--no-journal", help="With --out: write no requests down, for days of serving; no replay then."),
]


def serve(
    mission: Annotated[
        Path | None,
        typer.Argument(help="Mission file (YAML): its drones, scene and faults.", metavar="MISSION.yaml"),
    ] = None,
    drones: Drones = None,
    host: Annotated[str, typer.Option(help="Address of this machine to listen at.")] = "127.0.0.1",
    port: Port = 19850,
    speed: Speed = 1.0,
    seconds: Seconds = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for log.npz, flight.png and statistics.json.")
    ] = None,
    view: View = None,
    seed: Seed = None,
    provider: Provider = None,
    threads: Threads = None,
    newest_wins: NewestWins = False,
    keep_priority: KeepPriority = False,
    storage: Storage = None,
    as_asked: AsAsked = False,
    wait_for: WaitFor = 0,
    no_journal: NoJournal = False,
) -> None:
    """Serve the drones of a mission by UDP, so that scripts with cflib fly them; its phases are not flown."""
    from crazychoir_fw.common.errors import CrazychoirError, RangeError

    require_way(view)
    if (mission is None) == (drones is None):
        refuse("name a mission file, or a number of drones with --count")
    request = ServeRequest(
        host,
        port,
        speed,
        seconds,
        out,
        view,
        threads,
        newest_wins,
        keep_priority,
        storage,
        reads_ahead=not as_asked,
        keeps_journal=not no_journal,
        clients=wait_for,
    )
    try:
        chosen = _mission(mission, drones, {"seed": seed, "provider": provider})
        if wait_for > len(chosen.fleet):
            raise RangeError(f"--wait-for is {wait_for}, allowed: 0 to {len(chosen.fleet)}, the number of drones")
        if out is not None:
            out.mkdir(parents=True, exist_ok=True)
        with nullcontext() if out is None else writing(out) as stream:
            failures = _serve(chosen, request, stream)
    except CrazychoirError as error:
        complain_of(error)
        raise typer.Exit(BAD_INPUT) from None
    except OSError as error:
        complain(about_file(error, out))
        raise typer.Exit(BAD_INPUT) from None
    for failure in failures:
        complain(failure)
    if failures:
        raise typer.Exit(FLIGHT_FAILED)


def _mission(path: Path | None, drones: int | None, overrides: dict[str, Any]) -> "Mission":
    from crazychoir_fw.mission import load_mission, parse_mission
    from crazychoir_fw.mission.mixed import real_part

    if path is not None:
        loaded = load_mission(path, **overrides)
        ask_about(loaded)
        return real_part(loaded)
    # a mission needs a phase, which is not flown here
    grid = {"name": "served", "drones": {"count": drones, "spacing": 1.0}, "flight": [{"hover": {"duration": 1.0}}]}
    return parse_mission(grid, source="--count", **overrides)


def _serve(mission: "Mission", request: ServeRequest, stream: "LogStream | None") -> list[str]:
    """Serve until the end. Returns what the core stopped drones for, one sentence each."""
    from crazychoir_fw.common.errors import StateError
    from crazychoir_fw.flight.backends import add_faults, build_world, simulated_radios
    from crazychoir_fw.flight.streamed import Flushes
    from crazychoir_fw.simulation import FlightRecorder

    view: AbstractContextManager[Observer | None] = nullcontext(None)
    if request.view is not None:
        from crazychoir_fw.cli.view import open_view

        view = open_view(request.view, lambda line: console.print(line, soft_wrap=True, markup=False))
    world = build_world(mission, request.threads, visuals=request.view is not None)
    # without a folder it could not be read, and it grows with every packet
    if request.out is None or not request.keeps_journal:
        world.stop_journal(_NO_JOURNAL)
    server = world.serve(
        request.host,
        request.port,
        request.speed,
        simulated_radios(mission),
        newest_client_wins=request.newest_wins,
        relax_after_session=not request.keep_priority,
        storage=request.storage,
        reads_ahead=request.reads_ahead,
    )
    with view as show, server, stop_at_signals(server.stop):
        _boot(world)
        add_faults(mission, world)
        recorder, flushes = None, None
        if stream is not None:
            recorder = FlightRecorder(world)
            recorder.write_to(stream, _about(mission))
            flushes = Flushes(stream, recorder.flush, lambda: ())
            recorder.sample()
            world.agenda.every(recorder.ticks_per_sample, recorder.sample)
        # a page waits for its first browser, and drones do not move before
        picture = _Picture(show, world) if show is not None else None
        announce(server, mission, request.host, request.speed, request.seconds)
        if request.clients:
            server.pause()
            console.print(f"Time stands still until {request.clients} drones have a client")
        try:
            with Status(server) as status:

                def observe(_: "Server") -> None:
                    status.show()
                    if flushes is not None:
                        flushes.look()
                    if server.is_paused and server.clients >= request.clients:
                        server.resume()
                    if picture is not None:
                        picture.show()

                server.run(request.seconds, observe, _FRAME_S if picture is not None else STATUS_S)
        except StateError as error:
            if show is None:
                raise
            console.print(str(error), markup=False)  # the window was closed
        finally:
            if flushes is not None:
                flushes.write()
    _report(server.statistics(), mission, request.out, recorder, stream)
    return [drone.failure for drone in world.drones if drone.failure is not None]


def _report(
    statistics: "Statistics",
    mission: "Mission",
    folder: Path | None,
    recorder: "FlightRecorder | None",
    stream: "LogStream | None",
) -> None:
    """Say how it went, and write it down."""
    console.print(summary(statistics))
    if statistics.link:
        from crazychoir_fw.crtp.link_model.tables import link_tables

        console.print(link_tables(statistics.link))
    if folder is not None and recorder is not None and stream is not None:
        _write(folder, mission, recorder, statistics, stream)


def _about(mission: "Mission") -> dict[str, Any]:
    return {"mission": mission.name, "description": mission.description}


def _boot(world: "World") -> None:
    """Let the drones come up as after they were switched on; arming is for the scripts."""
    end = world.time + BOOT_S
    while world.time < end and not all(drone.can_fly or drone.can_arm or drone.failure for drone in world.drones):
        world.run(0.1)


class _Picture:
    """Hands the world to a view, by the time on the wall: the server keeps the pace, and the view need not."""

    def __init__(self, show: "Observer", world: "World") -> None:
        self._show = show
        self._world = world
        self._began = 0.0
        self.show()
        # opening a window takes time that clients shall not wait for
        self._began = time.perf_counter()

    def show(self) -> None:
        """Show the present instant."""
        from crazychoir_fw.flight.engine import Progress

        seconds = time.perf_counter() - self._began if self._began else 0.0
        self._show(self._world, Progress(seconds, 0.0, seconds))


def _write(
    folder: Path, mission: "Mission", recorder: "FlightRecorder", statistics: "Statistics", stream: "LogStream"
) -> None:
    """Write the log, the picture and the figures."""
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

    from crazychoir_fw.recording.plot import plot_flight

    def write(new: Path) -> None:
        about = {**_about(mission), "server": statistics.as_dict()}
        with Progress(TextColumn("writing log.npz"), BarColumn(), TaskProgressColumn(), console=console) as bar:
            task = bar.add_task("log", total=1.0)
            log = recorder.save(new / "log.npz", about, lambda share: bar.update(task, completed=share))
        plot_flight(log, new / "flight.png", mission.description or mission.name)
        text = json.dumps(statistics.as_dict(), indent=2) + "\n"
        (new / "statistics.json").write_text(text, encoding="utf-8")

    unwritten = write_together(folder, write, stream)
    if unwritten is not None:
        complain(unwritten)
        return
    note = "" if recorder.keeps_journal else " (without a journal: it cannot be replayed)"
    console.print(f"Written to {folder}/{note}", markup=False, highlight=False)
