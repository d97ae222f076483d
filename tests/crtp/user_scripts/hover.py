"""Rises to 0.5 m with hover setpoints, stays there, comes down."""

import sys
import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

cflib.crtp.init_drivers()
with SyncCrazyflie(sys.argv[1], cf=Crazyflie(rw_cache=sys.argv[2])) as scf:
    cf = scf.cf
    cf.supervisor.send_arming_request(True)
    time.sleep(0.5)
    for step in range(20):
        cf.commander.send_hover_setpoint(0, 0, 0, 0.5 * step / 20)
        time.sleep(0.1)
    for _ in range(30):
        cf.commander.send_hover_setpoint(0, 0, 0, 0.5)
        time.sleep(0.1)
    for step in range(20):
        cf.commander.send_hover_setpoint(0, 0, 0, 0.5 * (20 - step) / 20)
        time.sleep(0.1)
    cf.commander.send_stop_setpoint()
    cf.commander.send_notify_setpoint_stop()
