"""Connects the same object again and again, and logs each time."""

import itertools
import sys

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.crazyflie.syncLogger import SyncLogger

cflib.crtp.init_drivers()
cf = Crazyflie(rw_cache=sys.argv[2])
for _ in range(10):
    with SyncCrazyflie(sys.argv[1], cf=cf) as scf:
        block = LogConfig("SysTest", 10)
        block.add_variable("pm.vbat", "float")
        with SyncLogger(scf, block) as logger:
            print(*(f"{entry[1]['pm.vbat']:.2f}" for entry in itertools.islice(logger, 5)))
