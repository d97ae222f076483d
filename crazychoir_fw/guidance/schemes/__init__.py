"""Guidance that optimizes: each scheme combines distributed optimization with guidance, one file each."""

from crazychoir_fw.guidance.schemes.aggregative import (
    AggregativeGuidance,
    AggregativeGuidanceCrazyflie,
    AggregativeGuidanceCrazyflieMovingIntruder,
)
from crazychoir_fw.guidance.schemes.delivery import DeliveryGuidance, DeliveryTable
from crazychoir_fw.guidance.schemes.mpc import MPCGuidance
from crazychoir_fw.guidance.schemes.mpc_problem import MPCProblem
from crazychoir_fw.guidance.schemes.tasks import PositionTaskTable, TaskGuidance

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
