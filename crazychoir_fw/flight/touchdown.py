"""Drones at the floor: those that landed, and those that came down without a command to land."""

from __future__ import annotations

from collections.abc import Sequence

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.flight.agent import Agent, DronePhase

TOUCHDOWN_M = 0.05
"""Height above its start at which the motors of a landing drone stop (m)."""

_FLOWN_M = 0.2  # above its start, a drone has flown
_FALLEN_S = 1.0  # on the floor, after which it is not about to go on
_LANDING_SPEED = 0.5  # [m/s], at which a drone that passes the floor has not come to land


def landed_of(up: Sequence[Agent], poses: Pose) -> list[Agent]:
    """Return the landing drones that have come to the floor.

    Args:
        up: Drones whose motors turn.
        poses: Of all drones, arrays of shape (N, ...).
    """
    assert poses.position is not None and poses.velocity is not None
    return [
        agent
        for agent in up
        if agent.phase is DronePhase.LANDING
        and poses.position[agent.index, 2] < agent.floor + TOUCHDOWN_M
        and abs(poses.velocity[agent.index, 2]) < _LANDING_SPEED
    ]


def fallen_of(up: Sequence[Agent], poses: Pose, now: float) -> list[Agent]:
    """Return the flying drones that have been on the floor for a while: one on its feet minds no supervisor.

    Args:
        up: Drones whose motors turn; which of them has flown, and since when it is low, is noted there.
        poses: Of all drones, arrays of shape (N, ...).
        now: The time (s).
    """
    assert poses.position is not None
    heights, fallen = poses.position[:, 2].tolist(), []
    for agent in up:
        height = heights[agent.index] - agent.floor
        if height > _FLOWN_M:
            agent.has_flown = True
        if height > TOUCHDOWN_M or not agent.has_flown or agent.phase is not DronePhase.FLYING:
            agent.low_since = None
        elif agent.low_since is None:
            agent.low_since = now
        elif now - agent.low_since > _FALLEN_S:
            fallen.append(agent)
    return fallen
