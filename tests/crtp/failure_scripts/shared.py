"""Two clients want one drone."""

import itertools
import sys
import threading

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.crazyflie.syncLogger import SyncLogger


def log(scf):
    block = LogConfig("place", 10)
    block.add_variable("stateEstimate.z", "float")
    with SyncLogger(scf, block) as logger:
        stamps = [stamp for stamp, _, _ in itertools.islice(logger, 150)]
    return max(b - a for a, b in itertools.pairwise(stamps))


cflib.crtp.init_drivers()
first, second = (SyncCrazyflie(sys.argv[1], cf=Crazyflie(rw_cache=sys.argv[2])) for _ in range(2))
first.open_link()
is_open = threading.Event()
threading.Thread(target=lambda: (second.open_link(), is_open.set()), daemon=True).start()
print("first logs", log(first), "second is open", is_open.is_set())
first.close_link()
print("second is open", is_open.wait(30))
print("second logs", log(second))
second.close_link()
