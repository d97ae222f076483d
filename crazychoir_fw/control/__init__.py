"""Control laws above the onboard software: from pose and reference to a command. Plain NumPy, no clock, no ROS."""

from crazychoir_fw.control.attitude_control import GeometryAttitudeCtrl
from crazychoir_fw.control.controller import CrazyflieController, LastReference, ReferenceHandler
from crazychoir_fw.control.gains import (
    ATTITUDE_GAINS,
    POSITION_GAINS,
    VELOCITY_GAINS,
    AttitudeGains,
    PositionGains,
    VelocityGains,
)
from crazychoir_fw.control.hierarchical import HierarchicalController, SafeHierarchicalController
from crazychoir_fw.control.position import FlatnessAccelerationCtrl, FlatnessCtrl, FlatnessPositionCtrl
from crazychoir_fw.control.safe_position import SafeFlatnessAccelerationCtrl, SafeFlatnessCtrl, SafeFlatnessPositionCtrl
from crazychoir_fw.control.senders import FPQRSender, FRPYSender, SenderStrategy, VelSender
from crazychoir_fw.control.strategies import (
    AttitudeControl,
    AttitudeCtrlStrategy,
    PositionControl,
    PositionCtrlStrategy,
)
from crazychoir_fw.control.velocity import VelocityController, VelocityCtrlStrategy

__all__ = [
    "ATTITUDE_GAINS",
    "POSITION_GAINS",
    "VELOCITY_GAINS",
    "AttitudeControl",
    "AttitudeCtrlStrategy",
    "AttitudeGains",
    "CrazyflieController",
    "FPQRSender",
    "FRPYSender",
    "FlatnessAccelerationCtrl",
    "FlatnessCtrl",
    "FlatnessPositionCtrl",
    "GeometryAttitudeCtrl",
    "HierarchicalController",
    "LastReference",
    "PositionControl",
    "PositionCtrlStrategy",
    "PositionGains",
    "ReferenceHandler",
    "SafeFlatnessAccelerationCtrl",
    "SafeFlatnessCtrl",
    "SafeFlatnessPositionCtrl",
    "SafeHierarchicalController",
    "SenderStrategy",
    "VelSender",
    "VelocityController",
    "VelocityCtrlStrategy",
    "VelocityGains",
]
