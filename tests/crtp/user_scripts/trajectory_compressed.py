"""Uploads a compressed trajectory, flies it, and lands."""

import sys
import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.high_level_commander import HighLevelCommander
from cflib.crazyflie.mem import CompressedSegment, CompressedStart, MemoryElement
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

x, y = float(sys.argv[3]), float(sys.argv[4])
START = CompressedStart(x, y, 0.6, 0.0)
OUT = CompressedSegment(2.0, [x, x + 0.5, x + 0.5], [y, y + 0.3, y + 0.3], [], [])
BACK = CompressedSegment(2.0, [x + 0.5, x, x], [y + 0.3, y, y], [], [])

cflib.crtp.init_drivers()
with SyncCrazyflie(sys.argv[1], cf=Crazyflie(rw_cache=sys.argv[2])) as scf:
    memory = scf.cf.mem.get_mems(MemoryElement.TYPE_TRAJ)[0]
    memory.trajectory = [START, OUT, BACK]
    if not memory.write_data_sync():
        sys.exit("the upload failed")
    commander = scf.cf.high_level_commander
    commander.define_trajectory(1, 0, 2, type=HighLevelCommander.TRAJECTORY_TYPE_POLY4D_COMPRESSED)
    scf.cf.supervisor.send_arming_request(True)
    time.sleep(0.5)
    commander.takeoff(0.6, 1.5)
    time.sleep(2.0)
    commander.start_trajectory(1)
    time.sleep(4.5)
    commander.land(0.0, 1.5)
    time.sleep(2.0)
    commander.stop()
