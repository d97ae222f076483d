"""What programs in Python that fly their drones cost a swarm, beside the same swarm flown by its planners.

    python benchmarks/motor_ctrl_cost.py --drones 100 --rate 100 --seconds 2

One thread; processor time, so that a machine with other work tells the same. Runs alternate, so that one that slows
down slows all.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from pathlib import Path

import numpy as np

from crazychoir_fw.simulation import DroneConfig, MotorCtrl, MotorCtrlFPQR, MotorCtrlVel, World, set_threads

SPACING = 0.5  # [m]


class Idle(MotorCtrl):
    """Does nothing: the price of being asked."""


class Hold(MotorCtrlVel):
    """Gives its command anew every step, and reads nothing but the time."""

    def step(self) -> None:
        self.command(0.0, 0.0, 0.4 if self.time < 4.0 else 0.0)


class Hover(MotorCtrlFPQR):
    """A small control law: reads height, velocity and attitude, commands thrust and rates."""

    def step(self) -> None:
        up = self.weight + 0.1 * (1.0 - self.position[2]) - 0.08 * self.velocity[2]
        roll, pitch, _ = self.roll_pitch_yaw
        self.command(up, -4.0 * roll, -4.0 * pitch, 0.0)


def hovering(count: int, cls: type[MotorCtrl] | None, rate: int) -> World:
    """Return a world of drones about 1 m up, flown by a class, or by their planners."""
    side = int(np.ceil(np.sqrt(count)))
    own = None if cls is None else type(cls.__name__, (cls,), {"rate_hz": rate})
    places = [(i % side * SPACING, i // side * SPACING) for i in range(count)]
    world = World([DroneConfig(f"cf{i + 1}", place, motor_ctrl=own) for i, place in enumerate(places)], visuals=False)
    world.wait_until_ready()
    if cls in (None, Idle):
        for drone in world.drones:
            drone.high_level_commander.takeoff(1.0, 1.5)
    world.run(2.5)
    return world


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drones", type=int, default=100)
    parser.add_argument("--rate", type=int, default=100, help="steps of each class per second")
    parser.add_argument("--seconds", type=float, default=1.0, help="simulated seconds per run")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()

    set_threads(1)
    kinds = {"planner": None, "idle": Idle, "hold": Hold, "hover": Hover}
    worlds = {name: hovering(arguments.drones, cls, arguments.rate) for name, cls in kinds.items()}
    spent: dict[str, list[float]] = {name: [] for name in kinds}
    for _ in range(arguments.repeats):
        for name, world in worlds.items():
            begin = time.process_time()
            world.run(arguments.seconds)
            spent[name].append(time.process_time() - begin)

    steps = arguments.drones * arguments.rate * arguments.seconds
    base = statistics.median(spent["planner"])
    rows = []
    for name, walls in spent.items():
        wall = statistics.median(walls)
        factor = arguments.seconds / wall
        rows.append({"flown_by": name, "real_time_factor": factor, "us_per_step": 1e6 * (wall - base) / steps})
        print(f"{name:>8} {factor:8.2f} x real time, {rows[-1]['us_per_step']:6.1f} us more per step of a drone")
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
