"""The key `layers.communication` of a mission file: the communication graph and its quality."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag, model_validator
from pydantic_core import core_schema as schemas

from crazychoir_fw.common.constraints import Constraint, choice, listed, number, switch, whole
from crazychoir_fw.mission.section import Section
from crazychoir_fw.mission.values import refusal

GRAPHS = ("complete", "ring", "path")
"""Graphs by name: everybody with everybody, each with the next one in a ring, or in a row."""

RULES = ("random", "within_distance", "random_edges", "schedule")
"""Graphs by rule."""


def _pairs(value: tuple[tuple[str, str], ...]) -> tuple[tuple[str, str], ...]:
    if any(a == b for a, b in value):
        raise ValueError("an edge of a drone with itself")
    return value


def _fixed_graph() -> Constraint:
    """A graph by name, or a list of pairs of ids."""
    name = schemas.str_schema(strict=True)
    pairs = schemas.tuple_schema([listed(schemas.tuple_schema([name, name]))], variadic_item_index=0)
    return Constraint(
        schemas.union_schema(
            [schemas.literal_schema(list(GRAPHS)), schemas.no_info_after_validator_function(_pairs, listed(pairs))]
        ),
        f"{', '.join(GRAPHS)}, a list of pairs of ids such as [[agent_0, agent_1]], or "
        "{random: {probability: 0.2, seed: 1}}, {within_distance: 1.5}, {random_edges: {probability: 0.8}}, "
        "{schedule: [{at: 0, graph: ring}]}",
        (*GRAPHS, *RULES),
    )


# tags with # are left out of messages
AnyGraph = Annotated[
    Annotated[Any, _fixed_graph(), Tag("#fixed")] | Annotated["Graph", Tag("#rule")],
    Discriminator(lambda value: "#rule" if isinstance(value, Mapping | Graph) else "#fixed"),
]
"""Communication graph: `complete`, `ring`, `path`, pairs of ids, or a `Graph`."""


class RandomGraph(Section):
    """A connected random graph, the same for the same seed."""

    probability: Annotated[float, number(0.0, 1.0)] = 0.2
    """That two drones talk to each other."""

    seed: Annotated[int, whole(0, 2**32 - 1)] = 0
    """Seed of the draw."""


class RandomEdges(Section):
    """Edges that are there or not, redrawn every few rounds."""

    probability: Annotated[float, number(0.0, 1.0)] = 0.8
    """That an edge is there."""

    seed: Annotated[int, whole(0, 2**32 - 1)] = 0
    """Seed of the draws."""

    rounds: Annotated[int, whole(1, 1_000_000)] = 1
    """How many rounds a draw holds."""


class From(Section):
    """A graph that holds from a time on."""

    at: Annotated[float, number(0.0, 1e6, "s")]
    """Begin, since the first button (s)."""

    graph: AnyGraph = ()
    """A graph that does not change."""


class Graph(Section):
    """A graph by rule. All but `random` change with time, and are parts of the graph `of`."""

    random: RandomGraph | None = None
    """A connected random graph."""

    within_distance: Annotated[float, number(0.01, 1000.0, "m")] | None = None
    """Distance within which drones receive each other (m)."""

    random_edges: RandomEdges | None = None
    """Edges at random."""

    schedule: Annotated[list[From], Field(min_length=1)] | None = None
    """Graphs one after the other."""

    period: Annotated[float, number(0.001, 1e6, "s")] | None = None
    """After which a schedule restarts (s)."""

    of: AnyGraph = "complete"
    """The largest graph, for `within_distance` and `random_edges`."""

    @property
    def changes(self) -> bool:
        """Whether it is another one at other times."""
        return self.random is None

    @model_validator(mode="after")
    def _one_rule(self) -> Graph:
        rules = [name for name in RULES if getattr(self, name) is not None]
        if len(rules) != 1:
            raise refusal(f"a graph by one rule of {', '.join(RULES)}")
        if self.period is not None and (self.schedule is None or self.period <= self.schedule[-1].at):
            raise refusal("a period beyond the last graph of a schedule", ".period")
        begins = [one.at for one in self.schedule or ()]
        if begins != sorted(begins):
            raise refusal("a schedule in order of at", ".schedule")
        return self


class Communication(Section):
    """The communication graph, and how messages travel."""

    graph: AnyGraph = ()
    """`complete`, `ring`, `path`, pairs of ids, or a graph by rule: `random`, or one that changes. Without it no drone
    talks."""

    directed: Annotated[bool, switch()] = False
    """Whether messages of a pair [a, b] go from a to b only; otherwise both ways."""

    mode: Annotated[str, choice("lockstep", "asynchronous")] = "lockstep"
    """`lockstep` waits in each round until all neighbors were heard, or the deadline is over; `asynchronous` takes what
    has come."""

    deadline_s: Annotated[float, number(0.001, 10.0, "s")] = 0.05
    """Longest wait for a neighbor in a round; a silent neighbor is left out until its messages arrive again."""

    silence_s: Annotated[float, number(0.01, 60.0, "s")] = 0.5
    """After which a neighbor that is not heard is lost: it is reported, and no drone waits for it. Where simulated time
    stands still, in lockstep over ROS, by the clock on the wall."""

    differentiated_topics: Annotated[bool, switch()] = False
    """One topic per receiver, so that guidance may send each neighbor something else."""

    loss: Annotated[float, number(0.0, 1.0)] = 0.0
    """Share of messages that get lost on purpose, each for each receiver, by the seed of the mission."""

    delay_s: Annotated[float, number(0.0, 10.0, "s")] = 0.0
    """Least time that a message takes (s)."""

    jitter_s: Annotated[float, number(0.0, 10.0, "s")] = 0.0
    """Most time that it takes beyond that (s)."""

    duplication: Annotated[float, number(0.0, 1.0)] = 0.0
    """Share of messages that come twice."""

    @property
    def is_disturbed(self) -> bool:
        """Whether messages get lost, late or doubled on purpose."""
        return any((self.loss, self.delay_s, self.jitter_s, self.duplication))
