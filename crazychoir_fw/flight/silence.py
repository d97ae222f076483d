"""Which drones have guidance that asks for nothing for a while, so that rounds need not step it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

from crazychoir_fw.common.checkpoint import Stateful
from crazychoir_fw.flight.agent import Agent
from crazychoir_fw.guidance import CFGuidance

_LONGEST_S = 0.1  # between two steps, so that the pose of a silent guidance is never older
_EARLY_S = 1e-6  # rounding of times: a step too many changes nothing


class Silence(Stateful):
    """Times until which guidance of N drones may be left alone; a button or a call of the guidance ends one."""

    def __init__(self, agents: Sequence[Agent]) -> None:
        """Take the drones; laws that another component watches (`on_change`), and those of no such law, are stepped."""
        self._until = [-math.inf] * len(agents)
        self._is_known = [isinstance(agent.guidance, CFGuidance) for agent in agents]
        for agent in agents:
            if self._is_known[agent.index] and agent.guidance.on_change is None:
                agent.guidance.on_change = partial(self._end, agent.index)
            else:
                self._is_known[agent.index] = False

    def _end(self, index: int) -> None:
        self._until[index] = -math.inf

    def others(self, agents: Sequence[Agent], now: float) -> list[Agent]:
        """Return those of some drones whose guidance must be stepped at a time (s)."""
        until = self._until
        return [agent for agent in agents if now >= until[agent.index]]

    def look(self, agent: Agent, now: float) -> None:
        """Find out, after a step of its guidance, until when a drone may be left alone."""
        if self._is_known[agent.index] and agent.failure is None:
            self._until[agent.index] = min(agent.guidance.silent_until(now), now + _LONGEST_S) - _EARLY_S
