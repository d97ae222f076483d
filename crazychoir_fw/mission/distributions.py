"""How a value varies from flight to flight: each distribution turns a share of [0, 1] into a value.

A design draws the shares, so that one text serves random draws, Latin hypercubes, Sobol sequences and grids.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from statistics import NormalDist
from typing import Any

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.mission.values import did_you_mean
from crazychoir_fw.mission.wording import show


@dataclass(frozen=True)
class Distribution:
    """A distribution of one number, or of one entry of a list."""

    kind: str
    """One of `KINDS`."""
    numbers: tuple[float, ...] = ()
    """What the kind needs, in the order of its keys."""
    options: tuple[Any, ...] = ()
    """Entries of ``choice``."""
    low: float = -math.inf
    """Values below are not drawn."""
    high: float = math.inf
    """Values above are not drawn."""

    def at(self, share: float) -> Any:
        """Return the value below which this share of all values lies; of ``choice`` the entry there."""
        if self.kind == "choice":
            return self.options[min(int(share * len(self.options)), len(self.options) - 1)]
        below, above = self._share_below(self.low), self._share_below(self.high)
        share = min(max(share, 1e-12), 1.0 - 1e-12)  # a normal distribution has no ends
        return min(max(self._value(below + share * (above - below)), self.low), self.high)

    def _value(self, share: float) -> float:
        """Return the quantile of the whole distribution."""
        a, b, *rest = self.numbers
        match self.kind:
            case "normal":
                return NormalDist(a, b).inv_cdf(min(max(share, 1e-15), 1.0 - 1e-15))
            case "uniform":
                return a + share * (b - a)
            case "log_uniform":
                return a * (b / a) ** share
        (c,) = rest
        if share * (c - a) <= b - a:
            return a + math.sqrt(share * (c - a) * (b - a))
        return c - math.sqrt((1.0 - share) * (c - a) * (c - b))

    def _share_below(self, value: float) -> float:
        """Return which share of the whole distribution lies below a value."""
        a, b, *rest = self.numbers
        if self.kind == "normal":
            return NormalDist(a, b).cdf(value)
        low, high = a, rest[0] if rest else b
        if value <= low or value >= high:
            return float(value >= high)
        match self.kind:
            case "uniform":
                return (value - a) / (b - a)
            case "log_uniform":
                return math.log(value / a) / math.log(b / a)
        if value <= b:
            return (value - a) ** 2 / ((high - a) * (b - a))
        return 1.0 - (high - value) ** 2 / ((high - a) * (high - b))

    @property
    def text(self) -> str:
        """In words, for tables."""
        if self.kind == "choice":
            return "one of " + ", ".join(map(str, self.options))
        inner = ", ".join(f"{number:.4g}" for number in self.numbers)
        cut = f" in [{self.low:.4g}, {self.high:.4g}]" if math.isfinite(self.low) or math.isfinite(self.high) else ""
        return f"{self.kind}({inner}){cut}"


KINDS = {
    "normal": "{normal: {mean: 0, std: 1}}",
    "uniform": "{uniform: [0, 1]}",
    "log_uniform": "{log_uniform: [0.1, 10]}",
    "triangular": "{triangular: [low, mode, high]}",
    "choice": "{choice: [a, b]}",
}
"""The kinds, each with how it is written."""


def read_distribution(where: str, given: Any) -> Distribution:
    """Return the distribution that a campaign file describes, such as ``{normal: {mean: 0.029, std: 0.001}}``.

    Beside the kind, ``low`` and ``high`` cut it off.

    Args:
        where: Its place in the file, for messages.
        given: What stands there.

    Raises:
        MissionError: If it is none; the text says what is allowed.
    """
    if not isinstance(given, Mapping):
        raise MissionError(f"{where} is {show(given)}, but must be a distribution such as {KINDS['normal']}")
    kinds = [key for key in given if key in KINDS]
    unknown = [key for key in given if key not in KINDS and key not in ("low", "high")]
    if unknown or len(kinds) != 1:
        hint = did_you_mean(unknown[0], KINDS) if unknown else ""
        raise MissionError(
            f"{where} is {show(given)}, but must have one of {', '.join(KINDS)}{hint}, perhaps low, high"
        )
    kind = kinds[0]
    low, high = (
        _number(f"{where}.{key}", given.get(key, end)) for key, end in (("low", -math.inf), ("high", math.inf))
    )
    if kind == "choice":
        return Distribution(kind, options=_options(where, given[kind]))
    numbers = _normal(where, given[kind]) if kind == "normal" else _ordered(where, kind, given[kind])
    if not low < high:
        raise MissionError(f"{where}: low is {low:g} and high {high:g}, but low must be below high")
    found = Distribution(kind, numbers, low=low, high=high)
    _check_cut(where, found)
    return found


def _number(where: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, Real) or math.isnan(value):
        raise MissionError(f"{where} is {show(value)}, but must be a number")
    return float(value)


def _normal(where: str, given: Any) -> tuple[float, ...]:
    if not isinstance(given, Mapping) or set(given) != {"mean", "std"}:
        raise MissionError(f"{where}.normal is {show(given)}, but must be a mapping such as {{mean: 0, std: 1}}")
    mean, std = (_number(f"{where}.normal.{key}", given[key]) for key in ("mean", "std"))
    if not (math.isfinite(mean) and 0.0 < std < math.inf):
        raise MissionError(f"{where}.normal is {show(given)}, but must have a finite mean and a std above 0")
    return mean, std


def _ordered(where: str, kind: str, given: Any) -> tuple[float, ...]:
    """Return numbers that increase."""
    count = 3 if kind == "triangular" else 2
    must = f"a list of {count} numbers that increase, such as {KINDS[kind]}"
    if not isinstance(given, Sequence) or isinstance(given, str) or len(given) != count:
        raise MissionError(f"{where}.{kind} is {show(given)}, but must be {must}")
    numbers = tuple(_number(f"{where}.{kind}[{k}]", value) for k, value in enumerate(given))
    increases = numbers[0] < numbers[-1] and list(numbers) == sorted(numbers) and all(map(math.isfinite, numbers))
    if not increases or (kind == "log_uniform" and numbers[0] <= 0.0):
        above = ", above 0" if kind == "log_uniform" else ""
        raise MissionError(f"{where}.{kind} is {show(given)}, but must be {must}{above}")
    return numbers


def _options(where: str, given: Any) -> tuple[Any, ...]:
    if not isinstance(given, Sequence) or isinstance(given, str) or not given:
        raise MissionError(f"{where}.choice is {show(given)}, but must be a list of at least one entry")
    return tuple(given)


def _check_cut(where: str, found: Distribution) -> None:
    """Refuse a distribution of which nothing is left."""
    if not found._share_below(found.high) - found._share_below(found.low) > 1e-9:
        raise MissionError(f"{where} is {found.text}, but low and high must leave some of it")
