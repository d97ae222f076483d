"""Logs a mixed block synchronously while the estimator is reset, and prints how many samples came."""

import itertools
import sys

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.crazyflie.syncLogger import SyncLogger
from cflib.utils.reset_estimator import reset_estimator

cflib.crtp.init_drivers()
with SyncCrazyflie(sys.argv[1], cf=Crazyflie(rw_cache=sys.argv[2])) as scf:
    reset_estimator(scf)
    block = LogConfig("mixed", 10)
    for name, kind in (
        ("stateEstimate.x", "float"),
        ("stateEstimate.y", "FP16"),
        ("pm.vbat", "float"),
        ("pm.vbatMV", "uint16_t"),
        ("supervisor.info", "uint16_t"),
        ("acc.z", "float"),
    ):
        block.add_variable(name, kind)
    with SyncLogger(scf, block) as logger:
        samples = list(itertools.islice(logger, 200))
stamps = [stamp for stamp, _, _ in samples]
print(len(stamps), stamps[-1] - stamps[0], max(b - a for a, b in itertools.pairwise(stamps)))
for name, value in samples[-1][1].items():
    print(name, round(float(value), 3))
