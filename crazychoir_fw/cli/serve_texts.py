"""What `crazychoir serve` prints: where the drones are, how it goes, and how it went."""

import ipaddress
import time
from typing import TYPE_CHECKING

from rich import box
from rich.live import Live
from rich.table import Table
from rich.text import Text

from crazychoir_fw.cli.console import complaints, console

if TYPE_CHECKING:
    from crazychoir_fw.crtp.server import Server
    from crazychoir_fw.crtp.server_statistics import Statistics
    from crazychoir_fw.mission.schema import Mission

LONGEST_LIST = 32
"""So many drones are listed."""
STATUS_S = 0.25
"""Time from one status line to the next (s)."""


def announce(server: "Server", mission: "Mission", host: str, speed: float, seconds: float | None) -> None:
    """Print which drone is where.

    Args:
        server: A server that has been started.
        mission: What it serves.
        host: Address that it listens at.
        speed: Simulated seconds per second; 0 is as fast as possible.
        seconds: Simulated time to serve (s); None until Ctrl-C.
    """
    if not _is_loopback(host):
        complaints.print(
            f"Note: whoever reaches {host} over the network can fly these drones; there is no password",
            style="yellow",
            markup=False,
            soft_wrap=True,
        )
    uris = server.uris
    table = Table(
        title=f"{mission.name}: {len(uris)} drones", box=box.SIMPLE_HEAD, pad_edge=False, title_justify="left"
    )
    for heading in ("drone", "URI", "platform", "start (m)"):
        table.add_column(heading, no_wrap=True)
    for drone in server.world.drones[:LONGEST_LIST]:
        x, y, z = drone.true_position
        table.add_row(drone.id, uris[drone.id], drone.config.platform, f"{x:.2f}, {y:.2f}, {z:.2f}")
    console.print(table)
    if len(uris) > LONGEST_LIST:
        last = server.world.drones[-1].id
        console.print(f"… and so on, up to {last} at {uris[last]}", markup=False, highlight=False)
    pace = f"{speed:g} x real time" if speed else "as fast as possible"
    end = "Ctrl-C ends" if seconds is None else f"for {seconds:g} s"
    console.print(f"Serving, {pace}; {end}", markup=False, highlight=False)


def _is_loopback(host: str) -> bool:
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


class Status:
    """One line that says how it goes, on terminals only."""

    def __init__(self, server: "Server") -> None:
        self._server = server
        self._live = Live(console=console, auto_refresh=False, transient=True) if console.is_terminal else None
        self._next = 0.0

    def __enter__(self) -> "Status":
        if self._live is not None:
            self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._live is not None:
            self._live.stop()

    def show(self) -> None:
        """Bring the line up to date, from time to time."""
        now = time.perf_counter()
        if self._live is None or now < self._next:
            return
        self._next = now + STATUS_S
        self._live.update(status_line(self._server), refresh=True)


def status_line(server: "Server") -> Text:
    """Return simulated time, pace and clients."""
    figures = server.statistics()
    clients, count = server.clients, len(server.uris)
    factor = figures.recent_real_time_factor
    wanted = server.speed
    is_slow = wanted is not None and factor < 0.95 * wanted and figures.wall_seconds > 1.0
    return Text.assemble(
        f"{server.world.time:.1f} s, ",
        (f"{factor:.2f} x real time", "yellow" if is_slow else ""),
        f", {clients} of {count} drones with a client",
    )


def summary(figures: "Statistics") -> Text:
    """Return the last line: how it went."""
    counts = figures.drones.values()
    lines = [
        f"{figures.sim_seconds:.1f} s served in {figures.wall_seconds:.1f} s "
        f"({figures.real_time_factor:.2f} x real time), {100.0 * figures.cpu_share:.0f} % of a core",
        f"{sum(c.sessions for c in counts)} sessions, {sum(c.taken for c in counts)} packets taken, "
        f"{sum(c.replied for c in counts)} replies; {sum(c.sent for c in counts)} packets of log data and the like "
        f"sent, {sum(c.dropped for c in counts)} dropped",
    ]
    text = Text("\n".join(lines))
    refused = sum(c.refused + c.rate_limited + c.malformed for c in counts)
    if refused:
        text.append(f"\n{refused} datagrams refused: of other clients, too many, or no packets")
    if figures.resyncs:
        text.append(
            f"\nReal time was not kept: {figures.dropped_lag_s:.1f} s given up in {figures.resyncs} steps, "
            f"{figures.worst_lag_s:.2f} s behind at worst",
            style="yellow",
        )
    if errors := sum(c.errors for c in counts):
        text.append(f"\n{errors} packets met a defect of this program; the first of each kind was printed", style="red")
    return text
