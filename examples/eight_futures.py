"""At a decision, try eight futures and keep the best.

    python examples/eight_futures.py

A drone is to fly to a gate and be near it soon. With a timid position controller it is late, with an eager one it
overshoots. It asks eight copies of its world, which fly in two threads, and follows the advice of the best.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from crazychoir_fw.simulation import DroneConfig, World

GATE = (1.0, 0.5, 0.6)
GAINS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0)  # of the onboard position controller [1/s]


def mean_distance(world: World, gain: float) -> float:
    """Fly to the gate in a world, and return how far from it the drone was on the average (m)."""
    drone = world["scout"]
    drone.param["posCtlPid.xKp"] = drone.param["posCtlPid.yKp"] = gain
    drone.high_level_commander.go_to(*GATE, yaw=0.0, duration_s=0.5)
    distances = []
    for _ in range(200):
        world.run(0.02)
        distances.append(np.linalg.norm(drone.true_position - GATE))
    return float(np.mean(distances))


def main() -> None:
    """Fly to a point of decision, try eight ways on, and go the best one."""
    world = World([DroneConfig("scout")], seed=3)
    world.wait_until_ready()
    world["scout"].high_level_commander.takeoff(absolute_height_m=0.5, duration_s=1.5)
    world.run(2.0)

    with ThreadPoolExecutor(max_workers=2) as pool:
        distances = list(pool.map(mean_distance, world.fork(len(GAINS)), GAINS))
    for gain, distance in zip(GAINS, distances, strict=True):
        print(f"gain {gain}: {100 * distance:.1f} cm from the gate on the average")

    best = int(np.argmin(distances))
    came_true = mean_distance(world, GAINS[best])
    print(f"the best is {GAINS[best]}, which came true with {100 * came_true:.1f} cm")
    assert came_true == distances[best]


if __name__ == "__main__":
    main()
