"""Many guidances of one process, decided together: the same numbers in a fraction of the time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.checkpoint import Stateful
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Reference
from crazychoir_fw.guidance.bearing_formation import LONGEST_STEP, BearingFormation
from crazychoir_fw.guidance.cf_guidance import CFGuidance, Phase
from crazychoir_fw.guidance.distributed_feedback import CFDistributedFeedback
from crazychoir_fw.guidance.outputs import Outputs
from crazychoir_fw.guidance.vertical_ways import VERTICAL, VerticalWays

Array = NDArray[np.float64]

_STILL = np.zeros(3)
_STILL.flags.writeable = False


class GuidanceGroup(Stateful):
    """Steps agents that live in one process: all send, then all receive and decide.

    Messages travel as usual. Where every round is complete and no neighbor is missing, the laws of all followers of a
    bearing formation are evaluated as one product of a matrix and a vector; otherwise each agent decides by itself.
    Results of both ways differ by rounding, below 1e-12 m/s^2.

    With `sends=False` messages stop as soon as they would carry no news: every agent is in this group, flies in
    formation and has messages of all of its neighbors, or none flies in formation. They go on when that ends. The
    numbers are the same.
    """

    def __init__(self, agents: Sequence[CFGuidance], sends: bool = True) -> None:
        """Take the agents.

        Args:
            agents: In any order; neighbors of theirs may be elsewhere.
            sends: Whether messages travel in every round. False requires that the caller owns all agents, and a
                transport that loses nothing.

        Raises:
            RangeError: If two have the same number.
        """
        self.agents = list(agents)
        numbers = [agent.agent_id for agent in self.agents]
        if len(set(numbers)) != len(numbers):
            raise RangeError(f"agents have the numbers {numbers}, allowed: each once")
        self._place = {number: place for place, number in enumerate(numbers)}
        self._feedback = [agent for agent in self.agents if isinstance(agent, CFDistributedFeedback)]
        self._together = len(self._feedback) == len(self.agents) and all(map(self._knows, self._feedback))
        self._followers = [one for one in self._feedback if isinstance(one, BearingFormation) and not one.is_leader]
        self._sends = sends
        self._settled_at: float | None = None  # last round that was decided by arrays alone (s)
        self._changes = -1  # sum of `changes` of all agents, when the law was made
        self._can_decide = False
        self._is_quiet = False  # whether no phase has changed since the last look at all agents
        for agent in self.agents:
            agent.on_change = self._wake
        self.was_together = False
        """Whether the step before was one product for all."""
        self._law: Array | None = None
        self._trims = np.zeros((0, 3))
        self._ways: VerticalWays | None = None

    def restore(self, state: dict[str, Any]) -> None:
        """See `Stateful`. The law is made again when it is needed: trims of agents are rows of one array."""
        super().restore(state)
        self._law = None
        self._ways = None

    @classmethod
    def of(cls, agents: Sequence[CFGuidance]) -> GuidanceGroup | None:
        """Return a group of all agents that exchange messages, or None where one has a law that no group knows."""
        if not agents or any(type(agent) is not BearingFormation for agent in agents):
            return None
        return cls(agents, sends=not all(agent.communicator.is_lossless for agent in agents))  # type: ignore[attr-defined]

    def _knows(self, agent: CFDistributedFeedback) -> bool:
        """Return whether a group can decide for an agent: by the law that it knows."""
        return (
            isinstance(agent, BearingFormation)
            and type(agent).evaluate_input is BearingFormation.evaluate_input
            and type(agent).respond is BearingFormation.respond
            and type(agent).finish_round is CFDistributedFeedback.finish_round
            and type(agent).decide is CFDistributedFeedback.decide
            and not agent.legacy
            and agent.schedule is None
            and agent.communicator.synchronous_mode
        )

    def _make_law(self) -> None:
        """Make the matrix that takes positions and velocities of all to inputs, then rates of trims, of followers."""
        size, followers = len(self.agents), self._followers
        feedback, integral = np.zeros((2, len(followers), 3, 2, size, 3))
        for row, agent in enumerate(followers):
            neighbors = agent.heard_neighbors
            law = agent.law_of(neighbors)
            places = [*(self._place[neighbor] for neighbor in neighbors), self._place[agent.agent_id]]
            feedback[row][:, :, places] = law.feedback.reshape(3, 2, -1, 3)
            integral[row][:, 0, places] = law.integral.reshape(3, -1, 3)
            if law.lost_damping is not None:
                feedback[row][:, 1, places[-1]] -= law.lost_damping
        learns = integral.any()
        self._law = np.concatenate([feedback, integral] if learns else [feedback]).reshape(-1, 6 * size)
        self._trims = np.zeros((len(followers), 3))
        for agent, trim in zip(followers, self._trims, strict=True):
            agent.keep_trim_in(trim)
        limits = np.array([agent.gains.largest_trim for agent in followers])
        self._most_trim = limits.repeat(3).reshape(-1, 3)  # one for each number: NumPy takes twice as long with columns
        self._least_trim = -self._most_trim
        self._largest = np.array([agent.gains.largest_acceleration for agent in followers])
        self._largest_squared = self._largest**2
        self._least_squared = self._largest_squared.min(initial=np.inf)

    def step(self, now: float) -> list[Outputs]:
        """Return what each agent asks for at a time (s), in the order of the agents."""
        self.let_go()
        if not self._sends and self._together:
            if self._is_settled():
                self.was_together = True
                return self._step_together(now)
            if self._is_vertical():
                self.was_together = True
                return self._step_vertically(now)
        for agent in self._feedback:
            agent.begin_round(now)
        self.was_together = self._together and self._is_plain(now)
        if self.was_together:
            return self._step_together(now)
        return [self._step_alone(agent, now) for agent in self.agents]

    def let_go(self) -> None:
        """Set the time of the last round of each agent, for callers that step agents one by one after `decide`."""
        if self._settled_at is not None:
            for agent in self._feedback:
                agent.previous_round = self._settled_at
            self._settled_at = None

    def _wake(self) -> None:
        self._is_quiet = False
        self._ways = None

    @property
    def followers(self) -> list[int]:
        """Numbers of the agents that `decide` decides for, in its order."""
        return [agent.agent_id for agent in self._followers]

    def decide(self, now: float, positions: Array, velocities: Array) -> Array | None:
        """Return the accelerations of all followers, if nothing else is to be asked for in this round.

        That is so with `sends=False`, from the second round of a formation on. Agents get no poses then: a caller
        must set them before it presses a button.

        Args:
            now: Time (s).
            positions: Of all agents (m, world), in their order, shape (N, 3).
            velocities: The same (m/s), shape (N, 3).

        Returns:
            Accelerations (m/s^2, world), shape (followers, 3), or None: use `step`.
        """
        if self._sends or not self._together or not self._can_decide:
            return None
        if self._settled_at is None:
            if not self._is_settled():
                return None
        elif not self._is_quiet:
            if not all(agent.phase is Phase.FLIGHT and agent.asks_nothing for agent in self._feedback):
                return None
            self._is_quiet = True
        previous = self._feedback[0].previous_round if self._settled_at is None else self._settled_at
        self._settled_at = now
        self.was_together = True
        stacked = np.concatenate([positions.ravel(), velocities.ravel()])
        return self._inputs(stacked, min(max(now - previous, 0.0), LONGEST_STEP))

    def _step_alone(self, agent: CFGuidance, now: float) -> Outputs:
        if isinstance(agent, CFDistributedFeedback) and agent.round_open and agent.is_complete(now):
            return agent.finish_round(now)
        # a round that is not complete goes on; those without rounds just step
        return agent.step(now)

    def _is_plain(self, now: float) -> bool:
        """Return whether all agents are in formation and have the messages of this very round."""
        first = self._feedback[0]
        label, previous = first.communicator.current_label, first.previous_round
        changes = 0
        for agent in self._feedback:
            changes += agent.changes
            if not (
                agent.phase is Phase.FLIGHT
                and agent.round_open
                and agent.round_begin == now
                and agent.previous_round == previous
                and agent.communicator.current_label == label
                and agent.communicator.has_round(agent.heard_neighbors)
            ):
                return False
        if changes != self._changes:
            self._can_decide = all(map(self._can_decide_for, self._followers))
            if self._can_decide:
                self._make_law()
            self._changes = changes
        return self._can_decide

    def _is_vertical(self) -> bool:
        """Return whether none is in formation: what they ask for depends on themselves alone."""
        return all(
            agent.phase is not Phase.FLIGHT
            and not agent.round_open
            and agent.hears_all
            and agent.current_pose is not None
            and agent.current_pose.position is not None
            for agent in self._feedback
        )

    def _is_settled(self) -> bool:
        """Return whether all decided together in the last round, and nothing has happened since."""
        if not self._can_decide:
            return False
        previous = self._feedback[0].previous_round
        return previous is not None and all(
            agent.phase is Phase.FLIGHT
            and agent.asks_nothing
            and not agent.round_open
            and agent.hears_all
            and agent.previous_round == previous
            for agent in self._feedback
        )

    def _can_decide_for(self, agent: BearingFormation) -> bool:
        neighbors = agent.heard_neighbors
        return (
            not agent.has_stragglers
            and all(one in self._place for one in neighbors)
            and agent.law_of(neighbors).undetermined is None
        )

    def _step_together(self, now: float) -> list[Outputs]:
        period = self._feedback[0].period(now)
        poses = [agent.current_pose for agent in self.agents]
        vectors = [pose.position for pose in poses]  # type: ignore[union-attr]
        vectors += [_STILL if pose.velocity is None else pose.velocity for pose in poses]  # type: ignore[union-attr]
        stacked = np.concatenate(vectors)
        references = iter(self._inputs(stacked, period))
        outputs = []
        for agent in self._feedback:
            if agent.round_open:
                agent.end_round(now)
            agent.previous_round = now
            reference = None if agent.is_leader else Reference(acceleration=next(references))  # type: ignore[attr-defined]
            outputs.append(agent.decided(now, reference))
        return outputs

    def _step_vertically(self, now: float) -> list[Outputs]:
        if self._ways is None:
            self._ways = VerticalWays([one for one in self._followers if one.phase in VERTICAL])
            self._law = None  # it shares their trims
        wanted = dict(zip(map(id, self._ways.followers), self._ways.accelerations(now), strict=True))
        outputs = []
        for agent in self._feedback:
            if agent.phase in VERTICAL:
                agent.previous_round = now
            found = wanted.get(id(agent))
            outputs.append(agent.decided(now, None if found is None else Reference(acceleration=found)))
        return outputs

    def _inputs(self, stacked: Array, period: float) -> Array:
        """Return what all followers ask for, and learn their trims.

        Args:
            stacked: Positions, then velocities of all agents, shape (6 N,).
            period: Time since the round before (s).
        """
        if self._law is None:
            self._make_law()
        trims, count = self._trims, len(self._trims)
        found = (self._law @ stacked).reshape(-1, 3)
        if period and len(found) > count:
            trims += period * found[count:]
            np.minimum(np.maximum(trims, self._least_trim, out=trims), self._most_trim, out=trims)
        inputs = found[:count] + trims
        # no square exceeds the sum of all squares, which is cheap to compute; nan goes on to the comparison
        if not np.vdot(inputs, inputs) <= self._least_squared:
            squares = np.einsum("ij,ij->i", inputs, inputs)
            if (squares > self._largest_squared).any():
                inputs *= np.minimum(1.0, self._largest / np.sqrt(np.maximum(squares, 1e-300)))[:, None]
        return inputs
