"""Whether more threads ever harm: one and several, in turn, on a machine that has other work.

    python benchmarks/threads_under_load.py --load 2
    python benchmarks/threads_under_load.py --load 0 1 2 4 --drones 100 1000 --threads 2

The load are processes that compute without end. By the clock on the wall, in runs that alternate between one thread and
several; the ratio is the median over the pairs.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from swarm_scale import hovering_world, wall_seconds

from crazychoir_fw.simulation import World, set_threads


@contextmanager
def load(processes: int) -> Iterator[None]:
    """Keep as many processors busy."""
    started = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(processes)]
    try:
        yield
    finally:
        for process in started:
            process.kill()
            process.wait()


def pair(world: World, threads: int, ticks: int) -> tuple[float, float]:
    """Return how long (s) a stretch takes one thread, and several."""
    times = []
    for count in (1, threads):
        set_threads(count)
        times.append(wall_seconds(lambda: world.step(ticks)))
    return times[0], times[1]


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__.splitlines()[0], epilog=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--load", type=int, nargs="+", default=[0, 2], help="busy processes beside it (0 2)")
    parser.add_argument("--drones", type=int, nargs="+", default=[100], help="drones in the world (100)")
    parser.add_argument("--threads", type=int, default=2, help="threads beside one (2)")
    parser.add_argument("--work", type=float, default=300.0, help="drone-seconds of each run (300)")
    parser.add_argument("--pairs", type=int, default=9, help="pairs of runs (9)")
    parser.add_argument("--json", type=Path, help="file to write the pairs (s) to")
    arguments = parser.parse_args()
    rows = []
    for count in arguments.drones:
        world = hovering_world(count)
        ticks = max(1, round(1000 * arguments.work / count))
        for processes in arguments.load:
            with load(processes):
                pairs = [pair(world, arguments.threads, ticks) for _ in range(arguments.pairs)]
            one, several = (
                statistics.median(count * ticks / 1000 / t for t in times) for times in zip(*pairs, strict=True)
            )
            ratio = statistics.median(a / b for a, b in pairs)
            rows.append({"drones": count, "load": processes, "threads": arguments.threads, "pairs_s": pairs})
            worst = min(a / b for a, b in pairs)
            print(f"{count} drones beside {processes} busy processes, drone-s/s: {one:.0f} on one thread, ", end="")
            print(f"{several:.0f} on {arguments.threads}; ratio {ratio:.2f}, worst pair {worst:.2f}")
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
