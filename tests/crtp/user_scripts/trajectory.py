"""Uploads a trajectory of polynomials, flies it, and lands."""

import sys
import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.mem import MemoryElement, Poly4D
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

# two halves of a circle that is no circle: x goes out and back, y swings
ZERO = [0.0] * 8
OUT = Poly4D(
    2.0,
    x=Poly4D.Poly([0, 0, 0, 0.625, -0.46875, 0.09375, 0, 0]),
    y=Poly4D.Poly([0, 0, 0, 0.375, -0.28125, 0.05625, 0, 0]),
    z=Poly4D.Poly(ZERO),
    yaw=Poly4D.Poly(ZERO),
)
BACK = Poly4D(
    2.0,
    x=Poly4D.Poly([0.5, 0, 0, -0.625, 0.46875, -0.09375, 0, 0]),
    y=Poly4D.Poly([0.3, 0, 0, -0.375, 0.28125, -0.05625, 0, 0]),
    z=Poly4D.Poly(ZERO),
    yaw=Poly4D.Poly(ZERO),
)

cflib.crtp.init_drivers()
with SyncCrazyflie(sys.argv[1], cf=Crazyflie(rw_cache=sys.argv[2])) as scf:
    memory = scf.cf.mem.get_mems(MemoryElement.TYPE_TRAJ)[0]
    memory.trajectory = [OUT, BACK]
    if not memory.write_data_sync():
        sys.exit("the upload failed")
    commander = scf.cf.high_level_commander
    commander.define_trajectory(1, 0, len(memory.trajectory))
    scf.cf.supervisor.send_arming_request(True)
    time.sleep(0.5)
    commander.takeoff(0.6, 1.5)
    time.sleep(2.0)
    commander.start_trajectory(1, 1.0, relative_position=True)
    time.sleep(4.5)
    commander.land(0.0, 1.5)
    time.sleep(2.0)
    commander.stop()
