"""Endurance: ten served drones, all flown by cflib, with a log on disk: memory and latency over time.

    python benchmarks/endurance_served.py --hours 1               an hour in real time
    python benchmarks/endurance_served.py --hours 24 --speed 0 --no-log --period-ms 2000    a day

The drones hang on supplies of constant voltage instead of their batteries, and each flies a square at a height of its
own through the high-level commander. Prints once per `--every` seconds of wall time: wall time (s), simulated time (s),
memory of the server (resident, MB), size of the stream (MB), simulated over wall time, median and worst gap between
two log packets of one drone (ms of wall time), log packets that are missing, logs that were begun again (a drone that
hears nothing for a second deletes its log blocks; a client on a busy machine may stand still as long), drones that
fly, the largest distance between a drone and its corner (m), and median and worst round trip of a parameter request
(ms).
"""

import argparse
import itertools
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cflib.crtp
import numpy as np
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.swarm import CachedCfFactory, Swarm
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

COUNT = 10
PARAMETER = "stabilizer.controller"
CORNERS = ((0.0, 0.0), (0.3, 0.0), (0.3, 0.3), (0.0, 0.3))  # m, from the drone's start
STAMP_S = 2**24 / 1e3  # the time stamps of log packets have 24 bits, and wrap every 4.7 hours
SILENCE_S = 5.0  # wall time without log packets after which their block is begun again
FLIGHT_S, REST_S = 2.0, 2.0  # simulated time to a corner, and there
_COMMAND = "from crazychoir_fw.cli import app; app()"
_HEADINGS = "wall simulated memory stream speed gap worst missing again flying error trip max"
_MISSION = """
seed: 1
drones:
""" + "".join(
    f"  - {{id: cf{index}, position: [{index % 5}, {index // 5}, 0], vehicle: {{battery.constant_voltage: 3.9}}}}\n"
    for index in range(COUNT)
)
_MISSION += "flight:\n  - hover: {duration: 1.0}\n"  # missions have phases, though served ones do not fly them


def resident_mb(process: int) -> float:
    """Return the memory that a process has (MB)."""
    status = Path(f"/proc/{process}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", status)[1]) / 1e3


