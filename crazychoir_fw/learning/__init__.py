"""Learning on the real stack: environments in which the onboard software flies, and policies that end as firmware apps.

`Flights` is the engine, on NumPy alone; `environments` has it as Gymnasium's and PettingZoo's; `policy` turns a network
into C. Where Gymnasium is installed, importing this package registers ``crazychoir/Hover-v0`` and the others.
"""

from importlib.util import find_spec

from crazychoir_fw.learning.action import Attitude, Motors, Residual, ThrustRates, Velocity
from crazychoir_fw.learning.flights import Flights
from crazychoir_fw.learning.observation import BLOCKS, Observation
from crazychoir_fw.learning.onboard_camera import OnboardCamera
from crazychoir_fw.learning.tasks import Gates, Hover, Recover, Swap, Swarm, SwarmTask, Task, Track

__all__ = [
    "BLOCKS",
    "Attitude",
    "Flights",
    "Gates",
    "Hover",
    "Motors",
    "Observation",
    "OnboardCamera",
    "Recover",
    "Residual",
    "Swap",
    "Swarm",
    "SwarmTask",
    "Task",
    "ThrustRates",
    "Track",
    "Velocity",
]

if find_spec("gymnasium") is not None:
    from crazychoir_fw.learning.registration import register

    register()
