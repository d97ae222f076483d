"""How well each controller flies with each positioning system, on each airframe.

    python benchmarks/flight_matrix.py --markdown matrix.md --json matrix.json

Each combination hovers 1 m high and then flies the firmware's figure-8, 2 m by 1 m, from trajectory memory. The figures
are root mean squares (mm) of the distance between true position and setpoint: of the last seconds of hovering, and of
the whole figure-8. A combination that crashed or left the room says so instead.
"""

from __future__ import annotations

import argparse
import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.trajectory_files import read_pieces
from crazychoir_fw.onboard.core import choices
from crazychoir_fw.simulation import Drone, DroneConfig, World

PLATFORMS = ("cf2", "cf21bl")
CONTROLLERS = ("pid", "mellinger", "indi", "brescianini", "lee")
POSITIONING = ("mocap", "lighthouse", "loco_tdoa2", "flow")
FIGURE8 = Path(__file__).parents[1] / "examples" / "figure8.csv"

HEIGHT = 1.0  # [m]
SETTLING = 6.0  # [s], after take-off
PERIOD = 0.01  # [s] between two samples
ROOM = 3.0  # [m], farther from the setpoint a drone is lost


def distances(world: World, drone: Drone, seconds: float) -> NDArray[np.float64]:
    """Fly for a while; return the distances (m) between true position and setpoint, one per sample."""
    rows = []
    for _ in range(round(seconds / PERIOD)):
        world.run(PERIOD)
        target = [drone.log[f"ctrltarget.{axis}"] for axis in "xyz"]
        rows.append(np.linalg.norm(drone.true_position - target))
    return np.array(rows)


def rms_mm(rows: NDArray[np.float64], drone: Drone) -> float | None:
    """Return the root mean square in millimeters, or None when the drone was lost."""
    if not drone.is_flying or rows.max() > ROOM:
        return None
    return float(1000 * np.sqrt(np.mean(rows**2)))


def fly(platform: str, controller: str, positioning: str, seconds: float, seed: int) -> dict[str, Any]:
    """Fly one combination and return its row of the table."""
    config = DroneConfig("cf1", platform=platform, controller=controller, positioning=positioning)
    world = World([config], seed=seed, visuals=False)
    drone = world.drones[0]
    world.wait_until_ready(timeout_s=10)
    drone.high_level_commander.takeoff(HEIGHT, 2.0)
    world.run(2.0 + SETTLING)
    hover = rms_mm(distances(world, drone, seconds), drone)

    figure8 = None
    if hover is not None:
        duration = drone.high_level_commander.upload_trajectory(1, read_pieces(FIGURE8))
        drone.high_level_commander.start_trajectory(1, relative_position=True)
        figure8 = rms_mm(distances(world, drone, duration), drone)
    return {
        "platform": platform,
        "controller": controller,
        "positioning": positioning,
        "hover_mm": hover,
        "figure8_mm": figure8,
        "end": drone.supervisor_state,
    }


def markdown(rows: list[dict[str, Any]]) -> str:
    """Return the table, one line per airframe and controller: hover / figure-8 for each positioning system."""
    columns = list(dict.fromkeys(row["positioning"] for row in rows))
    lines = [
        "| airframe | controller | " + " | ".join(columns) + " |",
        "|---" * (2 + len(columns)) + "|",
    ]
    cells = {(row["platform"], row["controller"], row["positioning"]): _cell(row) for row in rows}
    for platform, controller in dict.fromkeys((row["platform"], row["controller"]) for row in rows):
        line = [cells[platform, controller, column] for column in columns]
        lines.append(f"| {platform} | {controller} | " + " | ".join(line) + " |")
    return "\n".join(lines) + "\n"


def _cell(row: dict[str, Any]) -> str:
    values = (row["hover_mm"], row["figure8_mm"])
    return " / ".join("lost" if value is None else f"{value:.0f}" for value in values)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--platforms", nargs="+", default=PLATFORMS, choices=PLATFORMS)
    parser.add_argument("--controllers", nargs="+", default=CONTROLLERS, choices=choices("controller"))
    parser.add_argument("--positioning", nargs="+", default=POSITIONING, choices=choices("positioning"))
    parser.add_argument("--seconds", type=float, default=5.0, help="of hovering that are judged")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--markdown", type=Path)
    options = parser.parse_args()

    rows = []
    for combination in itertools.product(options.platforms, options.controllers, options.positioning):
        row = fly(*combination, options.seconds, options.seed)
        rows.append(row)
        print(f"{' '.join(combination):40} hover / figure-8 [mm]: {_cell(row):12} {row['end']}", flush=True)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=2) + "\n")
    if options.markdown:
        options.markdown.write_text(markdown(rows))


if __name__ == "__main__":
    main()
