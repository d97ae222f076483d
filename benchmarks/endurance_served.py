"""Endurance: ten served drones, one of them flown by cflib, with a log on disk: memory and latency over time.

    python benchmarks/endurance_served.py --speed 1 --minutes 60    in real time
    python benchmarks/endurance_served.py --speed 0 --minutes 30    as fast as possible

Prints once per `--every` seconds of wall time: simulated time, memory of the server (resident, MB), size of the stream
(MB), and median and worst time between two log packets of a block of 100 ms
(ms of wall time).
"""

import argparse
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
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

PORT = 19950
_COMMAND = "from crazychoir_fw.cli import app; app()"


def resident_mb(process: int) -> float:
    """Return the memory that a process has (MB)."""
    status = Path(f"/proc/{process}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", status)[1]) / 1e3


def watch(server: subprocess.Popen, folder: Path, arguments: argparse.Namespace) -> None:
    """Fly one drone and print a line now and then."""
    stamps: list[tuple[float, float]] = []  # wall time and simulated time (s) of log packets
    block = LogConfig("pose", period_in_ms=100)
    block.add_variable("stateEstimate.z", "float")
    with SyncCrazyflie(f"udp://127.0.0.1:{PORT}", cf=Crazyflie()) as link:
        block.data_received_cb.add_callback(lambda stamp, data, _: stamps.append((time.monotonic(), stamp / 1e3)))
        link.cf.log.add_config(block)
        block.start()
        link.cf.supervisor.send_arming_request(True)
        time.sleep(1.0)
        print(
            f"{'wall (s)':>9} {'simulated (s)':>14} {'memory (MB)':>12} {'stream (MB)':>12} {'median':>8} {'worst':>8}"
        )
        begin = due = time.monotonic()
        while (now := time.monotonic()) - begin < 60 * arguments.minutes and server.poll() is None:
            link.cf.commander.send_hover_setpoint(0.0, 0.0, 0.0, 0.5)
            time.sleep(0.05)
            if now < due + arguments.every or not stamps:
                continue
            due, taken = now, np.array(stamps)
            stamps.clear()
            gaps = 1e3 * np.diff(taken[:, 0]) if len(taken) > 1 else np.zeros(1)
            size = (folder / "log.stream").stat().st_size / 1e6
            print(
                f"{now - begin:9.0f} {taken[-1, 1]:14.1f} {resident_mb(server.pid):12.1f} {size:12.1f} "
                f"{np.median(gaps):8.1f} {gaps.max():8.1f}",
                flush=True,
            )


def main() -> None:
    """Serve, watch, stop."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--speed", type=float, default=1.0)
    parser.add_argument("--minutes", type=float, default=1.0, help="wall time")
    parser.add_argument("--every", type=float, default=10.0, help="seconds of wall time between two lines")
    arguments = parser.parse_args()
    cflib.crtp.init_drivers()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "out"
        serve = ["serve", "--count", "10", "--port", str(PORT), "--speed", str(arguments.speed), "--out", str(folder)]
        with subprocess.Popen([sys.executable, "-c", _COMMAND, *serve], stdout=subprocess.DEVNULL) as server:
            try:
                while not (folder / "log.stream").exists() and server.poll() is None:
                    time.sleep(0.1)
                time.sleep(3.0)
                watch(server, folder, arguments)
            finally:
                server.kill()


if __name__ == "__main__":
    main()
