"""Recover from a throw: fast, tilted and turning, then come to rest at a point."""

from __future__ import annotations

from dataclasses import dataclass

from crazychoir_fw.learning.tasks.task import Task


@dataclass(frozen=True)
class Recover(Task):
    """Catch a thrown drone; rotors turn as in hover when it leaves the hand."""

    low: tuple[float, float, float] = (-5.0, -5.0, 0.15)
    high: tuple[float, float, float] = (5.0, 5.0, 6.0)
    max_tilt_deg: float = 180.0
    center: tuple[float, float, float] = (0.0, 0.0, 2.0)
    start_speed: float = 2.0
    start_tilt_deg: float = 80.0
    start_rate: float = 6.0
    start_yaw_deg: float = 180.0
    far_m: float = 4.0
