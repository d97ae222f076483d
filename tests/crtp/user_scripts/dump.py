"""Lists every parameter with its value and every log variable with its type; writes one parameter and reads it back."""

import sys
import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

cflib.crtp.init_drivers()
with SyncCrazyflie(sys.argv[1], cf=Crazyflie(rw_cache=sys.argv[2])) as scf:
    scf.wait_for_params()
    for group, names in scf.cf.param.toc.toc.items():
        for name, element in names.items():
            print("param", f"{group}.{name}", element.ctype, scf.cf.param.get_value(f"{group}.{name}"))
    for group, names in scf.cf.log.toc.toc.items():
        for name, element in names.items():
            print("log", f"{group}.{name}", element.ctype)
    scf.cf.param.set_value("pid_attitude.pitch_kd", 0.125)
    time.sleep(0.5)
    print("set", scf.cf.param.get_value("pid_attitude.pitch_kd"))
