"""Safety filters: they change commands as little as possible, so that no drone comes too near another.

They work in the horizontal plane, whatever the heights are; z passes through (docs/reference/crazychoir.md#9).
"""

from crazychoir_fw.control.safety.barrier_filter import BarrierFilter
from crazychoir_fw.control.safety.collision_avoidance import (
    CollisionAvoidance,
    DoubleIntegratorCollisionAvoidance,
    SingleIntegratorCollisionAvoidance,
    UnicycleCollisionAvoidance,
)
from crazychoir_fw.control.safety.double_integrator import DoubleIntegratorCBF
from crazychoir_fw.control.safety.neighbor_sensing import ClosestRobotGetter, stacked
from crazychoir_fw.control.safety.single_integrator import SingleIntegratorCBF

__all__ = [
    "BarrierFilter",
    "ClosestRobotGetter",
    "CollisionAvoidance",
    "DoubleIntegratorCBF",
    "DoubleIntegratorCollisionAvoidance",
    "SingleIntegratorCBF",
    "SingleIntegratorCollisionAvoidance",
    "UnicycleCollisionAvoidance",
    "stacked",
]
