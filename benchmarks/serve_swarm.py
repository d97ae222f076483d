"""What it takes to serve a swarm to the real cflib: one server process, one client process, real sockets.

    python benchmarks/serve_swarm.py --drones 30 --seconds 60 --json serve.json

A `Swarm` connects to all drones at once without a cache, another one with an empty cache, a third with that cache; all
fetch all parameters.
Then every drone has two log blocks of five values at 100 Hz, and hovers on position set-points at 50 Hz. A log packet
is lost where the time stamps of its block have a gap.

The same is measured with a server that sends tables of contents item by item as they are asked for, and, to tell what
is the client's share, with a responder that runs no simulation and looks every reply up in a table; the processor time
of the client until it is connected tells it as well. `--clients 2` shares the drones among two client processes.

Figures depend on what else the machine does; its load stands beside them.
"""

from __future__ import annotations

import argparse
import json
import logging
import os
import selectors
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

LOGGED = {
    "place": ("stateEstimate.x", "stateEstimate.y", "stateEstimate.z", "stateEstimate.vx", "stateEstimate.vy"),
    "attitude": ("stabilizer.roll", "stabilizer.pitch", "stabilizer.yaw", "stabilizer.thrust", "pm.vbat"),
}
LOG_PERIOD_MS = 10
SETPOINT_PERIOD_S = 0.02
HEIGHT = 0.5
PATIENCE_S = 120.0

# ---------------------------------------------------------------- the server, in a process of its own


def serve(drones: int, reads_ahead: bool = True) -> None:
    """Serve a grid of drones; print URIs, and figures since the last line whenever a line comes."""
    from crazychoir_fw.flight.backends import build_world
    from crazychoir_fw.mission import parse_mission

    grid = {"name": "served", "drones": {"count": drones, "spacing": 1.0}, "flight": [{"hover": {"duration": 1.0}}]}
    world = build_world(parse_mission(grid, source="--drones"), None, visuals=False)
    world.wait_until_ready()
    with world.serve(port=0, reads_ahead=reads_ahead) as server:
        tell(uris=list(server.uris.values()))
        marks: list[str] = []

        def listen() -> None:
            marks.extend(sys.stdin)  # one by one, as they come
            server.stop()

        threading.Thread(target=listen, daemon=True).start()
        since = (time.perf_counter(), time.process_time(), world.time)

        def observe(_: Any) -> None:
            nonlocal since
            if not marks:
                return
            marks.clear()
            now = (time.perf_counter(), time.process_time(), world.time)
            wall, processor, simulated = (b - a for a, b in zip(since, now, strict=True))
            figures = server.statistics()
            counts = figures.drones.values()
            tell(
                cpu_share=processor / wall,
                real_time_factor=simulated / wall,
                worst_lag_ms=figures.worst_lag_s * 1e3,
                given_up_s=figures.dropped_lag_s,
                taken=sum(count.taken for count in counts),
                sent=sum(count.sent for count in counts),
                dropped=sum(count.dropped for count in counts),
                flying=sum(drone.is_flying for drone in world.drones),
            )
            server._pace.worst_lag_s = 0.0
            since = now

        server.run(None, observe, 0.05)


def respond(drones: int) -> None:
    """Answer as drones do, from a table, with no simulation behind it."""
    from crazychoir_fw.crtp.sockets import open_sockets
    from crazychoir_fw.crtp.station import Station
    from crazychoir_fw.simulation import DroneConfig, World

    world = World([DroneConfig("cf1")], visuals=False)
    station = Station(world, world["cf1"])
    selector = selectors.DefaultSelector()
    sockets = open_sockets("127.0.0.1", 0, drones)
    for opened in sockets:
        selector.register(opened, selectors.EVENT_READ)
    tell(uris=[f"udp://127.0.0.1:{opened.getsockname()[1]}" for opened in sockets])
    known: dict[bytes, list[bytes]] = {}
    while True:
        for key, _ in selector.select():
            datagram, address = key.fileobj.recvfrom(64)
            replies = known.get(datagram)
            if replies is None:
                replies = station.receive(datagram)
                if datagram[0] & 0xF3 != 0xF0:  # echoes never come twice
                    known[datagram] = replies
            for reply in replies:
                key.fileobj.sendto(reply, address)


# ---------------------------------------------------------------- the client, in a process of its own


