"""How fast a swarm flies, by its size, beside the same world with a trivial thrust plugin.

    python benchmarks/swarm_scale.py --threads 1 2 --json scale.json
    python benchmarks/swarm_scale.py --drones 1 10 100 1000 --threads 2 --crazyflow ~/crazyflow/bin/python
    python benchmarks/swarm_scale.py --drones --pile 1000 300 --start 100

Full stack: Kalman filter, controller, commander, planner, parameters and logs, vehicle at 1 kHz, poses at 100 Hz, all
drones hovering in one world with contacts on and nothing to see. Each row is the median of several runs that alternate
with the trivial world and with crazyflow, so that a machine that slows down slows all.
"""

from __future__ import annotations

import argparse
import json
import platform
import statistics
import subprocess
import sys
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
PILE_SETTLES_S = 8.0  # [s]


def grid(count: int) -> list[tuple[float, float]]:
    """Return `count` places (m) on a square grid around the origin."""
    side = int(np.ceil(np.sqrt(count)))
    offset = (side - 1) * SPACING / 2
    return [(i % side * SPACING - offset, i // side * SPACING - offset) for i in range(count)]


def hovering_world(count: int, provider: str = "builtin", attributes: dict[str, str] | None = None) -> World:
    """Return a world in which all drones hover; `attributes` are of the engine plugin, for all of them."""
    drones = [
        DroneConfig(f"cf{i + 1}", place, provider=provider, attributes=attributes or {})
        for i, place in enumerate(grid(count))
    ]
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


class Crazyflow:
    """crazyflow with as many drones, in a process of its own; see peers/crazyflow_speed.py."""

    def __init__(self, python: str, count: int) -> None:
        script = Path(__file__).parent / "peers" / "crazyflow_speed.py"
        self._process = subprocess.Popen(
            [python, script, str(count)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        while (line := self._process.stdout.readline()) != "ready\n":
            if not line:
                raise SystemExit(f"{python} {script} {count} does not run: try it by hand")

    def fly(self, seconds: float) -> float:
        """Simulate, and return how long it took (s)."""
        self._process.stdin.write(f"{seconds}\n")
        self._process.stdin.flush()
        return float(self._process.stdout.readline())

    def close(self) -> None:
        """End the process."""
        self._process.stdin.close()
        self._process.wait()


def wall_seconds(action: Any) -> float:
    """Return how long an action takes (s)."""
    start = time.perf_counter()
    action()
    return time.perf_counter() - start


def cpu_seconds(action: Any) -> float:
    """Return how long the calling thread computes for an action (s), whatever others do on the machine."""
    start = time.thread_time()
    action()
    return time.thread_time() - start


def measure(
    count: int,
    threads: int,
    seconds: float,
    repeats: int,
    attributes: dict[str, str],
    crazyflow: str | None,
    is_busy: bool = False,
) -> dict[str, Any]:
    """Return one row of the table."""
    set_threads(threads)
    watch, typical = (cpu_seconds, min) if is_busy else (wall_seconds, statistics.median)
    world = hovering_world(count, attributes=attributes)
    peer = Crazyflow(crazyflow, count) if crazyflow else None
    model, data = trivial_world(count, world.model.opt.disableflags)
    ticks = max(1, round(seconds * 1000))

    full, trivial, flow = [], [], []
    for _ in range(repeats):
        full.append(watch(lambda: world.step(ticks)))
        trivial.append(watch(lambda: mujoco.mj_step(model, data, nstep=ticks)))
        if peer:
            flow.append(peer.fly(seconds))
    if peer:
        peer.close()

    # timing the parts costs a little, so it is done apart from the rows above, and with one part after the other:
    # World.step lets the ticks of several threads run beside the physics
    lib.cf_plugin_timing(1)
    timed = watch(lambda: mujoco.mj_step(world.model, world.data, nstep=ticks))
    spent = np.zeros(2, np.uint64)
    lib.cf_plugin_timing_read(_uint64_pointer(spent))
    lib.cf_plugin_timing(0)

    per_step = 1e6 / (ticks * count)
    wall = typical(full)
    onboard, vehicle = (float(value) * 1e-9 * per_step for value in spent)
    return {
        "drones": count,
        "threads": threads,
        "drone_seconds_per_second": count * seconds / wall,
        "real_time_factor": seconds / wall,
        "us_per_drone_step": wall * per_step,
        # the parts are timed by the clock on the wall
        "us_physics": None if is_busy else timed * per_step - (onboard + vehicle) / threads,
        "us_onboard": None if is_busy else onboard,
        "us_vehicle": None if is_busy else vehicle,
        "bytes_per_drone": lib.cf_state_bytes(0),
        "trivial_drone_seconds_per_second": count * seconds / typical(trivial),
        "crazyflow_drone_seconds_per_second": count * seconds / statistics.median(flow) if flow else None,
    }


def measure_pile(
    count: int,
    crashed: int,
    seconds: float,
    repeats: int,
    attributes: dict[str, str],
    is_busy: bool = False,
) -> dict[str, Any]:
    """Return what it costs that some of a swarm lie crashed in one pile, on one thread."""
    watch, typical = (cpu_seconds, min) if is_busy else (wall_seconds, statistics.median)
    set_threads(1)
    flying, piled = (hovering_world(count, attributes=attributes) for _ in range(2))
    side = max(1, round((crashed / 5) ** 0.5))
    for i, drone in enumerate(piled.drones[count - crashed :]):
        drone.emergency_stop()
        column, row, layer = i % side, i // side % side, i // side**2
        drone.place((50 + 0.1 * column, 50 + 0.1 * row, 0.1 + 0.06 * layer), yaw_deg=37.0 * i % 360)
    settling = watch(lambda: piled.run(PILE_SETTLES_S))
    ticks = max(1, round(seconds * 1000))
    whole, part = [], []
    for _ in range(repeats):
        whole.append(watch(lambda: flying.step(ticks)))
        part.append(watch(lambda: piled.step(ticks)))
    return {
        "drones": count,
        "crashed": crashed,
        "held": sum(bool(drone.struct.rest.is_held) for drone in piled.drones),
        "real_time_factor_flying": seconds / typical(whole),
        "real_time_factor_piled": seconds / typical(part),
        "real_time_factor_while_falling": PILE_SETTLES_S / settling,
        "loss": 1 - typical(whole) / typical(part),
    }


START = """
import sys
from crazychoir_fw.simulation import DroneConfig, World

def resident():
    return int(next(line for line in open("/proc/self/status") if line.startswith("VmRSS")).split()[1])

before = resident()
count, side = int(sys.argv[1]), int(int(sys.argv[1]) ** 0.5) + 1
world = World([DroneConfig(f"cf{i}", (i % side * 0.5, i // side * 0.5)) for i in range(count)], visuals=False)
world.step(1)
print((resident() - before) / count)
"""


def measure_start(count: int, repeats: int) -> dict[str, Any]:
    """Return the time from the start of a process to its first tick, and what a drone adds to its memory."""
    seconds, kibibytes = [], []
    for _ in range(repeats):
        start = time.perf_counter()
        run = subprocess.run([sys.executable, "-c", START, str(count)], check=True, capture_output=True, text=True)
        seconds.append(time.perf_counter() - start)
        kibibytes.append(float(run.stdout))
    return {
        "drones": count,
        "start_s": statistics.median(seconds),
        "resident_kib_per_drone": statistics.median(kibibytes),
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
    parser.add_argument("--drones", type=int, nargs="*", default=[1, 10, 30, 100, 300, 1000, 3000])
    parser.add_argument("--threads", type=int, nargs="+", default=[1])
    parser.add_argument("--seconds", type=float, default=1.0, help="simulated seconds per run")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument(
        "--busy",
        action="store_true",
        help="for a machine with other work: the least processor time of one thread instead of the median by the clock",
    )
    parser.add_argument("--attribute", action="append", default=[], metavar="NAME=VALUE", help="of all drones")
    parser.add_argument("--crazyflow", metavar="PYTHON", help="interpreter of an environment with crazyflow")
    parser.add_argument("--pile", type=int, nargs=2, metavar=("DRONES", "CRASHED"), help="some lie in a heap")
    parser.add_argument("--start", type=int, metavar="DRONES", help="time from process start to first tick")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    if arguments.busy and arguments.threads != [1]:
        parser.error("--busy measures one thread")
    attributes = dict(item.split("=", 1) for item in arguments.attribute)

    header = (
        "drones",
        "threads",
        "drone-s/s",
        "real time",
        "us/step",
        "physics",
        "onboard",
        "vehicle",
        "trivial",
        "crazyflow",
    )
    print(" ".join(f"{name:>10}" for name in header))
    rows = []
    for threads in arguments.threads:
        for count in arguments.drones:
            row = measure(
                count, threads, arguments.seconds, arguments.repeats, attributes, arguments.crazyflow, arguments.busy
            )
            rows.append(row)
            values = [value for key, value in row.items() if key != "bytes_per_drone"]
            print(" ".join(f"{'-' if value is None else format(value, '.4g'):>10}" for value in values), flush=True)
    result: dict[str, Any] = {"machine": machine(), "attributes": attributes, "rows": rows}
    growth(rows, result)
    print(f"{lib.cf_state_bytes(0)} bytes per drone")
    if arguments.pile:
        result["pile"] = measure_pile(*arguments.pile, arguments.seconds, arguments.repeats, attributes, arguments.busy)
        print(", ".join(f"{name} {value:.4g}" for name, value in result["pile"].items()))
    if arguments.start:
        result["start"] = measure_start(arguments.start, arguments.repeats)
        print(", ".join(f"{name} {value:.4g}" for name, value in result["start"].items()))
    if arguments.json:
        arguments.json.write_text(json.dumps(result, indent=2) + "\n")


def growth(rows: list[dict[str, Any]], result: dict[str, Any]) -> None:
    """Note how much more a drone costs among 1000 than among 30, for each number of threads."""
    cost = {(row["threads"], row["drones"]): row["us_per_drone_step"] for row in rows}
    result["growth"] = {
        threads: cost[threads, 1000] / cost[threads, 30]
        for threads in sorted({row["threads"] for row in rows})
        if (threads, 30) in cost and (threads, 1000) in cost
    }
    for threads, factor in result["growth"].items():
        print(f"growth from 30 to 1000 drones on {threads} threads: {factor:.3f}")


if __name__ == "__main__":
    main()
