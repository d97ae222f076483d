"""Target surveillance: defenders place themselves between intruders and a target (docs/reference/crazychoir.md#8.3).

Each defender knows its own intruder and the target. Aggregative tracking finds where everybody should be, one exchange
with the neighbors per iteration, and what the iteration has reached so far is where the defender flies.

The original iterates as fast as messages travel. Here iterations are paced by a setting: at most one per round of the
guidance, so that a flight depends on the machine in no way.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.guidance import optimization
from crazychoir_fw.guidance.cf_guidance import CFGuidance, Phase
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.optimization import Agent, SurveillanceProblem
from crazychoir_fw.guidance.outputs import Outputs
from crazychoir_fw.guidance.schemes.ranges import above_zero
from crazychoir_fw.guidance.schemes.sightings import Sightings

Array = NDArray[np.float64]

OPTIMIZERS = ("ResilientAggregativeTracking", "AggregativeTracking", "RobustAggregativeTracking")
"""Algorithms of `crazychoir_fw.guidance.optimization` that a mission may name."""

REFERENCES = ("trajectory", "position")
"""Where references go: to the trajectory handler as short go-tos, or straight to the controller."""

_EARLY = 1e-9  # [s]; times of rounds are sums of periods
_LATE_ROUNDS = 3  # who is farther behind than this counts rounds by itself and is not waited for


class AggregativeGuidance(CFGuidance):
    """Takes off, iterates from START on and flies to what the iteration says, and lands.

    A neighbor that is not heard by the deadline of a round is left out; with `ResilientAggregativeTracking` the
    defenders that are left find their own optimum. It is waited for again as soon as it is heard. An intruder that is
    watched and not seen for a while is reported as lost, and counts where it was seen last.

    Subclasses may override `get_initial_condition`, `get_intruder`, `get_target` and `save_results`.
    """

    kind = "position"
    intruder_moves = False
    """Whether the intruder is a drone also where none is named."""

    def __init__(
        self,
        agent_id: int,
        communicator: TopicCommunicator,
        *,
        optimizer: str | type = OPTIMIZERS[0],
        stepsize: float = 1e-3,
        iterations_per_second: float = 100.0,
        max_iterations: int | None = None,
        freq_reference: float = 10.0,
        references: str = REFERENCES[0],
        reference_time: float = 0.3,
        target: ArrayLike | None = None,
        intruder: ArrayLike | None = None,
        intruder_id: int | None = None,
        team: Sequence[int] | None = None,
        gamma_intruder: float = 1.0,
        gamma_target: float = 1.0,
        gamma_shape: float = 1.0,
        weights: Mapping[int, float] | Sequence[float] | None = None,
        init_pos: ArrayLike | None = None,
        height: float = 1.0,
        takeoff_time: float = 3.0,
        update_frequency: float = 100.0,
        deadline: float = 0.05,
        silence: float = 0.5,
        drop_unseen: bool = False,
        enable_log: bool = False,
    ) -> None:
        """Prepare.

        Args:
            agent_id: Number of this drone, that of the communicator.
            communicator: How it talks to other defenders, undirected.
            optimizer: One of `OPTIMIZERS`, or a class with the arguments of `AggregativeTracking`.
            stepsize: The step alpha; the original's examples have 1e-3 and 5e-3.
            iterations_per_second: Pace of the iterations (1/s), at most `update_frequency`.
            max_iterations: The iteration ends after so many (20,000 in the original); None goes on until the landing.
            freq_reference: References per second (Hz).
            references: One of `REFERENCES`.
            reference_time: Of a go-to to the trajectory handler (s): longer is smoother, and later.
            target: What is guarded (m, world); only x and y count. None: nothing.
            intruder: Where this drone's intruder is, likewise, if it stands still.
            intruder_id: Number of the drone that is the intruder; None: none, or that with the number `agent_id` plus
                the number of defenders where intruders move.
            team: Numbers of all defenders; None: all that the communicator knows of.
            gamma_intruder: Weight of being near the intruder.
            gamma_target: Weight of the defenders' center being near the target.
            gamma_shape: Weight of being near the defenders' center.
            weights: Doubly stochastic weights: the row of this agent, or by neighbor; None: 1/(1 + neighbors) for each,
                which is right where all have as many.
            init_pos: Start (m, world), shape (2,) or (3,).
            height: At which it flies (m).
            takeoff_time: Of take-off and landing (s).
            update_frequency: Rounds per second (Hz).
            deadline: How long a round may take (s).
            silence: After which a watched intruder is lost (s), and a neighbor in asynchronous mode.
            drop_unseen: A lost intruder drops out of the cost, and its defender goes to the target: not for two of
                them at once. Otherwise it counts where it was seen last.
            enable_log: Remember the decision of every iteration in `results`.

        Raises:
            RangeError: If a number is outside its range, or there is nothing to guard.
            UnknownNameError: If there is no such optimizer or way of references.
        """
        super().__init__(
            agent_id, init_pos=init_pos, height=height, takeoff_time=takeoff_time, update_frequency=update_frequency
        )
        who = f"agent {agent_id}"
        if communicator.rank != agent_id:
            raise RangeError(f"{who}: the communicator is that of agent {communicator.rank}")
        if set(communicator.in_neighbors) != set(communicator.out_neighbors):
            raise RangeError(f"{who}: hears others than hear it, allowed: an undirected graph")
        above_zero(who, stepsize=stepsize, deadline=deadline, silence=silence)
        above_zero(who, 60.0, reference_time=reference_time)
        above_zero(who, update_frequency, iterations_per_second=iterations_per_second, freq_reference=freq_reference)
        if max_iterations is not None and max_iterations < 1:
            raise RangeError(f"{who}: max_iterations is {max_iterations}, allowed: 1 or more")
        if references not in REFERENCES:
            raise UnknownNameError(f"{who}: references is '{references}', allowed: {', '.join(REFERENCES)}")
        self.communicator = communicator
        self.stepsize = stepsize
        self.max_iterations = max_iterations
        self.references = references
        self.reference_time = reference_time
        self.deadline = deadline
        self.silence = silence
        self.drop_unseen = drop_unseen
        self.enable_log = enable_log
        self.target = None if target is None else self._checked("target", target, (2, 3))[:2]
        self.intruder = None if intruder is None else self._checked("intruder", intruder, (2, 3))[:2]
        self._gammas = {"gamma_intruder": gamma_intruder, "gamma_target": gamma_target, "gamma_shape": gamma_shape}
        SurveillanceProblem((0.0, 0.0), **self._gammas)  # refuses weights now, and not in flight
        self._make = _optimizer(optimizer, agent_id)
        if optimizer in OPTIMIZERS[:2] and not communicator.synchronous_mode:
            raise RangeError(f"{who}: optimizer is {optimizer}, allowed in asynchronous mode: {OPTIMIZERS[2]}")
        neighbors = communicator.in_neighbors
        self._weights = dict.fromkeys(neighbors, 1.0 / (1 + len(neighbors))) if weights is None else weights
        self._agent = Agent(communicator=communicator, in_weights=self._weights, out_weights=self._weights)
        if intruder_id is None and self.intruder_moves:
            intruder_id = agent_id + (communicator.size if team is None else len(team))
        if intruder_id is not None and (intruder_id < 0 or intruder_id == agent_id or intruder is not None):
            raise RangeError(f"{who}: intruder_id is {intruder_id}, allowed: another drone, and no intruder")
        self.watched: tuple[int, ...] = () if intruder_id is None else (intruder_id,)
        """Numbers of drones whose poses it is told by `see`."""
        if target is None and intruder is None and not self.watched:
            raise RangeError(f"{who}: there is neither intruder nor target, allowed: at least one")

        self.round_open = False
        self.results: list[Array] = []
        """Decisions (m) of all iterations since START, with `enable_log`."""
        self.algorithm: Any = None
        """The optimization while it runs."""
        self._iteration_period, self._reference_period = 1.0 / iterations_per_second, 1.0 / freq_reference
        self._round_begin = 0.0
        self._next_iteration = self._next_reference = 0.0
        self._airborne_at = -math.inf  # [s], when the climb is over
        self._flies = False
        self._lost: set[int] = set()
        self._heard: dict[int, int] = {}
        self._last_heard: dict[int, float] = {}
        self._sightings = Sightings(silence)
        self._now = 0.0

    # ---------------------------------------------------------------- to be overridden

    def get_initial_condition(self) -> Array:
        """Return the first decision (m), shape (2,): where the drone is."""
        return self._position()[:2].copy()

    def get_intruder(self) -> Array | None:
        """Return where the intruder of this drone is at present (m), shape (2,), or None."""
        if not self.watched:
            return self.intruder
        if self.drop_unseen and self._sightings.is_lost(self.watched[0], self._now):
            return None
        return self._sightings.before(self.watched[0], self._now)

    def get_target(self) -> Array | None:
        """Return where the target is at present (m), shape (2,), or None."""
        return self.target

    def save_results(self) -> None:
        """Called when the landing begins; `results` are there with `enable_log`."""

    # ---------------------------------------------------------------- buttons

    def begin_takeoff(self, now: float) -> None:
        """Ask for the climb."""
        super().begin_takeoff(now)
        self._airborne_at, self._flies = now + self.takeoff_time, True
        self._end()

    def begin_flight(self, now: float) -> None:
        """Iterate from now on; whoever has not taken off does."""
        if not self._flies:
            super().begin_takeoff(now)
            self._airborne_at, self._flies = now + self.takeoff_time, True
        self._next_reference = max(now, self._airborne_at)
        if self.algorithm is None:
            self._next_iteration = now
            self.results = []

    def begin_landing(self, now: float) -> None:
        """Ask for the descent; the iteration ends."""
        super().begin_landing(now)
        self._flies = False
        if self.algorithm is not None:
            self.save_results()
        self._end()

    def stop(self, now: float) -> None:
        """Ask for nothing any more."""
        super().stop(now)
        self._flies = False
        self._end()

    def _end(self) -> None:
        self.algorithm, self.round_open = None, False

    # ---------------------------------------------------------------- other drones

    @property
    def lost(self) -> frozenset[int]:
        """Neighbors that are not heard, and intruders that are not seen; after the flight, who was not heard in it."""
        if self._phase is not Phase.FLIGHT:
            return frozenset(self._lost)
        unseen = {one for one in self.watched if self._sightings.is_lost(one, self._now)}
        return frozenset(self._lost | unseen)

    def see(self, number: int, pose: Pose) -> None:
        """Take the pose of a drone that is watched.

        Raises:
            RangeError: If its position is not three finite numbers.
        """
        if pose.position is None:
            return
        position = self._checked(f"the position of agent {number}", pose.position)
        self._sightings.see(number, pose.time, position[:2].copy(), self._now)

    # ---------------------------------------------------------------- a round

    def begin_round(self, now: float) -> bool:
        """Send, if an iteration is due; False if none is, or a round is open."""
        self._now = now
        if self.round_open or self._phase is not Phase.FLIGHT or now < self._next_iteration - _EARLY:
            return False
        if self.max_iterations is not None and self.algorithm and self.algorithm.rounds >= self.max_iterations:
            return False
        problem = self._problem()
        if problem is not None:
            self._agent.set_problem(problem)
        if self._agent.problem is None or self.current_pose is None:
            return False  # nobody knows yet what is to be guarded, or where this drone is
        if self.algorithm is None:
            self.algorithm = self._make(self._agent, self.get_initial_condition(), stepsize=self.stepsize, now=now)
            self.algorithm_began(now)
        if self._agent.is_asynchronous:
            self._look_around(now)
        else:
            self.communicator.catch_up()
            self._welcome()
        while self._next_iteration <= now + _EARLY:
            self._next_iteration += self._iteration_period
        self.algorithm.begin_round(now)
        self._round_begin, self.round_open = now, True
        return True

    def _problem(self) -> SurveillanceProblem | None:
        """Return the problem of this moment, or None where nothing is known: the one before goes on."""
        intruder, target = self.get_intruder(), self.get_target()
        if intruder is None and target is None:
            return None
        known = self._agent.problem
        if known is not None and _same(intruder, known.intruder) and _same(target, known.target):
            return known
        return SurveillanceProblem(intruder, target, **self._gammas)

    def algorithm_began(self, now: float) -> None:
        """Called when the iteration begins anew."""
        communicator = self.communicator
        self._lost -= set(communicator.in_neighbors)
        self._heard = {one: communicator.heard(one) for one in communicator.in_neighbors}
        self._last_heard = dict.fromkeys(communicator.in_neighbors, now)
        self._agent.set_neighbors(communicator.in_neighbors, communicator.out_neighbors)

    def is_complete(self, now: float) -> bool:
        """Return whether `finish_round` need not wait: all are there, the deadline is over, or no round is open."""
        return not self.round_open or self._agent.has_round() or now - self._round_begin >= self.deadline - _EARLY

    def finish_round(self, now: float) -> Outputs:
        """Use what came, and return what to ask for; the round ends, complete or not."""
        self._now = now
        if self.round_open:
            self.round_open = False
            missing: list[int] = []
            if not self._agent.is_asynchronous:
                missing = [one for one in self._agent.in_neighbors if not self.communicator.has_round([one])]
            self.algorithm.finish_round()
            if missing:
                self._leave(missing)
            if self.enable_log:
                self.results.append(self.algorithm.get_result())
        return self.outputs(now, self._reference(now))

    def step(self, now: float) -> Outputs:
        """Begin or finish a round, as far as that is possible now; never waits."""
        self.begin_round(now)
        if self.round_open and self.is_complete(now):
            return self.finish_round(now)
        self._now = now
        return self.outputs(now, self._reference(now))

    def _reference(self, now: float) -> Reference | None:
        """Return a position for the controller if one is due, or ask the trajectory handler for a short way there."""
        if self._phase is not Phase.FLIGHT or self.algorithm is None or now < self._next_reference - _EARLY:
            return None
        while self._next_reference <= now + _EARLY:
            self._next_reference += self._reference_period
        position = np.append(self.algorithm.get_result(), self.height)
        if self.references == "position":
            return Reference(position=position)
        self.go_to(position, self.reference_time)
        return None

    # ---------------------------------------------------------------- who is there

    def _leave(self, neighbors: Sequence[int]) -> None:
        """Go on without neighbors."""
        self._lost.update(neighbors)
        if hasattr(self.algorithm, "leave"):
            self.algorithm.leave(neighbors)
        for one in neighbors:
            self._heard[one] = self.communicator.heard(one)
        self._set_neighbors()

    def _return(self, neighbors: Sequence[int]) -> None:
        self._lost.difference_update(neighbors)
        if hasattr(self.algorithm, "rejoin"):
            self.algorithm.rejoin(neighbors)
        self._set_neighbors()

    def _set_neighbors(self) -> None:
        communicator = self.communicator
        heard = [one for one in communicator.in_neighbors if one not in self._lost]
        self._agent.set_neighbors(heard, communicator.out_neighbors)

    def _welcome(self) -> None:
        """Count on neighbors again that are heard again, in the present rounds."""
        communicator = self.communicator
        back = [
            one
            for one in communicator.in_neighbors
            if one in self._lost
            and communicator.heard(one) != self._heard[one]
            and communicator.newest_label(one) >= communicator.current_label - _LATE_ROUNDS
        ]
        if back:
            self._return(back)

    def _look_around(self, now: float) -> None:
        """Find out in asynchronous mode who is silent and who is heard again."""
        left, back = [], []
        for one in self.communicator.in_neighbors:
            heard = self.communicator.heard(one)
            if heard != self._heard[one]:
                self._heard[one], self._last_heard[one] = heard, now
                if one in self._lost:
                    back.append(one)
            elif one not in self._lost and now - self._last_heard[one] > self.silence:
                left.append(one)
        if left:
            self._leave(left)
        if back:
            self._return(back)


class AggregativeGuidanceCrazyflie(AggregativeGuidance):
    """The guidance of CrazyChoir's examples with intruders that stand still."""


