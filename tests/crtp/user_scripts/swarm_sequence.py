"""Ten drones take off together, change places by a step to the side, and land."""

import sys
import time

import cflib.crtp
from cflib.crazyflie.swarm import CachedCfFactory, Swarm


def arm(scf):
    scf.cf.supervisor.send_arming_request(True)
    time.sleep(0.5)


def fly(scf):
    commander = scf.cf.high_level_commander
    commander.takeoff(0.5, 1.5)
    time.sleep(2.0)
    commander.go_to(0.3, 0.0, 0.3, 0.0, 1.5, relative=True)
    time.sleep(2.0)
    commander.land(0.0, 2.0)
    time.sleep(2.5)
    commander.stop()


cflib.crtp.init_drivers()
with Swarm(sys.argv[2:], factory=CachedCfFactory(rw_cache=sys.argv[1])) as swarm:
    for uri, position in swarm.get_estimated_positions().items():
        print(uri, *(f"{value:.3f}" for value in position))
    swarm.parallel_safe(arm)
    swarm.parallel_safe(fly)
