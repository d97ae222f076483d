"""Stores a parameter on the drone, asks for its state, and forgets it again."""

import sys
import threading

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

NAME = sys.argv[3]


def ask(question, *arguments):
    answered, answers = threading.Event(), []

    def hear(*answer):
        answers.extend(answer)
        answered.set()

    question(*arguments, hear)
    if not answered.wait(5):
        sys.exit(f"no answer about {NAME}")
    return answers[-1]


cflib.crtp.init_drivers()
with SyncCrazyflie(sys.argv[1], cf=Crazyflie(rw_cache=sys.argv[2])) as scf:
    scf.wait_for_params()
    param = scf.cf.param
    print("before", ask(param.persistent_get_state, NAME))
    param.set_value(NAME, sys.argv[4])
    print("store", ask(param.persistent_store, NAME))
    print("stored", ask(param.persistent_get_state, NAME))
    print("clear", ask(param.persistent_clear, NAME))
    print("after", ask(param.persistent_get_state, NAME))
