"""From points to references, by handlers."""

from crazychoir_fw.planning.handlers.forms import AccelerationTrajHandler, FullStateTrajHandler
from crazychoir_fw.planning.handlers.handler import TrajectoryHandler
from crazychoir_fw.planning.handlers.minimum_snap import MinimumSnap
from crazychoir_fw.planning.handlers.polynomial7th import Polynomial7th
from crazychoir_fw.planning.handlers.spline import Spline, SplinePosition

__all__ = [
    "AccelerationTrajHandler",
    "FullStateTrajHandler",
    "MinimumSnap",
    "Polynomial7th",
    "Spline",
    "SplinePosition",
    "TrajectoryHandler",
]
