"""Guidance that optimizes: each scheme combines distributed optimization with guidance, one file each."""

from crazychoir_fw.schemes.aggregative import (
    AggregativeGuidance,
    AggregativeGuidanceCrazyflie,
    AggregativeGuidanceCrazyflieMovingIntruder,
)

__all__ = [
    "AggregativeGuidance",
    "AggregativeGuidanceCrazyflie",
    "AggregativeGuidanceCrazyflieMovingIntruder",
]
