"""What the effects of the plant cost: a hovering swarm with each of them on, beside one with all of them off.

    python benchmarks/plant_cost.py --drones 100 1000 --json plant_cost.json

Drones hover on a grid in two layers, the upper one 0.5 m above the lower one and beside it, so that everybody is near
the floor and has neighbors. Variants alternate, so that a machine that slows down slows all of them; ratios are to be
trusted, seconds are not.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

from swarm_scale import grid

from crazychoir_fw.simulation import DroneConfig, World, set_threads

OFF = {"ground_effect.enabled": False, "downwash.enabled": False}
VARIANTS: dict[str, dict[str, Any]] = {
    "off": OFF,
    "ground effect": {**OFF, "ground_effect.enabled": True},
    "downwash": {**OFF, "downwash.enabled": True},
    "both (default)": {},
    "both, warm motors": {"rotors.heat_loss": 0.15},
    "both, steady wind": {"wind.velocity": (0.5, 0.0, 0.0)},
    "both, indoor turbulence": {"wind.turbulence": "indoor"},
    "both, dryden": {"wind.velocity": (0.5, 0.0, 0.0), "wind.turbulence": "dryden"},
}
HEIGHTS = (0.5, 1.0)  # [m]


def hovering(count: int, vehicle: dict[str, Any]) -> World:
    """Return a swarm in the air."""
    world = World([DroneConfig(f"cf{i + 1}", p, vehicle=vehicle) for i, p in enumerate(grid(count))], visuals=False)
    world.wait_until_ready()
    for i, drone in enumerate(world.drones):
        drone.high_level_commander.takeoff(HEIGHTS[i % 2], 1.5)
    world.run(2.0)
    return world


def microseconds(world: World, ticks: int) -> float:
    """Return the cost of a drone and tick (µs), physics included."""
    start = time.process_time()
    world.step(ticks)
    return (time.process_time() - start) / ticks / len(world.drones) * 1e6


def measure(count: int, variants: list[str], repeats: int, ticks: int) -> dict[str, Any]:
    """Return one row: least CPU time (µs) of each variant, and its ratio to `off`."""
    worlds = {name: hovering(count, VARIANTS[name]) for name in dict.fromkeys(["off", *variants])}
    times: dict[str, list[float]] = {name: [] for name in worlds}
    for _ in range(repeats):
        for name, world in worlds.items():
            times[name].append(microseconds(world, ticks))
    least = {name: min(values) for name, values in times.items()}
    ratios = {name: value / least["off"] for name, value in least.items()}
    return {"drones": count, "us": least, "ratio": ratios}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drones", type=int, nargs="+", default=[100, 1000])
    parser.add_argument("--variants", nargs="+", default=list(VARIANTS), choices=VARIANTS)
    parser.add_argument("--repeats", type=int, default=40)
    parser.add_argument("--ticks", type=int, default=50, help="timed at a time, a multiple of 5")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()

    set_threads(1)
    rows = []
    for count in arguments.drones:
        rows.append(measure(count, arguments.variants, arguments.repeats, arguments.ticks))
        print(f"{count} drones")
        for name, ratio in rows[-1]["ratio"].items():
            print(f"  {name:26s} {rows[-1]['us'][name]:6.3f} us per drone and tick  {(ratio - 1) * 100:+5.1f} %")
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=2))


if __name__ == "__main__":
    main()
