"""REBOOT: onboard software starts again, and what an agent was before is forgotten."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from crazychoir_fw.common.errors import CrazychoirError, StateError
from crazychoir_fw.flight.agent import DronePhase

if TYPE_CHECKING:
    from crazychoir_fw.flight.access.access import Access
    from crazychoir_fw.flight.agent import Agent

_MAX_PROBLEMS = 5  # that are told


def reboot_all(agents: Sequence[Agent], access: Access) -> str:
    """Reboot the drones of agents; returns what to expect, in a few words.

    Raises:
        StateError: If one of them flies, and nothing is done; or if some could not be rebooted, and the others were.
    """
    for agent in agents:
        if agent.is_up:
            raise StateError(f"{agent.name} flies; LAND or STOP it before REBOOT")
    expected, problems = [], []
    for agent in agents:
        try:
            expected.append(access.reboot(agent.index))
        except CrazychoirError as error:  # the others are not to wait for this one
            problems.append(str(error))
            continue
        agent.phase, agent.failure, agent.reference = DronePhase.GROUND, None, None
    if problems:
        raise StateError("; ".join(problems[:_MAX_PROBLEMS]))
    return ", ".join(dict.fromkeys(expected))