class Listener:
    """What comes of one log block."""

    def __init__(self) -> None:
        self.packets = self.lost = 0
        self.latest: dict[str, float] = {}
        self.earliest_s = float("inf")
        self.late_s = 0.0
        self._stamp: int | None = None

    def hear(self, stamp: int, values: dict[str, float], block: Any) -> None:
        age = time.perf_counter() - stamp / 1000  # against an unknown zero
        self.earliest_s = min(self.earliest_s, age)
        self.late_s = max(self.late_s, age - self.earliest_s)
        if self._stamp is not None:
            self.lost += (stamp - self._stamp) // LOG_PERIOD_MS - 1
        self._stamp = stamp
        self.packets += 1
        self.latest = values


def connect(uris: list[str], cache: str) -> tuple[Any, dict[str, float]]:
    """Connect to all at once, and wait for all parameters; `cache` is a folder, or "" for none."""
    import cflib.crtp
    from cflib.crazyflie.swarm import CachedCfFactory, Swarm

    logging.disable(logging.WARNING)  # that there is no cache
    cflib.crtp.init_drivers()
    swarm = Swarm(uris, factory=CachedCfFactory(rw_cache=cache)) if cache else Swarm(uris)
    began, processor = time.perf_counter(), time.process_time()
    swarm.open_links()
    connected, processor_connected = time.perf_counter(), time.process_time()
    swarm.parallel_safe(lambda scf: scf.wait_for_params())
    fetched = time.perf_counter()
    return swarm, {
        "connected_s": connected - began,
        "connected_processor_s": processor_connected - processor,
        "parameters_s": fetched - began,
        "client_cpu_share": (time.process_time() - processor) / (fetched - began),
    }


def start_blocks(swarm: Any) -> dict[tuple[str, str], Listener]:
    """Start both blocks of every drone."""
    from cflib.crazyflie.log import LogConfig

    listeners = {}
    for uri, scf in swarm._cfs.items():
        for name, variables in LOGGED.items():
            block = LogConfig(name, LOG_PERIOD_MS)
            for variable in variables:
                block.add_variable(variable, "float")
            listener = listeners[uri, name] = Listener()
            scf.cf.log.add_config(block)
            block.data_received_cb.add_callback(listener.hear)
            block.start()
    return listeners


def fly(swarm: Any, seconds: float) -> dict[str, float]:
    """Hover, and listen; a line is printed when it begins and when it ends, for the server's figures."""
    listeners = start_blocks(swarm)
    deadline = time.perf_counter() + PATIENCE_S
    while not all(listener.latest for listener in listeners.values()) and time.perf_counter() < deadline:
        time.sleep(0.05)
    places = {uri: listeners[uri, "place"].latest for uri in swarm._cfs}
    for scf in swarm._cfs.values():
        scf.cf.supervisor.send_arming_request(True)
    time.sleep(0.5)
    tell(phase="begin")
    sent, late = 0, 0.0
    before = sum(listener.packets for listener in listeners.values())
    began, processor = time.perf_counter(), time.process_time()
    due = began
    while due < began + seconds:
        for uri, scf in swarm._cfs.items():
            place = places[uri]
            scf.cf.commander.send_position_setpoint(place["stateEstimate.x"], place["stateEstimate.y"], HEIGHT, 0.0)
            sent += 1
        due += SETPOINT_PERIOD_S
        late = max(late, time.perf_counter() - due)
        time.sleep(max(0.0, due - time.perf_counter()))
    wall = time.perf_counter() - began
    tell(phase="end")
    packets = sum(listener.packets for listener in listeners.values())
    return {
        "seconds": wall,
        "log_packets": packets,
        "log_packets_per_s": (packets - before) / wall,
        "log_packets_lost": sum(listener.lost for listener in listeners.values()),
        "log_packet_late_ms": max(listener.late_s for listener in listeners.values()) * 1e3,
        "set_points_per_s": sent / wall,
        "set_point_late_ms": late * 1e3,
        "client_cpu_share": (time.process_time() - processor) / wall,
        "lowest_m": min(listeners[uri, "place"].latest["stateEstimate.z"] for uri in swarm._cfs),
    }


def be_client(uris: list[str], cache: str, seconds: float) -> None:
    """Connect, fly for so long, print figures."""
    swarm, figures = connect(uris, cache)
    if seconds > 0.0:
        tell(phase="connected")
        figures["flight"] = fly(swarm, seconds)
    tell(**figures)
    os._exit(0)  # closing the links of a swarm takes cflib a second each


# ---------------------------------------------------------------- both


