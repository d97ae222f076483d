"""References, curves, and handlers that turn points into references; knows neither ROS nor a clock."""

from crazychoir_fw.planning.curves import Polynomial, State, cubic_spline, minimum_snap, point_to_point, through_states
from crazychoir_fw.planning.handlers import (
    AccelerationTrajHandler,
    FullStateTrajHandler,
    MinimumSnap,
    Polynomial7th,
    Spline,
    SplinePosition,
    TrajectoryHandler,
)
from crazychoir_fw.planning.references import AccelerationTraj, FullStateTraj, PositionTraj, TrajHandlerStrategy
from crazychoir_fw.planning.trajectory import Trajectory

__all__ = [
    "AccelerationTraj",
    "AccelerationTrajHandler",
    "FullStateTraj",
    "FullStateTrajHandler",
    "MinimumSnap",
    "Polynomial",
    "Polynomial7th",
    "PositionTraj",
    "Spline",
    "SplinePosition",
    "State",
    "TrajHandlerStrategy",
    "Trajectory",
    "TrajectoryHandler",
    "cubic_spline",
    "minimum_snap",
    "point_to_point",
    "through_states",
]
