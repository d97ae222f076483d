"""Lets the motors run up and down on the floor: the first script that comes with cflib."""

import sys
import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

seen = []
cflib.crtp.init_drivers()
with SyncCrazyflie(sys.argv[1], cf=Crazyflie(rw_cache=sys.argv[2])) as scf:
    motors = LogConfig("motors", 20)
    motors.add_variable("motor.m1")
    scf.cf.log.add_config(motors)
    motors.data_received_cb.add_callback(lambda stamp, values, block: seen.append(values["motor.m1"]))
    motors.start()
    scf.cf.supervisor.send_arming_request(True)
    time.sleep(0.5)
    scf.cf.commander.send_setpoint(0, 0, 0, 0)  # unlocks the thrust
    for thrust in [*range(10000, 20000, 500), *range(20000, 10000, -500)]:
        scf.cf.commander.send_setpoint(0, 0, 0, thrust)
        time.sleep(0.05)
    scf.cf.commander.send_setpoint(0, 0, 0, 0)
    time.sleep(0.2)
    motors.stop()
print(max(seen), seen[-1])