def tell(**what: Any) -> None:
    print(json.dumps(what), flush=True)


def run_client(uris: list[str], cache: str, seconds: float, mark: Any = lambda: {}) -> dict[str, Any]:
    """Run a client process; `mark` returns the server's figures since it was called last."""
    words = [sys.executable, __file__, "--be-client", cache, "--seconds", str(seconds), "--uris", *uris]
    of_server: dict[str, Any] = {}
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as client:
        for line in client.stdout:
            if not line.startswith("{"):
                continue
            figures = json.loads(line)
            if "phase" in figures:
                of_server = mark()
        if client.wait():
            raise SystemExit("the client failed")
    figures.get("flight", figures)["server"] = of_server or mark()
    return figures


def run_clients(uris: list[str], cache: str, count: int, mark: Any) -> dict[str, Any]:
    """Connect from so many processes at once. Returns the worst of each figure, processor time of all together."""
    size = -(-len(uris) // count)
    with ThreadPoolExecutor(count) as pool:
        parts = [uris[first : first + size] for first in range(0, len(uris), size)]
        results = list(pool.map(lambda part: run_client(part, cache, 0.0), parts))
    worst = {name: max(result[name] for result in results) for name in results[0] if name != "server"}
    worst["connected_processor_s"] = sum(result["connected_processor_s"] for result in results)
    return {**worst, "server": mark()}


@contextmanager
def process_of(mode: str, drones: int) -> Iterator[tuple[list[str], Any]]:
    """Run a server or a responder. Yields its URIs, and what asks for its figures."""
    words = [sys.executable, __file__, mode, "--drones", str(drones)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:

        def mark() -> dict[str, Any]:
            process.stdin.write("\n")
            process.stdin.flush()
            return json.loads(process.stdout.readline())

        try:
            yield json.loads(process.stdout.readline())["uris"], mark
        finally:
            process.terminate()


def measure(drones: int, seconds: float, repeats: int, clients: int) -> dict[str, Any]:
    """Measure everything; connecting so many times, against servers and a responder in turns."""
    result: dict[str, Any] = {"drones": drones, "clients": clients}
    servers = (("", "--serve"), ("_as_asked", "--serve-as-asked"), ("_responder", "--respond"))
    for _ in range(repeats):
        for ending, mode in servers:
            # one at a time: each flies its drones meanwhile
            with process_of(mode, drones) as (uris, mark), tempfile.TemporaryDirectory() as folder:
                ask = dict if mode == "--respond" else mark
                for kind, cache in (("uncached", ""), ("cold", folder), ("warm", folder)):
                    ask()
                    figures = run_clients(uris, cache, clients, ask)
                    figures["load"] = os.getloadavg()[0]
                    result.setdefault(kind + ending, []).append(figures)
                    show(kind + ending, figures)
                    time.sleep(1.2)  # until the drones are free again
    if seconds > 0.0:
        with process_of("--serve", drones) as (uris, mark), tempfile.TemporaryDirectory() as cache:
            figures = run_client(uris, cache, seconds, mark)["flight"]
            figures["load"] = os.getloadavg()[0]
            result["flight"] = figures
            show("flight", figures)
    return result


def show(title: str, figures: dict[str, Any]) -> None:
    words = [f"{name} {value:.4g}" for name, value in figures.items() if isinstance(value, (int, float))]
    print(f"{title}: {', '.join(words)}")
    if figures.get("server"):
        print("   server:", ", ".join(f"{name} {value:.4g}" for name, value in figures["server"].items()))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drones", type=int, default=30)
    parser.add_argument("--seconds", type=float, default=60.0, help="of flight; 0 only connects")
    parser.add_argument("--repeats", type=int, default=3, help="of connecting")
    parser.add_argument("--clients", type=int, default=1, help="processes that connect")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--serve-as-asked", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--respond", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--be-client", metavar="CACHE", help=argparse.SUPPRESS)
    parser.add_argument("--uris", nargs="*", default=[], help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        serve(options.drones)
    elif options.serve_as_asked:
        serve(options.drones, reads_ahead=False)
    elif options.respond:
        respond(options.drones)
    elif options.be_client is not None:
        be_client(options.uris, options.be_client, options.seconds)
    else:
        result = measure(options.drones, options.seconds, options.repeats, options.clients)
        if options.json:
            options.json.write_text(json.dumps(result, indent=2) + "\n")


if __name__ == "__main__":
    main()
