"""Asks the multi-ranger what is around."""

import sys
import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.utils.multiranger import Multiranger

cflib.crtp.init_drivers()
with SyncCrazyflie(sys.argv[1], cf=Crazyflie(rw_cache=sys.argv[2])) as scf, Multiranger(scf) as ranger:
    patience = time.monotonic() + 30.0
    while ranger.front is None and time.monotonic() < patience:
        time.sleep(0.1)
    print(ranger.front, ranger.back, ranger.left, ranger.right, ranger.up)
