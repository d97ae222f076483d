"""What the numbers and words of a fault may be, said once for scripts and for mission files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from numbers import Integral, Real
from typing import Any


@dataclass(frozen=True)
class Rule:
    """The allowed values of one member."""

    def __str__(self) -> str:
        return "anything"

    def allows(self, value: Any) -> bool:
        """Tell whether a value is allowed."""
        return True


@dataclass(frozen=True)
class Number(Rule):
    """A real number in [low, high]."""

    low: float
    high: float
    unit: str = ""

    def __str__(self) -> str:
        return f"a number in [{self.low:g}, {self.high:g}] {self.unit}".rstrip()

    def allows(self, value: Any) -> bool:
        """Tell whether it is a number within the range; NaN and booleans are not."""
        return isinstance(value, Real) and not isinstance(value, bool) and self.low <= value <= self.high


@dataclass(frozen=True)
class Whole(Rule):
    """A whole number in [low, high]."""

    low: int
    high: int

    def __str__(self) -> str:
        return f"a whole number in [{self.low}, {self.high}]"

    def allows(self, value: Any) -> bool:
        """Tell whether it is a whole number within the range."""
        return isinstance(value, Integral) and not isinstance(value, bool) and self.low <= value <= self.high


@dataclass(frozen=True)
class Word(Rule):
    """One of a few words."""

    known: tuple[str, ...]

    def __str__(self) -> str:
        return "one of " + ", ".join(self.known)

    def allows(self, value: Any) -> bool:
        """Tell whether it is one of them."""
        return isinstance(value, str) and value in self.known


@dataclass(frozen=True)
class Switch(Rule):
    """True or false."""

    def __str__(self) -> str:
        return "true or false"

    def allows(self, value: Any) -> bool:
        """Tell whether it is a boolean."""
        return isinstance(value, bool)


@dataclass(frozen=True)
class Vector(Rule):
    """Three numbers, each in [-most, most]."""

    most: float
    unit: str

    def __str__(self) -> str:
        return f"numbers [x, y, z] in [{-self.most:g}, {self.most:g}] {self.unit}"

    def allows(self, value: Any) -> bool:
        """Tell whether there are three of them, each within the range."""
        number = Number(-self.most, self.most)
        is_list = isinstance(value, Sequence) and not isinstance(value, str | bytes)
        return is_list and len(value) == 3 and all(number.allows(entry) for entry in value)


@dataclass(frozen=True)
class Names(Rule):
    """Ids of drones."""

    def __str__(self) -> str:
        return "a list of at least one id of a drone"

    def allows(self, value: Any) -> bool:
        """Tell whether it is a list of words that is not empty."""
        is_list = isinstance(value, Sequence) and not isinstance(value, str | bytes)
        return is_list and len(value) > 0 and all(isinstance(entry, str) for entry in value)


def ruled(rule: Rule, default: Any) -> Any:
    """Return a dataclass field whose values obey a rule; None is allowed where it is the default."""
    return field(default=default, metadata={"rule": rule})
