"""Takes off, flies forward, left and back, turns, and lands, with the motion commander."""

import sys
import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.positioning.motion_commander import MotionCommander

cflib.crtp.init_drivers()
with SyncCrazyflie(sys.argv[1], cf=Crazyflie(rw_cache=sys.argv[2])) as scf:
    scf.cf.supervisor.send_arming_request(True)
    time.sleep(1.0)
    with MotionCommander(scf, default_height=0.5) as mc:
        time.sleep(1)
        mc.forward(0.6)
        mc.left(0.4)
        mc.turn_right(90)
        mc.back(0.3)
        time.sleep(1)
