"""`CFDistributedFeedback`: feedback on what neighbors send, one round after the other."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.guidance.cf_guidance import TOUCHDOWN_HEIGHT, CFGuidance, Phase
from crazychoir_fw.guidance.climb import Climb, toward
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.graph import NeighborSchedule
from crazychoir_fw.guidance.outputs import Outputs

Array = NDArray[np.float64]

Listener = Callable[[int, int, float], None]
"""Takes the agent, the neighbor and the time (s)."""

# of take-off and landing; 6 and 4 are damped by 0.8, and slower than the attitude follows
_CLIMB_P = 6.0  # [1/s^2]
_CLIMB_D = 4.0  # [1/s]
_LATE_ROUNDS = 3  # who is farther behind than this is not waited for: it counts rounds by itself


class CFDistributedFeedback(CFGuidance):
    """Exchanges poses with the neighbors and follows the input that a subclass computes of them.

    A round: `begin_round` sends, `is_complete` says whether all neighbors are there or the deadline is over, and
    `finish_round` receives. Of a neighbor whose message is missing, the one before counts until it has been silent for
    a while; then it is lost: reported, left out, not waited for, until it is heard again.
    """

    def __init__(
        self,
        agent_id: int,
        communicator: TopicCommunicator,
        *,
        init_pos: ArrayLike | None = None,
        height: float = 1.0,
        takeoff_time: float = 5.0,
        update_frequency: float = 100.0,
        deadline: float = 0.05,
        silence: float = 0.5,
        schedule: NeighborSchedule | None = None,
        on_lost: Listener | None = None,
        on_rejoined: Listener | None = None,
    ) -> None:
        """Prepare.

        Args:
            agent_id: Number of this drone, that of the communicator.
            communicator: Carries poses to and from neighbors.
            init_pos: Start (m, world), shape (2,) or (3,).
            height: Of the take-off (m).
            takeoff_time: Of take-off and landing (s).
            update_frequency: Rounds per second (Hz).
            deadline: How long a round may take (s).
            silence: After which a neighbor is lost (s).
            schedule: Neighbors as they change; None: those of the communicator.
            on_lost: Called as `on_lost(agent, neighbor, now)`.
            on_rejoined: Called as `on_rejoined(agent, neighbor, now)`.

        Raises:
            RangeError: If a number is outside its range.
        """
        super().__init__(
            agent_id, init_pos=init_pos, height=height, takeoff_time=takeoff_time, update_frequency=update_frequency
        )
        for name, value in (("deadline", deadline), ("silence", silence)):
            if not (math.isfinite(value) and value > 0.0):
                raise RangeError(f"agent {agent_id}: {name} is {value}, allowed: above 0 s")
        if communicator.rank != agent_id:
            raise RangeError(f"agent {agent_id}: the communicator is that of agent {communicator.rank}")
        self.communicator = communicator
        self.deadline = deadline
        self.silence = silence
        self.schedule = schedule
        self.on_lost = on_lost
        self.on_rejoined = on_rejoined
        self.round_open = False
        self.round_begin = 0.0
        self._neighbors: Sequence[int] = communicator.in_neighbors  # those of the open round
        self._awaited: Sequence[int] = communicator.in_neighbors  # and whom it waits for
        self._lost: set[int] = set()
        self._behind: set[int] = set()
        self._heard = dict.fromkeys(communicator.in_neighbors, 0)
        self._last_heard: dict[int, float] = {}
        self._next_look = -math.inf
        self._last_outputs = Outputs()
        self._vertical_way: Climb | None = None
        self.previous_round: float | None = None
        """When the round before was finished (s)."""
        self.changes = 0
        """How often the neighbors that it hears have changed."""

    @property
    def lost(self) -> frozenset[int]:
        """Neighbors that are silent."""
        return frozenset(self._lost)

    # ---------------------------------------------------------------- to be overridden

    @abstractmethod
    def evaluate_input(self, neigh_data: dict[int, Pose]) -> Array:
        """Return the input (m/s^2, world), shape (3,), of what the neighbors sent in this round."""

    def message(self) -> object:
        """Return what neighbors are told in a round: the own pose."""
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
        if self.round_open or self.current_pose is None or self.current_pose.position is None:
            self._look(now)
            return False
        communicator = self.communicator
        communicator.catch_up()
        if self.schedule is None:
            communicator.neighbors_send(self.message())
        else:
            into, out = self.schedule.neighbors_at(self.agent_id, now, communicator.current_label)
            for neighbor in self._neighbors:
                if neighbor not in into:
                    self._last_heard.pop(neighbor, None)  # nobody waits for it now
            self._neighbors = into
            self._choose_awaited()
            communicator.neighbors_send(self.message(), out)
        self.round_begin = now
        self.round_open = True
        return True

    def is_complete(self, now: float) -> bool:
        """Return whether `finish_round` need not wait: all are there, the deadline is over, or no round is open."""
        if not self.round_open:
            return True
        if not self.communicator.synchronous_mode or self.communicator.has_round(self._awaited):
            return True
        self._look(now)
        return now - self.round_begin >= self.deadline or self.communicator.has_round(self._awaited)

    def finish_round(self, now: float) -> Outputs:
        """Receive, and return what to ask for; the round ends, complete or not."""
        neigh_data = self.receive_round(now)
        phase = self._phase
        reference = None
        if phase is not Phase.IDLE and phase is not Phase.STOPPED and neigh_data is not None:
            reference = self.respond(neigh_data, now)
        return self.decided(now, reference)

    def decided(self, now: float, reference: Reference | None) -> Outputs:
        """Return what to ask for, and keep it until the next round."""
        self._last_outputs = self.outputs(now, reference)
        return self._last_outputs

    def receive_round(self, now: float) -> dict[int, Pose] | None:
        """End the round and return what counts of the neighbors; None if none is open."""
        if not self.round_open:
            return None
        communicator, data = self.communicator, self.end_round(now)
        usable = {}
        for neighbor in self._neighbors:
            # who is not there, but not lost either, is taken to be where it was
            pose = data[neighbor] if neighbor in data else communicator.latest(neighbor)
            if neighbor not in self._lost and is_usable(pose):
                usable[neighbor] = pose
        return usable

    def end_round(self, now: float) -> dict[int, Any]:
        """End the round and return the messages that are there."""
        self.round_open = False
        data = self.communicator.collect(self._neighbors)
        if now >= self._next_look or self._lost or self._behind:
            self._look(now)
        return data

    @property
    def hears_all(self) -> bool:
        """Whether no neighbor is lost or behind."""
        return not self._lost and not self._behind

    @property
    def has_stragglers(self) -> bool:
        """Whether a neighbor counts rounds by itself, far behind, so that it is heard but not waited for."""
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

    def step(self, now: float) -> Outputs:
        """Begin or finish a round, as far as that is possible now; never waits.

        While a round is open, what was asked for last is asked for again.
        """
        self.begin_round(now)
        if self.round_open and self.is_complete(now):
            return self.finish_round(now)
        if self._phase is Phase.IDLE or self._phase is Phase.STOPPED or self._trajectory is not None:
            return self.outputs(now, None)
        return Outputs(self._last_outputs.reference)

    # ---------------------------------------------------------------- who is alive

    def _look(self, now: float) -> None:
        """Find out who is silent and who is heard again.

        Ten times per silence is enough, and costs nothing in the other rounds.
        """
        if now < self._next_look and not self._lost and not self._behind:
            return
        self._next_look = now + 0.1 * self.silence
        communicator, changed = self.communicator, False
        for neighbor in self._neighbors:
            heard = communicator.heard(neighbor)
            if heard != self._heard[neighbor] or neighbor not in self._last_heard:
                if heard != self._heard[neighbor] and neighbor in self._lost:
                    self._lost.discard(neighbor)
                    changed = True
                    if self.on_rejoined is not None:
                        self.on_rejoined(self.agent_id, neighbor, now)
                self._heard[neighbor] = heard
                self._last_heard[neighbor] = now
            elif now - self._last_heard[neighbor] >= self.silence and neighbor not in self._lost:
                self._lost.add(neighbor)
                changed = True
                if self.on_lost is not None:
                    self.on_lost(self.agent_id, neighbor, now)
            behind = 0 <= communicator.newest_label(neighbor) < communicator.current_label - _LATE_ROUNDS
            if behind != (neighbor in self._behind):
                self._behind ^= {neighbor}
                changed = True
        if changed:
            self._choose_awaited()

    def _choose_awaited(self) -> None:
        self.changes += 1
        self._awaited = [one for one in self._neighbors if one not in self._lost and one not in self._behind]


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
