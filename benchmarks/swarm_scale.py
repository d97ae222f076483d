"""How fast a swarm flies, by its size, beside the same world with a trivial thrust plugin.

    python benchmarks/swarm_scale.py --drones 1 10 100 --threads 1 --seconds 2 --json scale.json

Full stack: Kalman filter, controller, commander, planner, parameters and logs, vehicle at 1 kHz, poses at 100 Hz, all
drones hovering in one world with contacts on and nothing to see. Each row is the median of several runs that alternate
with the trivial world, so that a machine that slows down slows both.
"""

from __future__ import annotations

import argparse
import json
import platform
import statistics
import time
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from crazychoir_fw._core import lib
from crazychoir_fw.mujoco_models import model_path
from crazychoir_fw.mujoco_models.stamp import VehicleStamp
from crazychoir_fw.simulation import DroneConfig, World, set_threads

SPACING = 0.5  # [m] between neighbors on a grid
HEIGHT = 1.0  # [m]


def grid(count: int) -> list[tuple[float, float]]:
    """Return `count` places (m) on a square grid around the origin."""
    side = int(np.ceil(np.sqrt(count)))
    offset = (side - 1) * SPACING / 2
    return [(i % side * SPACING - offset, i // side * SPACING - offset) for i in range(count)]


def hovering_world(count: int, provider: str = "builtin") -> World:
    """Return a world in which all drones hover."""
    drones = [DroneConfig(f"cf{i + 1}", place, provider=provider) for i, place in enumerate(grid(count))]
    world = World(drones, seed=1, visuals=False)
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(HEIGHT, 1.5)
    world.run(2.5)
    crashed = [drone.id for drone in world.drones if not drone.is_flying]
    if crashed:
        raise SystemExit(f"not flying: {', '.join(crashed[:5])}: the benchmark would measure nothing")
    return world


def trivial_world(count: int, disableflags: int) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Return the same world, with the same options, whose drones are held up by a constant thrust."""
    spec = mujoco.MjSpec.from_file(str(model_path("arena")))
    spec.activate_plugin("crazychoir.thrust")
    stamp = VehicleStamp(spec, "cf2", visuals=False)
    for i, (x, y) in enumerate(grid(count)):
        body = stamp.place(f"cf{i + 1}", (x, y, HEIGHT))
        plugin = spec.add_plugin(name=f"thrust{i + 1}", plugin_name="crazychoir.thrust", active=True)
        plugin.config = {"thrust": repr(float(body.mass) * 9.81)}
        body.plugin = plugin
    model = spec.compile()
    model.opt.disableflags = disableflags
    return model, mujoco.MjData(model)


def wall_seconds(action: Any) -> float:
    """Return how long an action takes (s)."""
    start = time.perf_counter()
    action()
    return time.perf_counter() - start


def measure(count: int, threads: int, seconds: float, repeats: int) -> dict[str, Any]:
    """Return one row of the table."""
    set_threads(threads)
    world = hovering_world(count)
    model, data = trivial_world(count, world.model.opt.disableflags)
    ticks = max(1, round(seconds * 1000))

    full, trivial = [], []
    for _ in range(repeats):
        full.append(wall_seconds(lambda: world.step(ticks)))
        trivial.append(wall_seconds(lambda: mujoco.mj_step(model, data, nstep=ticks)))

    # timing the parts costs a little, so it is done apart from the rows above, and with one part after the other:
    # World.step lets the ticks of several threads run beside the physics
    lib.cf_plugin_timing(1)
    timed = wall_seconds(lambda: mujoco.mj_step(world.model, world.data, nstep=ticks))
    spent = np.zeros(2, np.uint64)
    lib.cf_plugin_timing_read(_uint64_pointer(spent))
    lib.cf_plugin_timing(0)

    per_step = 1e6 / (ticks * count)
    wall = statistics.median(full)
    onboard, vehicle = (float(value) * 1e-9 * per_step for value in spent)
    return {
        "drones": count,
        "threads": threads,
        "drone_seconds_per_second": count * seconds / wall,
        "real_time_factor": seconds / wall,
        "us_per_drone_step": wall * per_step,
        "us_physics": timed * per_step - (onboard + vehicle) / threads,
        "us_onboard": onboard,
        "us_vehicle": vehicle,
        "bytes_per_drone": lib.cf_state_bytes(0),
        "trivial_drone_seconds_per_second": count * seconds / statistics.median(trivial),
    }


def _uint64_pointer(array: np.ndarray) -> Any:
    from crazychoir_fw._core import ffi

    return ffi.cast("uint64_t *", array.ctypes.data)


def machine() -> dict[str, Any]:
    """Return what the figures depend on."""
    model = next(
        (line.split(":", 1)[1].strip() for line in _lines("/proc/cpuinfo") if line.startswith("model name")), "unknown"
    )
    return {
        "cpu": model,
        "system": platform.platform(),
        "python": platform.python_version(),
        "mujoco": mujoco.__version__,
    }


def _lines(path: str) -> list[str]:
    file = Path(path)
    return file.read_text().splitlines() if file.exists() else []


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drones", type=int, nargs="+", default=[1, 10, 30, 100, 300, 1000])
    parser.add_argument("--threads", type=int, nargs="+", default=[1])
    parser.add_argument("--seconds", type=float, default=1.0, help="simulated seconds per run")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()

    header = ("drones", "threads", "drone-s/s", "real time", "us/step", "physics", "onboard", "vehicle", "trivial")
    print(" ".join(f"{name:>10}" for name in header))
    rows = []
    for threads in arguments.threads:
        for count in arguments.drones:
            row = measure(count, threads, arguments.seconds, arguments.repeats)
            rows.append(row)
            values = [value for key, value in row.items() if key != "bytes_per_drone"]
            print(" ".join(f"{value:>10.4g}" for value in values), flush=True)
    print(f"{rows[0]['bytes_per_drone']} bytes per drone")
    if arguments.json:
        arguments.json.write_text(json.dumps({"machine": machine(), "rows": rows}, indent=2) + "\n")


if __name__ == "__main__":
    main()
