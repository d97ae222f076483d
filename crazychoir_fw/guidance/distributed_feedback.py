"""`CFDistributedFeedback`: feedback on what neighbors send, one round after the other."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.guidance.cf_guidance import TOUCHDOWN_HEIGHT, Phase
from crazychoir_fw.guidance.climb import Climb, toward
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.graph import NeighborSchedule
from crazychoir_fw.guidance.law import POSES, Needs, NodeFace, Option, option
from crazychoir_fw.guidance.outputs import Outputs
from crazychoir_fw.guidance.presence import LATE_ROUNDS
from crazychoir_fw.guidance.round_guidance import RoundGuidance

Array = NDArray[np.float64]

Listener = Callable[[int, int, float], None]
"""Takes the agent, the neighbor and the time (s)."""

# of take-off and landing; 6 and 4 are damped by 0.8, and slower than the attitude follows
_CLIMB_P = 6.0  # [1/s^2]
_CLIMB_D = 4.0  # [1/s]


class CFDistributedFeedback(RoundGuidance):
    """Exchanges poses with the neighbors and follows the input that a subclass computes of them.

    Where the message of a neighbor is missing, the previous one counts, until the neighbor has been silent for a while.
    Then the neighbor is lost: it is reported and left out, and rounds do not wait for it, until a message arrives.
    """

    references_itself = True
    needs = Needs()
    node = NodeFace(
        positional=("update_frequency", *POSES, "input_topic"),
        parameters={"weights": Option(None, "weights of the neighbors", kind=list[float])},
    )

    silence: float = option(0.5, "silence after which a neighbor is lost", "s", above=0)
    schedule: NeighborSchedule | None = option(None, "neighbors as they change; None: those of the communicator")
    on_lost: Listener | None = option(None, "called as on_lost(agent, neighbor, now)")
    on_rejoined: Listener | None = option(None, "called as on_rejoined(agent, neighbor, now)")

    def __init__(self, agent_id: int, communicator: TopicCommunicator, **options: Any) -> None:
        """Prepare; arguments and errors are those of `RoundGuidance`."""
        super().__init__(agent_id, communicator, **options)
        self._neighbors: Sequence[int] = communicator.in_neighbors  # those of the open round
        self._awaited: Sequence[int] = communicator.in_neighbors  # and those that it waits for
        self._behind: set[int] = set()
        self._poses: dict[int, Pose] | None = None  # of the round that ends
        self._next_look = -math.inf
        self._last_outputs = Outputs()
        self._vertical_way: Climb | None = None
        self.previous_round: float | None = None
        """When the round before was finished (s)."""
        self.changes = 0
        """How often the neighbors that it hears have changed."""

    # ---------------------------------------------------------------- to be overridden

    @abstractmethod
    def evaluate_input(self, neigh_data: dict[int, Pose]) -> Array:
        """Return the input (m/s^2, world), shape (3,), of what the neighbors sent in this round."""

    def message(self) -> object:
        """Return the message to neighbors in a round: the own pose."""
        return self.current_pose

    # ---------------------------------------------------------------- phases

    def begin_takeoff(self, now: float) -> None:
        """Ask for the climb: leaders by a trajectory, others by accelerations."""
        super().begin_takeoff(now)
        self._set_out(np.array([*self._above_start()[:2], self._position()[2]]), self.height, now)

    def begin_landing(self, now: float) -> None:
        """Ask for the descent."""
        super().begin_landing(now)
        self._set_out(self._position(), TOUCHDOWN_HEIGHT, now)

    def _set_out(self, start: Array, height: float, now: float) -> None:
        way = max(abs(height - float(start[2])), TOUCHDOWN_HEIGHT)
        self._vertical_way = Climb(start, height, now, way / self.takeoff_time)

    # ---------------------------------------------------------------- a round

    def begin_round(self, now: float) -> bool:
        """Send the own pose; False if there is none yet, or a round is open."""
        if super().begin_round(now):
            return True
        self._look(now)
        return False

    def open_round(self, now: float) -> bool:
        """Send the message to neighbors; see `RoundGuidance`."""
        if self.current_pose is None or self.current_pose.position is None:
            return False
        communicator = self.communicator
        communicator.catch_up()
        if self.schedule is None:
            communicator.neighbors_send(self.message())
        else:
            into, out = self.schedule.neighbors_at(self.agent_id, now, communicator.current_label)
            for neighbor in self._neighbors:
                if neighbor not in into:
                    self.presence.forget(neighbor)  # rounds no longer wait for it
            self._neighbors = into
            self._choose_awaited()
            communicator.neighbors_send(self.message(), out)
        return True

    def has_round(self, now: float) -> bool:
        """See `RoundGuidance`."""
        if not self.communicator.synchronous_mode or self.communicator.has_round(self._awaited):
            return True
        self._look(now)
        return self.communicator.has_round(self._awaited)

    def close_round(self, now: float) -> None:
        """Keep what came for `decide`."""
        self._poses = self.receive_round(now)

    def decide(self, now: float) -> Outputs:
        """Return what to ask for, after a round; without one, nothing new."""
        neigh_data, self._poses = self._poses, None
        phase = self._phase
        reference = None
        if phase is not Phase.IDLE and phase is not Phase.STOPPED and neigh_data is not None:
            reference = self.respond(neigh_data, now)
        return self.decided(now, reference)

    def between_rounds(self, now: float) -> Outputs:
        """Repeat the latest reference."""
        if self._phase is Phase.IDLE or self._phase is Phase.STOPPED or self._trajectory is not None:
            return self.outputs(now, None)
        return Outputs(self._last_outputs.reference)

    def decided(self, now: float, reference: Reference | None) -> Outputs:
        """Return what to ask for, and keep it until the next round."""
        self._last_outputs = self.outputs(now, reference)
        return self._last_outputs

    def receive_round(self, now: float) -> dict[int, Pose]:
        """End the round and return what counts of the neighbors."""
        communicator, data = self.communicator, self.end_round(now)
        usable = {}
        for neighbor in self._neighbors:
            # a neighbor without a message that is not lost yet keeps its latest pose
            pose = data[neighbor] if neighbor in data else communicator.latest(neighbor)
            if neighbor not in self.presence.lost and is_usable(pose):
                usable[neighbor] = pose
        return usable

    def end_round(self, now: float) -> dict[int, Any]:
        """End the round and return the messages that are there."""
        self.round_open = False
        data = self.communicator.collect(self._neighbors)
        if now >= self._next_look or not self.hears_all:
            self._look(now)
        return data

    @property
    def hears_all(self) -> bool:
        """Whether no neighbor is lost or behind."""
        return not self.presence.lost and not self._behind

    @property
    def has_stragglers(self) -> bool:
        """Whether a neighbor counts rounds by itself, far behind: its messages count, but no round waits for them."""
        return bool(self._behind)

    @property
    def heard_neighbors(self) -> Sequence[int]:
        """Neighbors that it waits for: those of the graph that are neither lost nor behind."""
        return self._awaited

    def respond(self, neigh_data: dict[int, Pose], now: float) -> Reference | None:
        """Return the reference of any phase of flight: from START on that of the law, else straight up or down."""
        if self._phase is Phase.FLIGHT:
            return Reference(acceleration=self.evaluate_input(neigh_data))
        if self._vertical_way is None or self.current_pose is None:
            return None
        return Reference(acceleration=toward(self.current_pose, *self._vertical_way.wanted(now), _CLIMB_P, _CLIMB_D))

    # ---------------------------------------------------------------- presence of neighbors

    def _look(self, now: float) -> None:
        """Find the neighbors that fell silent, and those that are back.

        Ten checks per `silence` are enough; other rounds skip the check while all neighbors are present.
        """
        if now < self._next_look and self.hears_all:
            return
        self._next_look = now + 0.1 * self.silence
        lost, back = self.presence.look(now, self._neighbors, self.silence)
        for listener, neighbors in ((self.on_rejoined, back), (self.on_lost, lost)):
            for neighbor in neighbors if listener is not None else ():
                listener(self.agent_id, neighbor, now)  # type: ignore[misc]
        behind = self._behind.difference(self._neighbors).union(filter(self._is_behind, self._neighbors))
        if lost or back or behind != self._behind:
            self._behind = behind
            self._choose_awaited()

    def _is_behind(self, neighbor: int) -> bool:
        communicator = self.communicator
        return 0 <= communicator.newest_label(neighbor) < communicator.current_label - LATE_ROUNDS

    def _choose_awaited(self) -> None:
        self.changes += 1
        self._awaited = [one for one in self._neighbors if one not in self.presence.lost and one not in self._behind]


def is_usable(pose: Any) -> bool:
    """Return whether what a neighbor sent is a pose with a finite position, and a finite velocity if any."""
    if not isinstance(pose, Pose):
        return False
    position, velocity = pose.position, pose.velocity
    # sums instead of isfinite().all(), which costs ten times as much
    return (
        position is not None
        and position.shape == (3,)
        and math.isfinite(position[0] + position[1] + position[2])
        and (velocity is None or (velocity.shape == (3,) and math.isfinite(velocity[0] + velocity[1] + velocity[2])))
    )
