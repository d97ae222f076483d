"""Goes from place to place with the commander of positions that plans on board."""

import sys
import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.positioning.position_hl_commander import PositionHlCommander

x0, y0 = float(sys.argv[3]), float(sys.argv[4])
cflib.crtp.init_drivers()
with SyncCrazyflie(sys.argv[1], cf=Crazyflie(rw_cache=sys.argv[2])) as scf:
    scf.cf.supervisor.send_arming_request(True)
    time.sleep(1.0)
    with PositionHlCommander(scf, x=x0, y=y0, z=0.0, default_height=0.5, default_velocity=0.4) as pc:
        pc.forward(0.5)
        pc.left(0.5)
        pc.go_to(x0, y0, 0.9)
        pc.go_to(x0, y0)
