"""What guidance has in common that shares out the work of a table by distributed simplex, a round per step."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np

from crazychoir_fw.guidance.cf_guidance import Phase
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.law import POSES, NodeFace, option
from crazychoir_fw.guidance.optimization import Agent, DistributedSimplex, LinearProblem
from crazychoir_fw.guidance.optimization.algorithm import Array
from crazychoir_fw.guidance.outputs import Outputs
from crazychoir_fw.guidance.round_guidance import RoundGuidance
from crazychoir_fw.guidance.schemes.tasks.dispatch_table import LABELS_SKIPPED, Offer
from crazychoir_fw.guidance.schemes.tasks.position_task_executor import PositionTaskExecutor

ROUNDS_PER_LIST = 10_000
"""Labels of rounds begin at the label of the list times this, so that rounds of different lists never meet."""

_SILENT_ROUNDS = 2  # in a row, after which no round waits for a neighbor until the next list
_GATHERING_S = 0.5  # for which the first round of a list waits for neighbors
_ASK_AGAIN_S = 1.0  # timeout, after which an agent requests a list again


class Desk(Protocol):
    """A table as agents see it; `DispatchTable` is one, and so is a node that asks one by services."""

    def listen(self, callback: Callable[[int], None]) -> None:
        """Call `callback(label)` at each new list."""

    def request(self, agent: int, callback: Callable[[Offer], None]) -> None:
        """Request the list of an agent; the callback gets it at once, later, or never."""

    def report(self, agent: int, decision: Mapping[str, Any]) -> None:
        """Tell what an agent is going to do."""

    def complete(self, agent: int, number: int) -> object:
        """Tell that an agent has finished something."""


class LabeledSimplex(DistributedSimplex):
    """A distributed simplex that hears nothing but what belongs to the same list."""

    def __init__(self, agent: Agent, label: int, big_M: float) -> None:
        """Begin; arguments and errors are those of `DistributedSimplex`.

        Args:
            agent: The agent that runs it, with its problem.
            label: Label of the list.
            big_M: Cost of leaving one unit of a row's right side without a column.
        """
        self.label = label
        super().__init__(agent, big_M=big_M)

    def _message(self) -> Any:
        return {"label": self.label, "basis": self.B}

    def _update(self, received: Mapping[int, Any]) -> None:
        bases = {one: basis for one, message in received.items() if (basis := self._basis_of(message)) is not None}
        super()._update(bases)

    def _basis_of(self, message: Any) -> Array | None:
        if not isinstance(message, Mapping) or message.get("label") != self.label:
            return None
        basis = message.get("basis")
        is_one = isinstance(basis, np.ndarray) and basis.shape == self.B.shape and np.isfinite(basis).all()
        return basis if is_one else None


class DispatchGuidance(RoundGuidance):
    """Takes off, does what it gets of a table's work from START on, hovers while it has none, lands.

    At each new list: ask for the own part, end an optimization that still runs, begin a new one, and after
    `max_iterations` rounds do what the result says. Nothing waits: a step begins or ends a round. A neighbor that is
    silent costs half a second and a deadline per list.

    A drone that is not in flight takes part without work of its own, so that others hear of each other through it.
    """

    is_paced_by_rounds = False
    """Steps go on while a round waits for a neighbor: that neighbor may need a step before it begins the round."""
    node = NodeFace(positional=POSES)

    height: float = option(0.5, "height at which drone 0 flies", "m", above=0)
    height_step: float = option(0.15, "so much higher flies each further drone", "m", low=0)
    max_iterations: int = option(
        20,
        "rounds of an optimization, at least the longest way between two drones in the graph",
        low=1,
        high=ROUNDS_PER_LIST // 100 - 1,
    )
    tolerance: float = option(0.05, "level distance at which a place is reached", "m", above=0)
    speed: float = option(0.5, "mean speed of flights", "m/s", above=0)
    duration: float | None = option(None, "duration of every flight, instead of the speed", "s", above=0, kind=float)
    big_M: float = option(500.0, "cost of leaving something undone, more than doing all of it", "m")  # noqa: N815

    def __init__(self, agent_id: int, communicator: TopicCommunicator, **options: Any) -> None:
        """Prepare; arguments and errors are those of `RoundGuidance`."""
        super().__init__(agent_id, communicator, **options)
        self.height += self.height_step * agent_id
        self.executor = PositionTaskExecutor(
            self.height, tolerance=self.tolerance, speed=self.speed, duration=self.duration
        )
        self._told_lost: frozenset[int] = frozenset()
        self.unable: str | None = None
        """Why it takes no more work, a sentence."""
        self._desk: Desk | None = None
        self._newest = 0  # label of the newest list that was announced to it
        self._asked_at: float | None = None  # since when it waits for that list
        self._offer: Offer | None = None  # one that came and is not begun
        self._simplex: LabeledSimplex | None = None

    @property
    def lost(self) -> frozenset[int]:
        """Neighbors that were silent in the last optimization."""
        return self._told_lost

    # ---------------------------------------------------------------- a table

    def connect(self, desk: Desk) -> None:
        """Work for a table."""
        self._desk = desk
        desk.listen(self.hear)

    def hear(self, label: int) -> None:
        """There is a new list."""
        if label > self._newest:
            if self._newest and label - self._newest >= LABELS_SKIPPED:
                self.forget_what_was_said()
            self._newest = label
            self._asked_at = -math.inf
            self._offer = None
            self._halt()

    def _take(self, offer: Offer) -> None:
        if offer.label >= self._newest:
            self._newest = offer.label
            self._offer, self._asked_at = offer, None

    def _halt(self) -> None:
        self._simplex = None
        self.round_open = False

    @property
    def is_optimizing(self) -> bool:
        """Whether an optimization runs."""
        return self._simplex is not None

    @property
    def is_deciding(self) -> bool:
        """Whether there is a list about which nothing was decided yet."""
        return self._simplex is not None or self._offer is not None or self._asked_at is not None

    # ---------------------------------------------------------------- to be overridden

    @abstractmethod
    def problem(self, offer: Offer, now: float) -> LinearProblem:
        """Return this agent's part of the optimization; an agent whose offer has no items takes no part."""

    @abstractmethod
    def conclude(self, simplex: LabeledSimplex, now: float) -> bool:
        """Take the result of an optimization; False if another one has to follow, made by `next_problem`."""

    def next_problem(self) -> LinearProblem:
        """Return this agent's part of an optimization that follows another one."""
        raise NotImplementedError

    @abstractmethod
    def work(self, now: float) -> None:
        """Do what was decided, a step of it."""

    @abstractmethod
    def drop(self) -> None:
        """Have no work any more; START, landing and STOP begin with it."""

    def forget_what_was_said(self) -> None:
        """Take nothing for known to the table but what it offers: it goes on from a memory, which may lack the last."""

    # ---------------------------------------------------------------- a round

    def open_round(self, now: float) -> bool:
        """Send to the neighbors, if an optimization is to be done; see `RoundGuidance`."""
        self._ask(now)
        if self._offer is not None and self.current_pose is not None:
            offer, self._offer = self._offer, None
            self._optimize(self.problem(offer, now), offer.label, first=True)
        if self._simplex is None:
            return False
        self._simplex.begin_round(now)
        return True

    def _ask(self, now: float) -> None:
        """Ask for the newest list, again if it does not come."""
        if self._asked_at is None or self._desk is None or now - self._asked_at < _ASK_AGAIN_S:
            return
        if self._phase is Phase.FLIGHT and self.unable is None:
            self._asked_at = now
            self._desk.request(self.agent_id, self._take)
        else:
            self._take(Offer(self._newest, ()))

    def _optimize(self, problem: LinearProblem, label: int, first: bool) -> None:
        agent = Agent(communicator=self.communicator)
        if first:
            self.presence.reset()
            # neighbors that began earlier are ahead by some rounds: never set the label back
            series = label * ROUNDS_PER_LIST
            self.communicator.current_label = max(self.communicator.current_label, series)
            self._stage = 0
        else:
            self._stage += 1
        agent.set_problem(problem)
        self._wait_for_the_living(agent)
        self._list = label
        self._simplex = LabeledSimplex(agent, label * 100 + self._stage, self.big_M)

    def _wait_for_the_living(self, agent: Agent) -> None:
        heard = [one for one in self.communicator.in_neighbors if one not in self.presence.lost]
        agent.set_neighbors(heard, self.communicator.out_neighbors)

    def has_round(self, now: float) -> bool:
        """See `RoundGuidance`."""
        return self._simplex is None or self._simplex.is_complete()

    @property
    def longest_round(self) -> float:
        """Time after which a round ends (s): lists do not reach all at the same time, so the first one gathers."""
        is_first = self._simplex is not None and self._simplex.rounds == 0 and self._stage == 0
        return max(self.deadline, _GATHERING_S) if is_first else self.deadline

    def close_round(self, now: float) -> None:
        """Receive, and conclude the optimization with its last round."""
        simplex = self._simplex
        if simplex is None:
            return
        self._count_missing(simplex.agent)
        simplex.finish_round()
        if self.communicator.current_label >= (self._list + 1) * ROUNDS_PER_LIST:
            self._halt()  # neighbors have a newer list, which will be announced to this agent as well
        elif simplex.rounds >= self.max_iterations:
            self._conclude(simplex, now)

    def _count_missing(self, agent: Agent) -> None:
        if agent.is_asynchronous:
            return
        neighbors = self.communicator.in_neighbors
        missing = [one for one in neighbors if not self.communicator.has_round([one])]
        lost = self.presence.count(missing, neighbors, _SILENT_ROUNDS)
        if self.presence.welcome() or lost:
            self._wait_for_the_living(agent)

    def _conclude(self, simplex: LabeledSimplex, now: float) -> None:
        self._told_lost = frozenset(self.presence.lost)
        self._simplex = None
        if not self.conclude(simplex, now):
            self._optimize(self.next_problem(), self._list, first=False)

    def decide(self, now: float) -> Outputs:
        """Work, and return what to ask for."""
        if self._phase is Phase.FLIGHT and self.unable is None and self.current_pose is not None:
            self.work(now)
        return self.outputs(now, None)

    # ---------------------------------------------------------------- buttons

    def begin_flight(self, now: float) -> None:
        """Take part from now on."""
        self.drop()
        del now
        self.unable = None
        if self._newest and self._desk is not None:
            self._halt()
            self._asked_at = -math.inf

    def begin_landing(self, now: float) -> None:
        """Drop the work and come down."""
        self.drop()
        super().begin_landing(now)

    def stop(self, now: float) -> None:
        """Drop the work; see `CFGuidance`."""
        self.drop()
        super().stop(now)

    def _tell(self, takes: list[int], upcoming: list[int], **more: Any) -> None:
        """Tell the table what was decided: all that it takes on, and what will be completed, in order."""
        if self._desk is not None and self._phase is Phase.FLIGHT:
            self._desk.report(self.agent_id, {"label": self._list, "takes": takes, "next": upcoming, **more})

    def _give_up(self, sentence: str) -> None:
        """Take no more work, and say why."""
        self.unable = sentence
        if self._desk is not None:
            self._desk.report(self.agent_id, {"label": 0, "takes": [], "next": [], "unable": sentence})
