"""Two drones, one handler: take off, change places along a half circle each, land.

Simulated drones: start `crazychoir serve --count 2` in another terminal, then run this file.
Real ones: python two_drones.py radio://0/80/2M/E7E7E7E701 radio://0/80/2M/E7E7E7E702
"""

import math
import sys
import time

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.radio import RadioHandlerVel, SafetyArea

URIS = sys.argv[1:] or ["udp://127.0.0.1:19850", "udp://127.0.0.1:19851"]
SPEED, SECONDS = 0.3, 5.2  # half circles of 1 m, as far as the drones of `serve` stand from each other

try:
    swarm = RadioHandlerVel(URIS, odometry_hz=20, safety_area=SafetyArea((-3, -3, 0), (3, 3, 2))).connect()
except CrazychoirError as error:
    sys.exit(f"{error}\nFor simulated drones, start this first: crazychoir serve --count 2")

with swarm:
    swarm.on_event = lambda agent, kind, text: print(f"{agent}: {kind}: {text}")
    swarm.takeoff(0.6, duration=2.0)
    time.sleep(2.2)
    began = time.monotonic()
    while (t := time.monotonic() - began) < SECONDS:
        angle = math.pi * t / SECONDS
        for sign, drone in zip((1, -1), swarm, strict=True):
            drone.command(sign * SPEED * math.sin(angle), sign * SPEED * math.cos(angle), 0.0)
        time.sleep(0.05)
    for drone in swarm:
        print(f"{drone.agent_id} ends its half circle at", drone.position.round(2))
# leaving the with statement lands them and closes the links
