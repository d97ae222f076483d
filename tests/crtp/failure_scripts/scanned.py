"""Scans for drones, again and again, while it is connected to one of them."""

import itertools
import sys
import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.crtp import udpdriver

uri = sys.argv[1]
# the tests serve on any free ports, and not on those where scans look
udpdriver._BASE_PORT, udpdriver._NR_OF_PORTS_TO_SCAN = int(uri.rsplit(":", 1)[1]), 1
udpdriver._SCAN_TIMEOUT = 5.0  # in place of 0.1 s, for machines that have much else to do
cflib.crtp.init_drivers()
with SyncCrazyflie(uri, cf=Crazyflie(rw_cache=sys.argv[2])) as scf:
    stamps = []
    block = LogConfig("place", 10)
    block.add_variable("stateEstimate.z", "float")
    scf.cf.log.add_config(block)
    block.data_received_cb.add_callback(lambda stamp, *_: stamps.append(stamp))
    block.start()
    found = 0
    for _ in range(40):
        found += [uri, ""] in udpdriver.UdpDriver().scan_interface(None)
        time.sleep(0.05)
    block.stop()
    print(found, len(stamps), max(b - a for a, b in itertools.pairwise(stamps)))
