"""Guidance without neighbors (features dossier section 8.1)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from crazychoir_fw.errors import RangeError
from crazychoir_fw.guidance.cf_guidance import CFGuidance, Phase
from crazychoir_fw.guidance.outputs import Outputs


class SimpleGuidance(CFGuidance):
    """Takes off and lands; in between, others send trajectories."""

    def __init__(
        self,
        takeoff_time: float = 5.0,
        height: float = 1.0,
        *,
        agent_id: int = 0,
        init_pos: ArrayLike | None = None,
        update_frequency: float = 100.0,
    ) -> None:
        """Prepare; arguments and errors are those of `CFGuidance`."""
        super().__init__(
            agent_id, init_pos=init_pos, height=height, takeoff_time=takeoff_time, update_frequency=update_frequency
        )


class GoToGuidance(CFGuidance):
    """Flies to goals, one after the other, from START on; no call ever waits."""

    def __init__(
        self,
        takeoff_time: float = 5.0,
        goals: Sequence[ArrayLike] | ArrayLike = (),
        *,
        height: float = 1.0,
        agent_id: int = 0,
        init_pos: ArrayLike | None = None,
        update_frequency: float = 100.0,
    ) -> None:
        """Prepare.

        Args:
            takeoff_time: Of take-off and landing (s).
            goals: Duration (s) and position (m, world) of each, shape (N, 4) or flat.
            height: Of the take-off (m).
            agent_id: Number of this drone.
            init_pos: Start (m, world), shape (2,) or (3,).
            update_frequency: How often `step` is called (Hz).

        Raises:
            RangeError: If a number is outside its range.
        """
        super().__init__(
            agent_id, init_pos=init_pos, height=height, takeoff_time=takeoff_time, update_frequency=update_frequency
        )
        numbers = np.asarray(goals, dtype=np.float64)
        if numbers.size % 4 or numbers.ndim > 2 or not np.isfinite(numbers).all():
            raise RangeError(f"agent {agent_id}: goals have shape {numbers.shape}, allowed: (t, x, y, z) each, finite")
        self.goals = numbers.reshape(-1, 4)
        if (self.goals[:, 0] <= 0.0).any():
            raise RangeError(f"agent {agent_id}: a goal takes {self.goals[:, 0].min()} s, allowed: above 0 s")
        # sums, so that goals begin where they should however the steps fall
        self._begins = np.concatenate([[0.0], np.cumsum(self.goals[:, 0])])
        self._next = 0

    def begin_flight(self, now: float) -> None:
        """Begin with the first goal."""
        del now
        self._next = 0

    def step(self, now: float) -> Outputs:
        """Return what to ask for at a time (s)."""
        if self._phase is Phase.FLIGHT:
            # 1 ns: times of steps are sums of periods
            while self._next < len(self.goals) and now - self._begin >= self._begins[self._next] - 1e-9:
                duration, *goal = self.goals[self._next]
                self.go_to(np.array(goal), duration)
                self._next += 1
        return self.outputs(now, None)

    @property
    def is_done(self) -> bool:
        """Whether the last goal was sent."""
        return self._next == len(self.goals)