class AggregativeGuidanceCrazyflieMovingIntruder(AggregativeGuidanceCrazyflie):
    """The intruder is a drone that is watched: by default that whose number is larger by the number of defenders."""

    intruder_moves = True


def _same(one: Array | None, other: Array | None) -> bool:
    return one is other if one is None or other is None else bool((one == other).all())


def _optimizer(optimizer: str | type, agent_id: int) -> Callable[..., Any]:
    """Return what makes an optimization of agent, initial condition, stepsize and time.

    Raises:
        UnknownNameError: If it is a name that nobody has.
    """
    if isinstance(optimizer, str):
        if optimizer not in OPTIMIZERS:
            raise UnknownNameError(f"agent {agent_id}: optimizer is '{optimizer}', allowed: {', '.join(OPTIMIZERS)}")
        optimizer = getattr(optimization, optimizer)
    kind: Any = optimizer
    if isinstance(kind, type) and issubclass(kind, optimization.ResilientAggregativeTracking):
        # ms, so that who begins anew begins with a larger number
        return lambda agent, start, stepsize, now: kind(agent, start, stepsize=stepsize, session=int(1000.0 * now))
    return lambda agent, start, stepsize, now: kind(agent, start, stepsize=stepsize)


__all__ = [
    "OPTIMIZERS",
    "REFERENCES",
    "AggregativeGuidance",
    "AggregativeGuidanceCrazyflie",
    "AggregativeGuidanceCrazyflieMovingIntruder",
]