class Flight:
    """One drone: flies its square by simulated time, and notes its log packets."""

    def __init__(self, link: Crazyflie, index: int, period_ms: int) -> None:
        self.link, self.period_s = link, period_ms / 1e3
        self.start, self.height = (float(index % 5), float(index // 5)), 0.4 + 0.1 * index
        self.corners = itertools.cycle(CORNERS)
        self.corner: tuple[float, float] | None = None
        self.packets: list[tuple[float, float]] = []  # wall and simulated time (s)
        self.trips: list[float] = []  # s
        self.asked: float | None = None
        self.wraps = 0
        self.missing, self.due, self.error, self.pose = 0, 0.0, 0.0, (0.0, 0.0, 0.0)
        link.param.add_update_callback(*PARAMETER.split("."), cb=self.answered)
        link.supervisor.send_arming_request(True)
        time.sleep(0.2)
        link.high_level_commander.takeoff(self.height, 2.0)
        self.begin_log()

    def begin_log(self) -> None:
        """Ask the drone for its place, again if it has deleted the block."""
        self.begun = time.monotonic()
        block = LogConfig("pose", period_in_ms=round(1e3 * self.period_s))
        for axis in "xyz":
            block.add_variable(f"stateEstimate.{axis}", "float")
        block.data_received_cb.add_callback(self.received)
        self.link.log.add_config(block)
        block.start()

    def received(self, stamp: int, data: dict[str, float], _: LogConfig) -> None:
        """Note a log packet; at each corner, fly on."""
        now = stamp / 1e3 + self.wraps * STAMP_S
        if self.packets and now < self.packets[-1][1] - STAMP_S / 2:
            self.wraps, now = self.wraps + 1, now + STAMP_S
        if self.packets:
            self.missing += max(0, round((now - self.packets[-1][1]) / self.period_s) - 1)
        self.packets.append((time.monotonic(), now))
        self.pose = tuple(data.values())
        if self.due == 0.0:
            self.due = now + FLIGHT_S + REST_S
        if now < self.due:
            return
        if self.corner:
            goal = (self.start[0] + self.corner[0], self.start[1] + self.corner[1], self.height)
            self.error = max(self.error, float(np.linalg.norm(np.subtract(self.pose, goal))))
        self.due, self.corner = now + FLIGHT_S + REST_S, next(self.corners)
        x, y = np.add(self.start, self.corner)
        self.link.high_level_commander.go_to(float(x), float(y), self.height, 0.0, FLIGHT_S)

    def ask(self) -> None:
        """Ask for a parameter, to measure the round trip."""
        self.asked = time.monotonic()
        self.link.param.request_param_update(PARAMETER)

    def answered(self, _name: str, _value: str) -> None:
        """Note the round trip."""
        if self.asked is not None:
            self.trips.append(time.monotonic() - self.asked)
            self.asked = None

    def look(self) -> dict[str, float]:
        """Return what was noted since the last look."""
        again = time.monotonic() - max(self.begun, self.packets[-1][0] if self.packets else 0.0) > SILENCE_S
        if again:
            self.begin_log()
        packets, self.packets = self.packets[:-1], self.packets[-1:]
        gaps = 1e3 * np.diff([wall for wall, _ in packets]) if len(packets) > 1 else np.zeros(1)
        seen = {
            "gap": float(np.median(gaps)),
            "worst": float(gaps.max()),
            "missing": self.missing,
            "again": again,
            "error": self.error,
        }
        seen |= {"error": self.error, "flying": self.pose[2] > 0.3}
        self.missing, self.error = 0, 0.0
        return seen | {"now": self.packets[-1][1] if self.packets else 0.0}


def watch(server: subprocess.Popen, folder: Path, arguments: argparse.Namespace) -> None:
    """Fly all drones and print a line now and then."""
    flights: list[Flight] = []
    stream = folder / "log.stream"

    def begin_flight(link: SyncCrazyflie) -> None:
        flights.append(Flight(link.cf, int(link._link_uri.rsplit(":")[-1]) - arguments.port, arguments.period_ms))

    uris = [f"udp://127.0.0.1:{arguments.port + index}" for index in range(COUNT)]
    with tempfile.TemporaryDirectory() as cache, Swarm(uris, factory=CachedCfFactory(rw_cache=cache)) as swarm:
        swarm.sequential(begin_flight)
        print("".join(f"{heading:>10}" for heading in _HEADINGS.split()), flush=True)
        begin = last = time.monotonic()
        simulated = 0.0
        while simulated < 3600 * arguments.hours and server.poll() is None:
            for _ in range(int(2 * arguments.every)):
                flights[0].ask()
                time.sleep(0.5)
            looks = [flight.look() for flight in flights]
            now, before = time.monotonic(), simulated
            simulated = max(seen["now"] for seen in looks)
            trips, flights[0].trips = 1e3 * np.array(flights[0].trips or [np.nan]), []
            figures = (
                now - begin,
                simulated,
                resident_mb(server.pid),
                stream.stat().st_size / 1e6 if stream.exists() else 0.0,
                (simulated - before) / (now - last),
                np.median([seen["gap"] for seen in looks]),
                max(seen["worst"] for seen in looks),
                sum(seen["missing"] for seen in looks),
                sum(seen["again"] for seen in looks),
                sum(seen["flying"] for seen in looks),
                max(seen["error"] for seen in looks),
                np.median(trips),
                trips.max(),
            )
            last = now
            print("".join(f"{figure:10.2f}" for figure in figures), flush=True)


def main() -> None:
    """Serve, watch, stop."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--speed", type=float, default=1.0, help="simulated seconds per second, 0 is without limit")
    parser.add_argument("--hours", type=float, default=0.01, help="simulated time")
    parser.add_argument("--every", type=float, default=10.0, help="seconds of wall time between two lines")
    parser.add_argument("--period-ms", type=int, default=100, help="period of the log blocks (ms of simulated time)")
    parser.add_argument("--port", type=int, default=19950, help="of the first drone")
    parser.add_argument("--no-log", action="store_true", help="keep no log: 3 MB per simulated second")
    arguments = parser.parse_args()
    cflib.crtp.init_drivers()
    with tempfile.TemporaryDirectory() as scratch:
        folder, mission = Path(scratch) / "out", Path(scratch) / "ten.yaml"
        mission.write_text(_MISSION)
        serve = [
            "serve",
            str(mission),
            "--port",
            str(arguments.port),
            "--speed",
            str(arguments.speed),
            "--wait-for",
            str(COUNT),
        ]
        if not arguments.no_log:
            serve += ["--out", str(folder)]
        told = Path(scratch) / "told.txt"
        with told.open("w") as file, subprocess.Popen([sys.executable, "-c", _COMMAND, *serve], stdout=file) as server:
            try:
                while "udp://" not in told.read_text():
                    if server.poll() is not None:
                        sys.exit("the server ended before the first client")
                    time.sleep(0.2)
                watch(server, folder, arguments)
            finally:
                server.kill()


if __name__ == "__main__":
    main()
