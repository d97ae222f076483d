"""`crazychoir gui`: a page in the browser to draw, preview, fly, watch and rewind a mission."""

import errno
import socket
import threading
import webbrowser
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crazychoir_fw.cli.console import BAD_INPUT, ask_about, complain, complain_of, console
from crazychoir_fw.cli.shared_options import PROCESSES, Processes, Restart, Seed, UriBase, need_ros
from crazychoir_fw.common.signals import stop_at_signals

if TYPE_CHECKING:
    from crazychoir_fw.gui.flight_stream import SessionStream
    from crazychoir_fw.gui.session import Session

DEFAULT_PORT = 8080
"""Default port of the page."""

_READY_S = 240.0  # whatever keeps drones from being ready for so long says so itself
Host = Annotated[str, typer.Option(help="Address to listen at; from other machines browsers need the token.")]
Token = Annotated[
    str | None,
    typer.Option(help="What browsers must know; made for other hosts and real drones."),
]
Backend = Annotated[
    str | None,
    typer.Option(help="Where the drones are, instead of the mission's.", metavar="sim|integrator|hardware"),
]
LogFile = Annotated[
    Path | None,
    typer.Option(help="File in which the flight is logged when the page ends.", metavar="FILE.mcap|csv|npz"),
]
Ros = Annotated[
    bool,
    typer.Option("--ros", help="Fly the layers as ROS 2 nodes in processes of their own, beside the page."),
]
RosJoin = Annotated[
    bool, typer.Option("--ros-join", help="Show a flight that others have started over ROS 2, and leave it going.")
]
Domain = Annotated[
    int | None,
    typer.Option(
        help="ROS domain; otherwise a free one with --ros, and that of ROS_DOMAIN_ID with --ros-join.",
        min=0,
        max=232,
    ),
]


def gui(
    mission: Annotated[Path, typer.Argument(help="Mission file (YAML).", metavar="MISSION.yaml")],
    port: Annotated[
        int, typer.Option(min=0, max=65535, metavar="PORT", help="Port of the page; 0 is any free one.")
    ] = DEFAULT_PORT,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Do not open a browser.")] = False,
    host: Host = "127.0.0.1",
    token: Token = None,
    backend: Backend = None,
    uri_base: UriBase = None,
    speed: Annotated[
        float, typer.Option(min=0.0, max=100.0, metavar="FACTOR", help="Simulated seconds per second; 0 pauses.")
    ] = 1.0,
    drawings: Annotated[Path, typer.Option(metavar="DIR", help="Folder in which drawings are saved.")] = Path(
        "drawings"
    ),
    log: LogFile = None,
    seed: Seed = None,
    ros: Ros = False,
    ros_join: RosJoin = False,
    processes: Processes = PROCESSES,
    domain: Domain = None,
    restart: Restart = False,
) -> None:
    """Open the page of a mission: nothing flies until somebody presses a button there."""
    from crazychoir_fw.common.errors import CrazychoirError, RangeError
    from crazychoir_fw.gui.server import require_nicegui, token_for

    if not ros:
        need_ros(processes=processes != PROCESSES, domain=domain is not None and not ros_join, restart=restart)
    try:
        token_for(host, False, token)
        require_nicegui()
        from crazychoir_fw.gui.flight_record import check_format
        from crazychoir_fw.gui.opening import open_mission

        loaded = open_mission(mission, uri_base, backend=backend, seed=seed)
        ask_about(loaded)
        if log is not None:
            check_format(log.name)
        token = token_for(host, loaded.backend in ("hardware", "mixed"), token)
        page = Page(host, bind(host, port), token, drawings, not no_browser, log)
        if ros or ros_join:
            from crazychoir_fw.cli.gui_ros import OverRos, show_over_ros

            if ros and ros_join:
                raise RangeError("--ros starts a flight and --ros-join joins one: give one of them")
            how = OverRos(ros_join, processes, domain, speed, restart)
            if code := show_over_ros(loaded, how, page.show):
                raise typer.Exit(code)
            return
        from crazychoir_fw.gui.session import Session

        tested = None
        if loaded.backend in ("hardware", "mixed"):
            from crazychoir_fw.campaign.standing import standing

            tested = standing(mission, (), Path("out") / loaded.name)
        page.show(Session(loaded, speed, tested=tested))
    except CrazychoirError as error:
        complain_of(error)
        raise typer.Exit(BAD_INPUT) from None
    except OSError as error:
        taken = f"port {port} of {host} is in use: give another with --port, or 0 for any free one"
        is_taken = error.errno == errno.EADDRINUSE
        complain(taken if is_taken else f"--host {host} --port {port}: {error.strerror}")
        raise typer.Exit(BAD_INPUT) from None


