"""Target surveillance: defenders place themselves between intruders and a target (docs/reference/crazychoir.md#8.3).

Each defender knows its own intruder and the target. Aggregative tracking computes the place of each defender, with one
exchange with the neighbors per iteration. The defender flies to the latest iterate.

The original iterates as fast as messages travel. Here iterations are paced by a setting: at most one per round of the
guidance, so that a flight depends on the machine in no way.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.guidance import optimization
from crazychoir_fw.guidance.cf_guidance import Phase
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.law import POSES, NodeFace, option
from crazychoir_fw.guidance.optimization import Agent, SurveillanceProblem
from crazychoir_fw.guidance.outputs import Outputs
from crazychoir_fw.guidance.presence import LATE_ROUNDS
from crazychoir_fw.guidance.round_guidance import RoundGuidance
from crazychoir_fw.guidance.schemes.sightings import Sightings
from crazychoir_fw.guidance.schemes.surveillance import SurveillanceMetrics

Array = NDArray[np.float64]

OPTIMIZERS = ("ResilientAggregativeTracking", "AggregativeTracking", "RobustAggregativeTracking")
"""Algorithms of `crazychoir_fw.guidance.optimization` that a mission may name."""

REFERENCES = ("trajectory", "position")
"""Where references go: to the trajectory handler as short go-tos, or straight to the controller."""

_EARLY = 1e-9  # [s]; times of rounds are sums of periods


class AggregativeGuidance(RoundGuidance):
    """Takes off, iterates from START on and flies to what the iteration says, and lands.

    A neighbor whose message misses the deadline of a round is left out; with `ResilientAggregativeTracking` the other
    defenders find their own optimum. Rounds wait for the neighbor again as soon as a message of it arrives. A watched
    intruder that is not seen for a while is reported as lost; its last position counts.

    Subclasses may override `get_initial_condition`, `get_intruder`, `get_target` and `save_results`.
    """

    kind = "position"
    metrics = SurveillanceMetrics
    intruder_moves = False
    """Whether the intruder is a drone also where none is named: that whose number is larger by the team's size."""
    node = NodeFace(
        "aggregative_guidance",
        ("optimizer", "height", "freq_reference", *POSES, "input_topic", "msg_type", "seed"),
        {"references": REFERENCES[1]},
        {"msg_topic": "input_topic", "msg_type": "", "seed": ""},
    )

    takeoff_time: float = option(3.0, "duration of take-off and landing", "s", above=0)
    optimizer: Any = option(
        OPTIMIZERS[0], "algorithm, or a class with the arguments of AggregativeTracking", choices=OPTIMIZERS
    )
    stepsize: float = option(1e-3, "step alpha; the original's examples have 1e-3 and 5e-3", above=0)
    iterations_per_second: float = option(100.0, "pace of the iterations, at most update_frequency", "1/s", above=0)
    max_iterations: int | None = option(
        None, "iterations after which it ends (20,000 in the original); None goes on until the landing", low=1, kind=int
    )
    freq_reference: float = option(10.0, "references per second, at most update_frequency", "Hz", above=0)
    references: str = option(
        REFERENCES[0], "where references go: to the trajectory handler, or to the controller", choices=REFERENCES
    )
    reference_time: float = option(
        0.3, "duration of a go-to to the trajectory handler: longer is smoother, and later", "s", above=0, high=60
    )
    target: Any = option(None, "what is guarded; only x and y count; None: nothing", "m, world", kind=list[float])
    intruder: Any = option(None, "where this drone's intruder stands; only x and y count", "m, world", kind=list[float])
    intruder_id: int | None = option(
        None,
        "number of the drone that is the intruder; None: none, or the next free one where intruders move",
        kind=int,
    )
    team: Sequence[int] | None = option(None, "numbers of all defenders; None: all that the communicator knows of")
    gamma_intruder: float = option(1.0, "weight of being near the intruder")
    gamma_target: float = option(1.0, "weight of the defenders' center being near the target")
    gamma_shape: float = option(1.0, "weight of being near the defenders' center")
    weights: Any = option(
        None,
        "doubly stochastic weights: the row of this agent, or by neighbor; None: 1/(1 + neighbors) for each, which is "
        "right where all have as many",
        kind=list[float],
    )
    silence: float = option(
        0.5, "silence after which a watched intruder is lost, and in asynchronous mode a neighbor", "s", above=0
    )
    drop_unseen: bool = option(
        False, "whether a lost intruder drops out of the cost: its defender goes to the target; not for two at once"
    )
    enable_log: bool = option(False, "whether the decision of every iteration is kept in results")

    def __init__(self, agent_id: int, communicator: TopicCommunicator, **options: Any) -> None:
        """Prepare; arguments are those of `RoundGuidance`, the communicator is undirected.

        Raises:
            RangeError: If a number is outside its range, or there is nothing to guard.
            UnknownNameError: If there is no such optimizer or way of references.
        """
        super().__init__(agent_id, communicator, **options)
        self._check_numbers()
        self.target = None if self.target is None else self._checked("target", self.target, (2, 3))[:2]
        self.intruder = None if self.intruder is None else self._checked("intruder", self.intruder, (2, 3))[:2]
        gammas = ("gamma_intruder", "gamma_target", "gamma_shape")
        self._gammas = {name: getattr(self, name) for name in gammas}
        SurveillanceProblem((0.0, 0.0), **self._gammas)  # refuses weights now, and not in flight
        self._make = _optimizer(self.optimizer)
        neighbors = communicator.in_neighbors
        if self.weights is None:
            self.weights = dict.fromkeys(neighbors, 1.0 / (1 + len(neighbors)))
        self._agent = Agent(communicator=communicator, in_weights=self.weights, out_weights=self.weights)
        self.watched: tuple[int, ...] = self._who_is_watched()
        """Numbers of drones whose poses `see` takes."""
        self.results: list[Array] = []
        """Decisions (m) of all iterations since START, with `enable_log`."""
        self.algorithm: Any = None
        """The optimization while it runs."""
        self._iteration_period, self._reference_period = 1.0 / self.iterations_per_second, 1.0 / self.freq_reference
        self._next_iteration = self._next_reference = 0.0
        self._airborne_at = -math.inf  # [s], when the climb is over
        self._flies = False
        self._sightings = Sightings(self.silence)

    def _check_numbers(self) -> None:
        """Refuse options that do not fit together."""
        who, communicator = f"agent {self.agent_id}", self.communicator
        if set(communicator.in_neighbors) != set(communicator.out_neighbors):
            raise RangeError(f"{who}: hears others than hear it, allowed: an undirected graph")
        for name in ("iterations_per_second", "freq_reference"):
            if getattr(self, name) > self.update_frequency:
                raise RangeError(
                    f"{who}: {name} is {getattr(self, name)}, allowed: above 0, at most {self.update_frequency:g}"
                )
        if self.optimizer in OPTIMIZERS[:2] and not communicator.synchronous_mode:
            raise RangeError(f"{who}: optimizer is {self.optimizer}, allowed in asynchronous mode: {OPTIMIZERS[2]}")

    def _who_is_watched(self) -> tuple[int, ...]:
        """Return the number of the drone that is the intruder, if it is one."""
        who, number = f"agent {self.agent_id}", self.intruder_id
        if number is None and self.intruder_moves:
            number = self.agent_id + (self.communicator.size if self.team is None else len(self.team))
        if number is not None and (number < 0 or number == self.agent_id or self.intruder is not None):
            raise RangeError(f"{who}: intruder_id is {number}, allowed: another drone, and no intruder")
        if self.target is None and self.intruder is None and number is None:
            raise RangeError(f"{who}: there is neither intruder nor target, allowed: at least one")
        return () if number is None else (number,)

    # ---------------------------------------------------------------- to be overridden

    def get_initial_condition(self) -> Array:
        """Return the first decision (m), shape (2,): where the drone is."""
        return self._position()[:2].copy()

    def get_intruder(self) -> Array | None:
        """Return where the intruder of this drone is at present (m), shape (2,), or None."""
        if not self.watched:
            return self.intruder
        if self.drop_unseen and self._sightings.is_lost(self.watched[0], self.now):
            return None
        return self._sightings.before(self.watched[0], self.now)

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
        """Iterate from now on; take off if the drone is still on the ground."""
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
        """Silent neighbors, and intruders that are not seen; outside the flight only neighbors."""
        if self._phase is not Phase.FLIGHT:
            return frozenset(self.presence.lost)
        unseen = {one for one in self.watched if self._sightings.is_lost(one, self.now)}
        return frozenset(self.presence.lost | unseen)

    def see(self, number: int, pose: Pose) -> None:
        """Take the pose of a drone that is watched.

        Raises:
            RangeError: If its position is not three finite numbers.
        """
        if pose.position is None:
            return
        position = self._checked(f"the position of agent {number}", pose.position)
        self._sightings.see(number, pose.time, position[:2].copy(), self.now)

    # ---------------------------------------------------------------- a round

    def open_round(self, now: float) -> bool:
        """Send, if an iteration is due; see `RoundGuidance`."""
        if self._phase is not Phase.FLIGHT or now < self._next_iteration - _EARLY:
            return False
        if self.max_iterations is not None and self.algorithm and self.algorithm.rounds >= self.max_iterations:
            return False
        problem = self._problem()
        if problem is not None:
            self._agent.set_problem(problem)
        if self._agent.problem is None or self.current_pose is None:
            return False  # neither intruder nor target is known yet, or the own pose is not
        if self.algorithm is None:
            self.algorithm = self._make(self._agent, self.get_initial_condition(), stepsize=self.stepsize, now=now)
            self.algorithm_began(now)
        self._look_around(now)
        while self._next_iteration <= now + _EARLY:
            self._next_iteration += self._iteration_period
        self.algorithm.begin_round(now)
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
        """Reset presence and neighbors; called when the iteration restarts."""
        self.presence.reset()
        self._set_neighbors()

    def has_round(self, now: float) -> bool:
        """See `RoundGuidance`."""
        return self._agent.has_round()

    @property
    def longest_round(self) -> float:
        """See `RoundGuidance`."""
        return self.deadline - _EARLY

    def close_round(self, now: float) -> None:
        """Use what came, and go on without neighbors that are missing."""
        neighbors = self._agent.in_neighbors
        missing = [one for one in neighbors if not self.communicator.has_round([one])]
        self.algorithm.finish_round()
        if not self._agent.is_asynchronous and missing:
            self._change(lost=self.presence.count(missing, neighbors))
        if self.enable_log:
            self.results.append(self.algorithm.get_result())

    def decide(self, now: float) -> Outputs:
        """Return what to ask for, after an iteration or without one."""
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

    # ---------------------------------------------------------------- presence of neighbors

    def _look_around(self, now: float) -> None:
        """Find the neighbors that are back, and in asynchronous mode those that fell silent."""
        if self._agent.is_asynchronous:
            self._change(*self.presence.look(now, self.communicator.in_neighbors, self.silence))
        else:
            self.communicator.catch_up()
            self._change(back=self.presence.welcome(LATE_ROUNDS))

    def _change(self, lost: Sequence[int] = (), back: Sequence[int] = ()) -> None:
        """Go on without neighbors, and with others again."""
        for method, neighbors in (("leave", lost), ("rejoin", back)):
            if neighbors and hasattr(self.algorithm, method):
                getattr(self.algorithm, method)(neighbors)
        if lost or back:
            self._set_neighbors()

    def _set_neighbors(self) -> None:
        communicator = self.communicator
        heard = [one for one in communicator.in_neighbors if one not in self.presence.lost]
        self._agent.set_neighbors(heard, communicator.out_neighbors)


class AggregativeGuidanceCrazyflie(AggregativeGuidance):
    """The guidance of CrazyChoir's examples with intruders that stand still."""


class AggregativeGuidanceCrazyflieMovingIntruder(AggregativeGuidanceCrazyflie):
    """The intruder is a drone that is watched: by default that whose number is larger by the number of defenders."""

    intruder_moves = True


def _same(one: Array | None, other: Array | None) -> bool:
    return one is other if one is None or other is None else bool((one == other).all())


def _optimizer(optimizer: str | type) -> Callable[..., Any]:
    """Return what makes an optimization of agent, initial condition, stepsize and time."""
    kind: Any = getattr(optimization, optimizer) if isinstance(optimizer, str) else optimizer
    if isinstance(kind, type) and issubclass(kind, optimization.ResilientAggregativeTracking):
        # time in ms, so that an agent has a larger session number after each restart
        return lambda agent, start, stepsize, now: kind(agent, start, stepsize=stepsize, session=int(1000.0 * now))
    return lambda agent, start, stepsize, now: kind(agent, start, stepsize=stepsize)
