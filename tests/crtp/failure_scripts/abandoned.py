"""Flies forward on a stream of set-points until the test kills the process."""

import itertools
import sys
import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

cflib.crtp.init_drivers()
with SyncCrazyflie(sys.argv[1], cf=Crazyflie(rw_cache=sys.argv[2])) as scf:
    scf.cf.supervisor.send_arming_request(True)
    time.sleep(0.5)
    for count in itertools.count():
        scf.cf.commander.send_hover_setpoint(0.3, 0.0, 0.0, 0.5)
        time.sleep(0.02)
        if count == 150:
            print("flying", flush=True)