@dataclass(frozen=True)
class Page:
    """Where the page of a flight is, and where its log goes."""

    host: str
    bound: socket.socket
    """Where it will be; deaf until the drones are ready."""
    token: str | None
    drawings: Path
    opens_browser: bool
    log: Path | None

    def show(self, session: "Session") -> None:
        """Open a flight, and serve its page until Ctrl-C.

        Raises:
            CrazychoirError: If there is no flight, or its log cannot be written.
        """
        from crazychoir_fw.gui.server import make_server

        port = self.bound.getsockname()[1]
        server = make_server(session, self.host, port, self.token, self.drawings)
        shown = "127.0.0.1" if self.host in ("0.0.0.0", "::") else self.host
        address = f"http://{shown}:{port}/" + (f"?token={self.token}" if self.token else "")
        if self.log is None:
            self._serve(session, server, address)
            return
        session.stream = stream = self._open_stream(self.log)
        try:
            self._serve(session, server, address)
            _write_log(session, self.log)
        except BaseException:
            stream.close()
            raise
        stream.close(remove=True)

    def _serve(self, session: "Session", server: Any, address: str) -> None:
        """Fly until Ctrl-C."""
        with self.bound, session:
            with console.status("The drones get ready"):
                session.wait_until_ready(_READY_S)
            # a browser that connects before the server has started waits for it
            self.bound.listen()
            console.print(f"The page is at {address} (Ctrl-C ends it)", soft_wrap=True, markup=False)
            if self.opens_browser:
                threading.Thread(target=webbrowser.open, args=[address], daemon=True).start()
            with stop_at_signals(lambda: setattr(server, "should_exit", True)):
                server.run([self.bound])

    @staticmethod
    def _open_stream(log: Path) -> "SessionStream":
        """Return what the flight is written to until its log is: beside it, with the suffix ``.stream``.

        Raises:
            CrazychoirError: If it cannot be written.
        """
        from crazychoir_fw.common.errors import CrazychoirError
        from crazychoir_fw.gui.flight_stream import SessionStream

        path = log.with_suffix(".stream")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            return SessionStream(path)
        except OSError as error:
            raise CrazychoirError(f"--log {log}: {path} cannot be written: {error.strerror}") from None


def _write_log(session: "Session", path: Path) -> None:
    """Write what was flown.

    Raises:
        CrazychoirError: If nothing was, or the file cannot be written.
    """
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.gui.flight_record import record_of, write_record

    record = record_of(session)
    try:
        write_record(record, path)
    except OSError as error:
        raise CrazychoirError(f"--log {path} cannot be written: {error.strerror}") from None
    console.print(f"{record.duration_s:.1f} s of flight are in {path}", soft_wrap=True, markup=False)


def bind(host: str, port: int) -> socket.socket:
    """Return a socket bound to a free address.

    Raises:
        OSError: If it is taken.
    """
    bound = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET)
    try:
        # a page can be opened again right after it was closed
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, int(port != 0))
        bound.bind((host, port))
    except BaseException:
        bound.close()
        raise
    return bound
