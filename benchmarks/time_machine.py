"""What going back, branching, many episodes and MCAP files cost.

    python benchmarks/time_machine.py --drones 1 10 100 --json time_machine.json

Each figure is the median of several runs. Episodes and forks fly the same futures with 1 and with 2 threads in turns.
"""

from __future__ import annotations

import argparse
import json
import statistics
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from swarm_scale import hovering_world

from crazychoir_fw.recording.mcap_file import write_mcap
from crazychoir_fw.simulation import Episodes, FlightRecorder, World, set_threads


def seconds_of(call: Callable[[], Any]) -> float:
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def median_ms(call: Callable[[], Any], repeats: int) -> float:
    return 1e3 * statistics.median(seconds_of(call) for _ in range(repeats))


def going_back(drones: int, repeats: int) -> dict[str, float]:
    """Return what a snapshot, a restore and a fork cost (ms)."""
    world = hovering_world(drones)
    snapshot = world.snapshot()
    return {
        "drones": drones,
        "snapshot_ms": median_ms(world.snapshot, repeats),
        "restore_ms": median_ms(lambda: world.restore(snapshot), repeats),
        "fork_ms": median_ms(world.fork, repeats),
    }


def futures(count: int, drones: int, seconds: float, repeats: int) -> dict[str, float]:
    """Return how many drone-seconds per second many futures of a world make, in each way."""
    world = hovering_world(drones)
    work = count * drones * seconds

    def fork(threads: int) -> float:
        forks = world.fork(count)
        with ThreadPoolExecutor(threads) as pool:
            return seconds_of(lambda: list(pool.map(lambda fork: World.run(fork, seconds), forks)))

    def batch(threads: int) -> float:
        episodes = Episodes(world, count, threads)
        return seconds_of(lambda: episodes.run(seconds))

    spent: dict[str, list[float]] = {}
    for _ in range(repeats):
        for threads in (1, 2):
            spent.setdefault(f"forks_{threads}", []).append(fork(threads))
            spent.setdefault(f"batch_{threads}", []).append(batch(threads))
    rates = {name: work / statistics.median(times) for name, times in spent.items()}
    return {"futures": count, "drones": drones, **rates}


def mcap(drones: int, seconds: float, repeats: int) -> dict[str, float]:
    """Return size and time of an MCAP file, per drone-second, at 100 samples a second."""
    world = hovering_world(drones)
    recorder = FlightRecorder(world)
    recorder.run(seconds)
    log = recorder.finish()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.mcap"
        milliseconds = median_ms(lambda: write_mcap(log, path), repeats)
        size = path.stat().st_size
    amount = drones * seconds
    return {
        "drones": drones,
        "mcap_ms_per_drone_s": milliseconds / amount,
        "mcap_KiB_per_drone_s": size / 1024 / amount,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drones", type=int, nargs="+", default=[1, 10, 100])
    parser.add_argument("--futures", type=int, default=32)
    parser.add_argument("--seconds", type=float, default=2.0)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()

    set_threads(1)
    rows = [going_back(drones, options.repeats) for drones in options.drones]
    rows.append(futures(options.futures, 1, options.seconds, options.repeats))
    rows.append(mcap(min(10, max(options.drones)), options.seconds, options.repeats))
    for row in rows:
        print(", ".join(f"{name} {value:.3g}" for name, value in row.items()))
    if options.json:
        options.json.write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
