"""Flies a square of 0.6 m with position setpoints, sent 20 times a second."""

import sys
import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

x0, y0 = float(sys.argv[3]), float(sys.argv[4])
CORNERS = [(0.0, 0.0), (0.6, 0.0), (0.6, 0.6), (0.0, 0.6), (0.0, 0.0)]


def stay(commander, x, y, z, seconds):
    end = time.time() + seconds
    while time.time() < end:
        commander.send_position_setpoint(x, y, z, 0)
        time.sleep(0.05)


cflib.crtp.init_drivers()
with SyncCrazyflie(sys.argv[1], cf=Crazyflie(rw_cache=sys.argv[2])) as scf:
    scf.cf.supervisor.send_arming_request(True)
    commander = scf.cf.commander
    stay(commander, x0, y0, 0.4, 2.0)
    for x, y in CORNERS:
        stay(commander, x0 + x, y0 + y, 0.6, 2.0)
    stay(commander, x0, y0, 0.05, 1.5)
    commander.send_stop_setpoint()
    commander.send_notify_setpoint_stop()
