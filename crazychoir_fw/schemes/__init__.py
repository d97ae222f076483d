"""Guidance that optimizes: each scheme combines distributed optimization with guidance, one file each."""

from crazychoir_fw.schemes.aggregative import (
    AggregativeGuidance,
    AggregativeGuidanceCrazyflie,
    AggregativeGuidanceCrazyflieMovingIntruder,
)
from crazychoir_fw.schemes.delivery import DeliveryGuidance, DeliveryTable
from crazychoir_fw.schemes.mpc import MPCGuidance
from crazychoir_fw.schemes.mpc_problem import MPCProblem
from crazychoir_fw.schemes.tasks import PositionTaskTable, TaskGuidance

__all__ = [
    "AggregativeGuidance",
    "AggregativeGuidanceCrazyflie",
    "AggregativeGuidanceCrazyflieMovingIntruder",
    "DeliveryGuidance",
    "DeliveryTable",
    "MPCGuidance",
    "MPCProblem",
    "PositionTaskTable",
    "TaskGuidance",
]
