"""A page on this machine that shows a flight while it is flown: the view of `crazychoir gui`, without its buttons."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

from crazychoir_fw.cli.gui import bind
from crazychoir_fw.cli.pace import FramePacer

if TYPE_CHECKING:
    from crazychoir_fw.flight.engine import Observer, Progress
    from crazychoir_fw.gui.live import Live
    from crazychoir_fw.simulation import World

HOST = "127.0.0.1"
PORT = 8080  # or the next free one
PATIENCE_S = 60.0
"""How long a flight waits until the page is open (s)."""
_DRAWN_S = 0.5  # until the page has drawn what it got


@contextmanager
def open_page(say: Callable[[str], None], patience_s: float = PATIENCE_S) -> Iterator[Observer]:
    """Yield an observer that shows the flight on a page; when the page is closed, the flight goes on.

    Args:
        say: Called with one line that has the address.
        patience_s: How long the first sample waits until a browser has opened the page (s).

    Raises:
        MissingLibraryError: If NiceGUI is not installed.
    """
    from crazychoir_fw.gui.server import make_view_server, require_nicegui

    require_nicegui()
    from crazychoir_fw.gui.feed import FRAME_S
    from crazychoir_fw.gui.live import WORDS_S
    from crazychoir_fw.gui.viewing import Viewing

    viewing = server = live = thread = None
    pace = FramePacer(FRAME_S)

    def show(world: World, progress: Progress) -> None:
        nonlocal viewing, server, live, thread
        if viewing is None:
            viewing = Viewing(world, "crazychoir")
            viewing.show(progress.sim_seconds, time.perf_counter())
            bound = _bind()
            server, live = make_view_server(viewing)
            bound.listen()
            thread = threading.Thread(target=server.run, args=[[bound]], name="page", daemon=True)
            thread.start()
            say(
                f"Watch at http://{HOST}:{bound.getsockname()[1]}/ (this machine only); "
                f"the flight begins when the page is open, or in {patience_s:.0f} s"
            )
            _wait_for_somebody(live, patience_s)
        if pace.is_frame(progress.sim_seconds):
            viewing.show(progress.sim_seconds, time.perf_counter())
        pace.wait(progress.sim_seconds)

    try:
        yield show
    finally:
        if server is not None:
            viewing.is_over = True
            if live.count:
                time.sleep(2 * WORDS_S)  # until browsers have heard of it
            server.should_exit = True
            thread.join(timeout=10.0)


def _wait_for_somebody(live: Live, patience_s: float) -> None:
    end = time.monotonic() + patience_s
    while not live.count and time.monotonic() < end:
        time.sleep(0.05)
    if live.count:
        time.sleep(_DRAWN_S)


def _bind() -> socket.socket:
    """Return a socket at the first free port from `PORT` on."""
    for port in range(PORT, PORT + 100):
        with suppress(OSError):
            return bind(HOST, port)
    return bind(HOST, 0)
