"""Common part of tables: they offer work to agents, receive reports, and detect agents that are gone.

A table never assigns work. It announces a new list by a label. Each agent requests its own list; the agents agree among
themselves, and report decisions and results. Time is that of the caller of `step`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.schemes.ranges import above_zero

LABELS_SKIPPED = 100
"""By a table that goes on from a memory, so that its lists are newer than any that were announced meanwhile, and agents
know that what they said last may not have been heard."""

Note = Callable[..., None]
"""`note(kind, agent, details)` records an event; agent is None for an event of the table itself."""


@dataclass(frozen=True)
class Offer:
    """What one agent gets when it asks for its list."""

    label: int
    """Which list: later ones have larger labels."""
    items: tuple[Any, ...]
    """What the agent can do."""


class DispatchTable(ABC):
    """A table of work for a number of agents.

    An agent that does not request its list within the deadline counts as gone until it requests one again; work that no
    other agent can do is taken back. If no work is finished for a while, the list is announced again. So the work of an
    agent that fell silent in the middle of it goes to others.

    Attributes:
        agents: How many agents there are.
        label: Label of the present list; 0 before the first.
        gone: Agents that count as gone.
        finished: How much work was finished.
    """

    def __init__(self, agents: int, *, deadline: float = 1.0, patience: float = 30.0, start_delay: float = 0.5) -> None:
        """Prepare; nothing is offered before `start`.

        Args:
            agents: How many agents there are.
            deadline: How long an agent may take to ask for its list (s).
            patience: After so long without anything finished the list is announced again (s).
            start_delay: From START to the first list (s), so that START has reached all agents.

        Raises:
            RangeError: If a number is outside its range.
        """
        if agents < 1:
            raise RangeError(f"table: agents is {agents}, allowed: 1 or more")
        above_zero("table", deadline=deadline, patience=patience)
        if not (math.isfinite(start_delay) and start_delay >= 0.0):
            raise RangeError(f"table: start_delay is {start_delay}, allowed: 0 s or more")
        self.agents = agents
        self.deadline = deadline
        self.patience = patience
        self.start_delay = start_delay
        self.label = 0
        self.gone: set[int] = set()
        self.finished = 0
        self.note: Note = lambda kind, agent, details: None
        """Told of everything that happens."""
        self._listeners: list[Callable[[int], None]] = []
        self._now = 0.0
        self._begins: float | None = None
        self._announced = self._progress = 0.0
        self._asked: set[int] = set()
        self._decided: set[int] = set()
        self._taken: set[int] = set()
        self._left: list[int] = []  # items of the present list that no agent took
        self._has_looked = True

    # ---------------------------------------------------------------- for the process that runs it

    def listen(self, callback: Callable[[int], None]) -> None:
        """Call `callback(label)` at each new list."""
        self._listeners.append(callback)

    def start(self, now: float) -> None:
        """Begin after the delay; the first time only."""
        if self._begins is None:
            self._begins = now + self.start_delay

    def memory(self) -> dict[str, Any]:
        """Return what `remember` needs: plain numbers, lists and mappings."""
        return {"label": self.label, "finished": self.finished, "gone": sorted(self.gone), **self._memory()}

    def remember(self, memory: Mapping[str, Any], now: float) -> None:
        """Replace a table of the same arguments: take over its memory, and announce its list again.

        Args:
            memory: As of `memory`, of a table that had begun.
            now: Time (s).

        Raises:
            RangeError: If it is no such memory, or this table has begun itself.
        """
        if self.label:
            raise RangeError(f"table: it has begun, label {self.label}, allowed: a new one")
        try:
            label, finished = int(memory["label"]), int(memory["finished"])
            gone = {int(one) for one in memory["gone"]}
            if label < 1 or finished < 0 or not gone <= set(range(self.agents)):
                raise ValueError(f"label {label}, finished {finished}, gone {sorted(gone)}")
            self._remember(memory)
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise RangeError(f"table: not the memory of one like this: {error!r}") from None
        self.label, self.finished, self.gone = label + LABELS_SKIPPED, finished, gone
        self._now = self._begins = self._progress = now
        self.announce()

    def step(self, now: float) -> None:
        """Look at the time (s)."""
        self._now = now
        if self._begins is None or now < self._begins - 1e-9:
            return
        if self.label == 0:
            self._begin()
            self.announce()
        elif not self._has_looked and now - self._announced >= self.deadline:
            self._look()
        elif not self.is_done and now - max(self._announced, self._progress) >= self.patience:
            self.note("again", None, {"label": self.label + 1})
            self.announce()

    def announce(self) -> None:
        """Notify all listeners of a new list."""
        self.label += 1
        self._announced = self._now
        self._asked, self._decided, self._taken, self._left = set(), set(), set(), []
        self._has_looked = False
        for listener in self._listeners:
            listener(self.label)

    def _look(self) -> None:
        """Detect agents that did not request the list."""
        self._has_looked = True
        gone = set(range(self.agents)) - self._asked
        for agent in sorted(gone - self.gone):
            self.note("gone", agent, {"label": self.label})
        self.gone = gone
        if self._living and self._take_back():
            self.announce()

    @property
    def _living(self) -> set[int]:
        return set(range(self.agents)) - self.gone

    # ---------------------------------------------------------------- for agents

    def request(self, agent: int, callback: Callable[[Offer], None]) -> None:
        """Request the list of an agent; the callback gets it at once or later.

        Raises:
            RangeError: If there is no such agent.
        """
        self._known(agent)
        if self.label == 0:
            return
        if agent in self.gone:
            self.gone.discard(agent)
            self.note("back", agent, {"label": self.label + 1})
            self.announce()
        self._asked.add(agent)
        callback(Offer(self.label, tuple(self._items_of(agent))))

    def report(self, agent: int, decision: Mapping[str, Any]) -> None:
        """Hear what an agent is going to do.

        Args:
            agent: Which one.
            decision: `label` of the list, `takes` (numbers of what it does, may be empty), and what else is worth
                telling.

        Raises:
            RangeError: If there is no such agent.
        """
        self._known(agent)
        self.note("assigned", agent, decision)
        if decision.get("label") != self.label:
            return
        self._decided.add(agent)
        self._taken |= set(decision.get("takes", ()))
        if self._decided >= self._asked and self._has_all_asked:
            self._left = sorted(self._open - self._taken)
            self.note("agreed", None, {"label": self.label, "left": self._left})

    @property
    def _has_all_asked(self) -> bool:
        return self._has_looked or len(self._asked | self.gone) >= self.agents

    def complete(self, agent: int, number: int) -> bool:
        """Hear that an agent has finished something; False if that was not open, or not its own.

        Raises:
            RangeError: If there is no such agent.
        """
        self._known(agent)
        if not self._finish(agent, number):
            self.note("refused", agent, {"number": number})
            return False
        self._progress = self._now
        return True

    def _known(self, agent: int) -> None:
        if not 0 <= agent < self.agents:
            raise RangeError(f"table: agent is {agent}, allowed: [0, {self.agents - 1}]")

    # ---------------------------------------------------------------- what a table offers

    @abstractmethod
    def _begin(self) -> None:
        """Make the first list."""

    @abstractmethod
    def _items_of(self, agent: int) -> list[Any]:
        """Return what an agent can do."""

    @abstractmethod
    def _finish(self, agent: int, number: int) -> bool:
        """Finish something; False if that cannot be."""

    @abstractmethod
    def _take_back(self) -> bool:
        """Take back what only agents can do that are gone; returns whether the list has changed."""

    @abstractmethod
    def _memory(self) -> dict[str, Any]:
        """Return the state of the subclass: all but label, count of finished work, and agents that are gone."""

    @abstractmethod
    def _remember(self, memory: Mapping[str, Any]) -> None:
        """Take over such a memory; whatever is wrong with it may raise KeyError, TypeError or ValueError."""

    @property
    @abstractmethod
    def _open(self) -> set[int]:
        """Numbers of what is to be done."""

    @property
    def is_done(self) -> bool:
        """Whether nothing is left to be done."""
        return self.label > 0 and not self._open
