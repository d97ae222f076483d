"""A drone that hovers for a day of simulated time: no drift of time, no growth of memory, no loss of lock.

    python benchmarks/endurance.py --hours 24 --json endurance.json

It hangs on a supply of constant voltage instead of its battery. Once in a simulated minute everything is looked at
that could go wrong in a day: counters that overflow, clocks that lose precision, estimates that drift, memory that
grows. 24 hours take about five minutes.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from pathlib import Path
from typing import Any

import numpy as np

from crazychoir_fw.simulation import DroneConfig, World

VOLTAGE = 3.9  # [V]
HEIGHT = 1.0  # [m]
LOOK_S = 60.0  # [s]


def resident_mib() -> float:
    """Return the memory of this process (MiB)."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def hovering_drone() -> World:
    """Return a world with one drone that hovers."""
    world = World([DroneConfig("cf1", attributes={"supply_voltage": VOLTAGE})], seed=1, visuals=False)
    world.wait_until_ready()
    world["cf1"].high_level_commander.takeoff(HEIGHT, 1.5)
    world.run(10.0 - world.time)
    return world


def look(world: World) -> dict[str, Any]:
    """Return what can be seen of the drone now."""
    drone = world["cf1"]
    return {
        "time_s": world.time,
        # MuJoCo adds up its time step by step, the drone counts
        "clock_error_s": world.time - drone.struct.onboard.tick / 1000,
        "position_error_m": float(np.linalg.norm(drone.true_position - (0.0, 0.0, HEIGHT))),
        "estimate_error_m": float(np.linalg.norm(drone.true_position - drone.estimated_position)),
        "yaw_error_deg": float(np.degrees(2 * abs(drone.true_quat_wxyz[3]))),
        "is_flying": drone.is_flying,
        "failure": drone.failure,
        "resident_mib": resident_mib(),
    }


def endure(hours: float, progress: bool = True) -> dict[str, Any]:
    """Hover, and return the worst of what was seen."""
    world = hovering_drone()
    start, rows = time.perf_counter(), [look(world)]
    end = world.time + hours * 3600
    while world.time < end - 1e-6:
        world.run(min(LOOK_S, end - world.time))
        rows.append(look(world))
        if not rows[-1]["is_flying"]:
            break
        if progress and len(rows) % 60 == 0:
            print(f"{world.time / 3600:6.2f} h, {rows[-1]['position_error_m'] * 1000:.1f} mm, "
                  f"{rows[-1]['resident_mib']:.1f} MiB", flush=True)  # fmt: skip
    wall = time.perf_counter() - start
    return {
        "hours": world.time / 3600,
        "real_time_factor": world.time / wall,
        "is_flying": rows[-1]["is_flying"],
        "failure": rows[-1]["failure"],
        "ticks": world["cf1"].struct.onboard.tick,
        **{
            f"worst_{name}": max(abs(row[name]) for row in rows)
            for name in ("clock_error_s", "position_error_m", "estimate_error_m", "yaw_error_deg")
        },
        # the first quarter may fill caches
        "memory_growth_mib": rows[-1]["resident_mib"] - rows[len(rows) // 4]["resident_mib"],
    }


def main() -> None:
    """Hover and print what was seen."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hours", type=float, default=24.0, help="simulated hours")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    result = endure(arguments.hours)
    for name, value in result.items():
        print(f"{name:24} {value:.6g}" if isinstance(value, float) else f"{name:24} {value}")
    if arguments.json:
        arguments.json.write_text(json.dumps(result, indent=2) + "\n")
    if not result["is_flying"]:
        raise SystemExit("the drone does not fly any more")


if __name__ == "__main__":
    main()
