"""Flies hop.c, an app with a task of its own, on a checkout of the firmware: see README.md."""

from pathlib import Path

from crazychoir_fw.simulation import DroneConfig, World

APP = Path(__file__).with_name("hop.c")
SECONDS = 16.0

world = World([DroneConfig("cf1", (0.0, 0.0), provider="bitcraze:all", app=APP)], seed=1)
drone = world["cf1"]
drone.param["hop.height"] = 0.7
highest = 0.0
for _ in range(int(2 * SECONDS)):
    world.run(0.5)
    x, y, z = drone.true_position
    highest = max(highest, z)
    print(
        f"{world.time:5.1f} s  {x:5.2f} {y:5.2f} {z:5.2f} m  corner {drone.log['hop.corner']}  {drone.supervisor_state}"
    )
print(drone.console)
print(f"highest {highest:.2f} m, back at {drone.true_position[0]:.2f}, {drone.true_position[1]:.2f} m")
