"""What looking costs: microseconds per drone and tick with ranging decks and scenery, beside drones without.

    python benchmarks/looking_cost.py --drones 1 100 --json looking.json

Hovering drones at 1 kHz, full stack, time of the process in one thread. Rows alternate, and each is the median of
several runs from the same snapshot, so that a machine that slows down slows all.
"""

from __future__ import annotations

import argparse
import json
import statistics
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from swarm_scale import grid

from crazychoir_fw.simulation import DroneConfig, World, set_threads

TICKS = 1000
ROOM = "room"
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "nothing": ("arena", {}),
    "floor, z-ranger": ("arena", {"decks": ["zranger"]}),
    "floor, multi-ranger": ("arena", {"decks": ["multiranger"]}),
    "room, nothing": (ROOM, {}),
    "room, both": (ROOM, {"decks": ["multiranger", "zranger"]}),
    "floor, flow deck": ("arena", {"positioning": "flow"}),
    "room, flow deck": (ROOM, {"positioning": "flow"}),
}


def thirty_boxes(folder: Path) -> str:
    """Return a scene with 30 boxes around and above the swarm, so that nobody hits them."""
    angles = np.linspace(0, 2 * np.pi, 30, endpoint=False)
    boxes = "".join(
        f'<geom type="box" size="0.3 0.3 2" pos="{9 * np.cos(a):.3f} {9 * np.sin(a):.3f} 2"/>' for a in angles
    )
    path = folder / "boxes.xml"
    path.write_text(
        '<mujoco><option timestep="0.001"/><worldbody><geom type="plane" size="0 0 1"/>'
        + boxes
        + "</worldbody></mujoco>"
    )
    return str(path)


def hovering(count: int, scene: str, options: dict[str, Any]) -> World:
    """Return a world in which all drones hover."""
    world = World(
        [DroneConfig(f"cf{i}", place, **options) for i, place in enumerate(grid(count))], scene, seed=1, visuals=False
    )
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(1.0, 1.5)
    world.run(2.5)
    return world


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drones", type=int, nargs="+", default=[1, 100])
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    set_threads(1)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        boxes = thirty_boxes(Path(folder))
        for count in options.drones:
            worlds = {
                name: hovering(count, boxes if scene == ROOM else scene, settings)
                for name, (scene, settings) in CASES.items()
            }
            snapshots = {name: world.snapshot() for name, world in worlds.items()}
            runs: dict[str, list[float]] = {name: [] for name in worlds}
            for _ in range(options.repeats):
                for name, world in worlds.items():
                    world.restore(snapshots[name])
                    start = time.process_time()
                    world.step(TICKS)
                    runs[name].append(time.process_time() - start)
            for name, seconds in runs.items():
                cost = statistics.median(seconds) / (TICKS * count) * 1e6
                rows.append({"drones": count, "case": name, "us_per_drone_tick": cost})
                print(f"{count:5} drones  {name:22} {cost:.3f} µs per drone and tick")
    if options.json:
        options.json.write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
