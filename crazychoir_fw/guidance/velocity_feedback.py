"""`VelocityFeedback`: feedback on what neighbors send, that asks for velocities (docs/reference/crazychoir.md#17.4)."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.guidance.cf_guidance import TOUCHDOWN_HEIGHT, Phase
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.distributed_feedback import CFDistributedFeedback
from crazychoir_fw.guidance.law import POSES, NodeFace, option
from crazychoir_fw.guidance.moving_reference import LONGEST_STEP, MovingReference

Array = NDArray[np.float64]

_LANDED = 0.05  # [m] above where landings end


class VelocityFeedback(CFDistributedFeedback):
    """Exchanges poses with the neighbors and flies with the velocity that a subclass computes of them.

    The velocity is integrated to a reference with position and velocity, see `MovingReference`, which flatness laws
    follow as well as velocity laws do. Leaders fly trajectories, or stay where they are.
    """

    kind = "fullstate"

    node = NodeFace(
        positional=("update_frequency", *POSES, "input_topic"),
        aliases={"input_topic": "velocity_topic"},
        parameters=CFDistributedFeedback.node.parameters,
        velocity_topic="velocity",
    )

    is_leader: bool = option(False, "whether it flies trajectories instead")
    max_speed: float = option(
        0.5, "largest speed that is asked for; infinite in the original", "m/s", above=0, is_finite=False
    )
    leash: float = option(0.5, "largest distance of the reference from the drone", "m", above=0, is_finite=False)
    lowest: float = option(0.2, "least height that is asked for in flight", "m", is_finite=False)

    def __init__(self, agent_id: int, communicator: TopicCommunicator, **options: Any) -> None:
        """Prepare; arguments and errors are those of `RoundGuidance`."""
        super().__init__(agent_id, communicator, **options)
        try:
            self.moving = MovingReference(self.max_speed, self.leash, self.lowest)
        except RangeError as error:
            raise RangeError(f"agent {agent_id}: {error}") from None
        self._top = 0.0  # where the landing began [m]

    @abstractmethod
    def evaluate_input(self, neigh_data: dict[int, Pose]) -> Array:
        """Return the velocity (m/s, world), shape (3,), of what the neighbors sent in this round."""

    # ---------------------------------------------------------------- phases

    @property
    def takeoff_height(self) -> float:
        """Where the take-off ends (m)."""
        return self.height

    def _above_start(self) -> Array:
        return np.array([*super()._above_start()[:2], self.takeoff_height])

    def begin_takeoff(self, now: float) -> None:
        """Ask for the climb: leaders by a trajectory, followers by a reference that rises."""
        if self.is_leader:
            super().begin_takeoff(now)
            return
        start = self._position()
        self.moving.begin(np.array([*self._above_start()[:2], start[2]]))

    def begin_flight(self, now: float) -> None:
        """Begin from where the reference is, or the drone."""
        if self.moving.position is None:
            self.moving.begin(self._position())

    def begin_landing(self, now: float) -> None:
        """Ask for the descent."""
        self._top = float(self._position()[2])
        if self.is_leader:
            super().begin_landing(now)
        elif self.moving.position is None:
            self.moving.begin(self._position())

    def has_landed(self, now: float) -> bool:
        """Return whether the landing is over."""
        if self.is_leader:
            return super().has_landed(now)
        # the reference sinks at the speed of the take-off, so that a higher drone needs longer
        at_bottom = (self._top - TOUCHDOWN_HEIGHT) / self._climb()
        is_down = self._position()[2] < TOUCHDOWN_HEIGHT + _LANDED
        return now - self._begin >= at_bottom + (0.0 if is_down else self.takeoff_time)

    def _enter(self, phase: Phase, now: float) -> None:
        if phase is Phase.IDLE or phase is Phase.STOPPED:
            self.moving.position = None  # a drone that is carried away meanwhile begins at its new place
        super()._enter(phase, now)

    def respond(self, neigh_data: dict[int, Pose], now: float) -> Reference | None:
        """Return what a follower asks for."""
        previous, self.previous_round = self.previous_round, now
        if self.is_leader:
            return None
        period = 0.0 if previous is None else min(max(now - previous, 0.0), LONGEST_STEP)
        if self.moving.position is None:
            self.moving.begin(self._position())
        if self._phase is Phase.FLIGHT:
            return self.moving.move(self.evaluate_input(neigh_data), self._position(), period)
        end = self.takeoff_height if self._phase is Phase.TAKEOFF else TOUCHDOWN_HEIGHT
        return self.moving.rise(end, self._climb(), period)

    def _climb(self) -> float:
        """Return the speed of take-off and landing (m/s)."""
        return self.takeoff_height / self.takeoff_time

    def offsets(self, neigh_data: dict[int, Pose]) -> Array:
        """Return where neighbors are, seen from this drone (m, world), shape (n, 3)."""
        if not neigh_data:
            return np.zeros((0, 3))
        return np.array([pose.position for pose in neigh_data.values()]) - self._position()


DistributedControlGuidance = VelocityFeedback
"""Its name in ChoiRbot."""
