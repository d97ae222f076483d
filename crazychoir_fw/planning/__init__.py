"""References, curves, and handlers that turn points into references; knows neither ROS nor a clock."""

from crazychoir_fw.planning.allocation import Allocation, allocate_times, trapezoidal_times
from crazychoir_fw.planning.curves import Polynomial, State, cubic_spline, minimum_snap, point_to_point, through_states
from crazychoir_fw.planning.drawn import Drawn, DrawnFit, fit_drawn, read_drawn, thinned
from crazychoir_fw.planning.export import OnboardCompressed, OnboardPieces, to_compressed, to_pieces
from crazychoir_fw.planning.handlers import (
    AccelerationTrajHandler,
    FullStateTrajHandler,
    MinimumSnap,
    Polynomial7th,
    Spline,
    SplinePosition,
    TrajectoryHandler,
)
from crazychoir_fw.planning.headings import FixedHeading, Heading, PathHeading
from crazychoir_fw.planning.limits import GENTLE, LimitReport, Limits, Load, check_limits
from crazychoir_fw.planning.references import AccelerationTraj, FullStateTraj, PositionTraj, TrajHandlerStrategy
from crazychoir_fw.planning.trajectory import Trajectory

__all__ = [
    "GENTLE",
    "AccelerationTraj",
    "AccelerationTrajHandler",
    "Allocation",
    "Drawn",
    "DrawnFit",
    "FixedHeading",
    "FullStateTraj",
    "FullStateTrajHandler",
    "Heading",
    "LimitReport",
    "Limits",
    "Load",
    "MinimumSnap",
    "OnboardCompressed",
    "OnboardPieces",
    "PathHeading",
    "Polynomial",
    "Polynomial7th",
    "PositionTraj",
    "Spline",
    "SplinePosition",
    "State",
    "TrajHandlerStrategy",
    "Trajectory",
    "TrajectoryHandler",
    "allocate_times",
    "check_limits",
    "cubic_spline",
    "fit_drawn",
    "minimum_snap",
    "point_to_point",
    "read_drawn",
    "thinned",
    "through_states",
    "to_compressed",
    "to_pieces",
    "trapezoidal_times",
]
