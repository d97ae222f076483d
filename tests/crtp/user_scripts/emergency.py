"""Takes off and stops the motors in the air; then nothing can be armed any more."""

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
    cf.high_level_commander.takeoff(0.4, 1.0)
    time.sleep(2.0)
    print("flying", cf.supervisor.is_flying)
    cf.loc.send_emergency_stop()
    time.sleep(1.0)
    print("locked", cf.supervisor.is_locked)
    cf.supervisor.send_arming_request(True)
    time.sleep(0.5)
    print("can fly", cf.supervisor.can_fly)
