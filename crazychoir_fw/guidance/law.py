"""What a guidance law says of itself, as data: options, needs and ROS 2 face; missions and nodes read nothing else."""

from __future__ import annotations

import inspect
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from numbers import Integral, Real
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.guidance.graph import Graph


@dataclass(frozen=True)
class Option:
    """An argument of a law: a class attribute that becomes an attribute of each object, checked."""

    default: Any
    what: str
    """What it is, a phrase."""
    unit: str = ""
    above: float | None = None
    """Largest number that is too small."""
    low: float | None = None
    """Smallest number that is allowed."""
    high: float | None = None
    """Largest number that is allowed."""
    choices: tuple[str, ...] = ()
    """Words that are allowed; empty: any."""
    is_finite: bool = True
    """Whether infinity is refused."""
    kind: Any = None
    """float, int, bool, str or a list of them, as ROS parameters have it; None: as the default; object: anything."""

    @property
    def type(self) -> Any:
        """Type of plain values, or None where any object is taken."""
        if self.kind is not None:
            return None if self.kind is object else self.kind
        return type(self.default) if isinstance(self.default, bool | int | float | str) else None

    @property
    def allowed(self) -> str:
        """Allowed values, in words."""
        if self.choices:
            return ", ".join(self.choices)
        if self.low is not None and self.high is not None:
            words = f"[{self.low:g}, {self.high:g}]"
        else:
            words = f"above {self.above:g}" if self.above is not None else ""
            words = f"{self.low:g} or more" if self.low is not None else words
            words += (
                (f", at most {self.high:g}" if words else f"at most {self.high:g}") if self.high is not None else ""
            )
        return f"{words or 'a number'} {self.unit}".rstrip()

    def checked(self, who: str, name: str, value: Any) -> Any:
        """Return a value as the law keeps it.

        Args:
            who: Names the agent, in the error.
            name: Name of the option.
            value: The value.

        Raises:
            RangeError: If a number is outside its range.
            UnknownNameError: If a word is none of the choices.
        """
        if self.choices and isinstance(value, str) and value not in self.choices:
            raise UnknownNameError(f"{who}: {name} is '{value}', allowed: {self.allowed}")
        if self.type not in (float, int) or (value is None and self.default is None):
            return value
        if not self._is_inside(value):
            raise RangeError(f"{who}: {name} is {value}, allowed: {self.allowed}")
        return self.type(value)

    def _is_inside(self, value: Any) -> bool:
        if not isinstance(value, Integral if self.type is int else Real) or isinstance(value, bool):
            return False
        if math.isnan(value) or (self.is_finite and math.isinf(value)):
            return False
        return (
            (self.above is None or value > self.above)
            and (self.low is None or value >= self.low)
            and (self.high is None or value <= self.high)
        )


def option(default: Any, what: str, unit: str = "", **limits: Any) -> Any:
    """Return an `Option` for the body of a law, typed so that its attribute may be used as a value."""
    return Option(default, what, unit, **limits)


@cache
def options_of(law: type) -> Mapping[str, Option]:
    """Return the options of a law by name, those of its bases first."""
    found: dict[str, Option] = {}
    for cls in reversed(law.__mro__):
        found |= {name: value for name, value in vars(cls).items() if isinstance(value, Option)}
    return MappingProxyType(found)


@cache
def arguments_of(law: type) -> tuple[str, ...]:
    """Return the names of all arguments of a law: those of its constructors, and its options."""
    names: list[str] = []
    for cls in law.__mro__:
        if "__init__" not in vars(cls):
            continue
        parameters = list(inspect.signature(vars(cls)["__init__"]).parameters.values())[1:]
        names += [one.name for one in parameters if one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY)]
        if all(one.kind is not one.VAR_KEYWORD for one in parameters):
            return tuple(dict.fromkeys(names))
    return tuple(dict.fromkeys([*names, *options_of(law)]))


@dataclass(frozen=True)
class Needs:
    """What a mission must say so that a law can fly."""

    graph: bool = False
    """Neighbors: the law does nothing without."""
    leaders: bool = False
    """At least one leader."""
    planning_of_leaders: bool = False
    """A trajectory handler for each leader."""
    goals: bool = False
    """Goals by drone; laws that merely take them have an argument of that name."""
    formation: bool | None = None
    """A place for each drone: True is required, False is refused."""
    formation_or: str = ""
    """Option that replaces the formation."""
    table: str = ""
    """Section of `layers` with the table that all drones work for: tasks or delivery."""


@dataclass(frozen=True)
class LawContext:
    """What a mission says of the drones that one law flies."""

    law: type
    """Class of the law."""
    names: tuple[str, ...]
    """Of all drones of the mission."""
    members: tuple[int, ...]
    """Numbers of the drones that the law flies."""
    graph: Graph
    """Graph of communication among all drones."""
    leaders: tuple[int, ...] = ()
    """Numbers of the leaders."""
    formation: NDArray[np.float64] | None = None
    """Places (m), shape (N, 3); drones that the law does not fly are at 0."""
    height: float = 1.0
    """Of the take-off (m)."""
    options: Mapping[int, Mapping[str, Any]] = field(default_factory=dict)
    """Options that the mission sets, by number of the drone."""

    @property
    def followers(self) -> list[int]:
        """Numbers of the members that do not lead."""
        return [i for i in self.members if i not in self.leaders]

    def option(self, name: str, default: Any = None) -> Any:
        """Return an option of the first member."""
        return self.options.get(self.members[0], {}).get(name, default)


POSES = ("pose_handler", "pose_topic", "pose_callback")
"""Arguments of every node that say where poses come from."""


@dataclass(frozen=True)
class NodeFace:
    """How a law looks as a ROS 2 node, beyond its options, which are parameters and keyword arguments of the node."""

    name: str = "guidance"
    """Fixed name of the node."""
    positional: tuple[str, ...] = ("update_frequency", *POSES)
    """Arguments of the node that may be given without their name, in order."""
    defaults: Mapping[str, Any] = field(default_factory=dict)
    """Defaults of arguments that differ from those of the law."""
    aliases: Mapping[str, str] = field(default_factory=dict)
    """Other names of arguments; those without effect stand for an empty name."""
    parameters: Mapping[str, Option] = field(default_factory=dict)
    """Parameters beside the options, see `CFGuidance.from_parameters`."""
    velocity_topic: str = ""
    """Topic of the velocity of each reference, beside the reference itself."""
