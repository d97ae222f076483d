"""Logs until the link is lost; prints when packets came, and what they said about the time."""

import json
import os
import sys
import threading
import time

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

cflib.crtp.init_drivers()
scf = SyncCrazyflie(sys.argv[1], cf=Crazyflie(rw_cache=sys.argv[2]))
scf.open_link()
lost, heard, said = threading.Event(), [], []
scf.cf.connection_lost.add_callback(lambda uri, message: (said.append(message), lost.set()))
block = LogConfig("place", 10)
block.add_variable("stateEstimate.z", "float")
scf.cf.log.add_config(block)
block.data_received_cb.add_callback(lambda stamp, *_: heard.append((time.perf_counter(), stamp)))
block.start()
while len(heard) < 20:
    time.sleep(0.01)
print("logging", flush=True)
is_lost = lost.wait(100)
print(json.dumps({"is_lost": is_lost, "said": said, "heard": heard}), flush=True)
os._exit(0)  # closing a link that is lost is not what is tried here
