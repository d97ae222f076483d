"""The numbers of the vehicles: one YAML file per platform, and overrides of single ones.

`parameters` reads a platform; `overrides` turns what a user wrote (a mapping, a YAML file, the name of a file of this
folder, or several of them) into plain values by dotted name.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from numbers import Real
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.common.plain_yaml import read_yaml

__all__ = ["NAMED", "Overrides", "Parameter", "Value", "as_text", "changes_of", "overrides", "parameters"]

_FOLDER = Path(__file__).resolve().parent
_PLATFORMS = ("cf2", "cf21bl")

NAMED = ("kit", "legacy", "nanobench")
"""Files of this folder that change a platform in part."""

_BOTH = "rotors.time_constant"
"""Short for the two time constants."""

Value: TypeAlias = "float | str | bool | tuple[float, ...]"
Overrides: TypeAlias = "str | Path | Mapping[str, Any] | Sequence[str | Path | Mapping[str, Any]]"


@dataclass(frozen=True)
class Parameter:
    """One number (or vector, or choice) of a vehicle."""

    name: str
    """Dotted name, such as ``rotors.time_constant_up``."""
    value: Value
    """On this platform, in `unit`."""
    unit: str
    """Empty for a choice, ``1`` for a plain number."""
    meaning: str
    """What it is, in a few words."""
    size: int
    """How many numbers belong to it."""
    choices: tuple[str, ...]
    """Words that it may be; empty for numbers."""
    lowest: float
    """Least allowed number, in `unit`."""
    highest: float
    """Greatest allowed number."""
    is_whole: bool
    """Whether only whole numbers are allowed."""
    source: str
    """Where the value comes from; the head of the file spells the abbreviations out."""
    note: str
    """What else there is to say."""
    likely: tuple[float, float] | None
    """What real vehicles spread over."""

    @property
    def allowed(self) -> str:
        """What it may be, in words."""
        if self.choices:
            return " | ".join(self.choices)
        count = f"{self.size} numbers, each " if self.size > 1 else ""
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{count}{'a whole number ' if self.is_whole else ''}{self.lowest:g} to {self.highest:g}{unit}"

    def check(self, value: Any) -> Value:
        """Return a value in its plain form.

        Raises:
            RangeError: If it is not allowed.
        """
        if self.choices:
            word = {False: "off", True: "on"}.get(value, value) if isinstance(value, bool) else value
            if isinstance(word, str) and word in self.choices:
                return word
        elif self.size == 1:
            value = _number(value)
            if self._is_number(value):
                return float(value)
        elif isinstance(value, Sequence | np.ndarray) and not isinstance(value, str):
            numbers = [_number(number) for number in value]
            if len(numbers) == self.size and all(self._is_number(number) for number in numbers):
                return tuple(float(number) for number in numbers)
        raise RangeError(f"vehicle: {self.name} is {str(value)[:60]!r}, allowed: {self.allowed}")

    def _is_number(self, value: Any) -> bool:
        is_number = isinstance(value, Real) and not isinstance(value, bool) and self.lowest <= value <= self.highest
        return is_number and (not self.is_whole or float(value).is_integer())


def _number(value: Any) -> Any:
    # YAML reads 1e-4, without a dot, as text
    if isinstance(value, str):
        try:
            return float(value)
        except ValueError:
            return value
    return value


def _read(path: Path) -> Mapping[str, Any]:
    try:
        content = read_yaml(path, RangeError)
    except RangeError as error:
        raise RangeError(f"vehicle: {error}") from None
    if not isinstance(content, Mapping):
        raise RangeError(f"vehicle: '{path}' holds no mapping from parameters to values")
    return content


def _words(allowed: list[Any]) -> tuple[str, ...]:
    # YAML reads off and on as false and true
    if isinstance(allowed[0], bool):
        return ("off", "on")
    return tuple(allowed) if isinstance(allowed[0], str) else ()


@functools.cache
def parameters(platform: str = "cf2") -> Mapping[str, Parameter]:
    """Return all parameters of a platform by dotted name, in the order of the file.

    Raises:
        UnknownNameError: If there is no such platform.
    """
    if platform not in _PLATFORMS:
        raise UnknownNameError(f"no vehicle '{platform}', there are: {', '.join((*_PLATFORMS, *NAMED))}")
    values = _read(_FOLDER / f"{platform}.yaml")
    table = {}
    for name, meaning in _read(_FOLDER / "parameters.yaml").items():
        entry = values[name]
        choices = _words(meaning["range"])
        low, high = (0.0, len(choices) - 1.0) if choices else map(float, meaning["range"])
        likely = entry.get("likely")
        plain = Parameter(
            name=name,
            value=0.0,
            unit=entry["unit"],
            meaning=meaning["meaning"],
            size=meaning.get("size", 1),
            choices=choices,
            lowest=low,
            highest=high,
            is_whole=meaning.get("whole", False),
            source=entry["source"],
            note=entry.get("note", ""),
            likely=tuple(likely) if likely else None,
        )
        table[name] = Parameter(**{**vars(plain), "value": plain.check(entry["value"])})
    return table


def changes_of(name: str) -> Mapping[str, Parameter]:
    """Return what one of `NAMED` changes of platform cf2, by dotted name.

    Raises:
        UnknownNameError: If there is no such vehicle.
    """
    if name not in NAMED:
        raise UnknownNameError(f"no vehicle '{name}', there are: {', '.join((*_PLATFORMS, *NAMED))}")
    platform = parameters()
    return {
        each: replace(
            platform[each],
            value=platform[each].check(entry["value"]),
            source=entry["source"],
            note=entry.get("note", ""),
            likely=None,
        )
        for each, entry in _read(_FOLDER / f"{name}.yaml").items()
    }


def _flat(content: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested groups as dotted names; an entry as in the platform files counts as its `value`."""
    flat: dict[str, Any] = {}
    for key, value in content.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping) and "value" in value:
            flat[name] = value["value"]
        elif isinstance(value, Mapping):
            flat |= _flat(value, f"{name}.")
        else:
            flat[name] = value
    return flat


def _content(source: str | Path | Mapping[str, Any], folders: Sequence[Path]) -> Mapping[str, Any]:
    if isinstance(source, Mapping):
        return source
    if not isinstance(source, str | Path):
        raise RangeError(f"vehicle is {str(source)[:60]!r}, allowed: parameters, a YAML file, {', '.join(NAMED)}")
    if str(source) in (*NAMED, *_PLATFORMS):
        return _read(_FOLDER / f"{source}.yaml")
    path = next((folder / source for folder in folders if (folder / source).is_file()), None)
    if path is None:
        raise UnknownNameError(f"vehicle '{source}' is neither a file nor one of: {', '.join(NAMED)}")
    return _read(path)


def overrides(source: Overrides, folder: Path | Sequence[Path] = Path()) -> dict[str, Value]:
    """Return parameters that differ from the platform's, checked, by dotted name.

    Args:
        source: A mapping from dotted names (or nested groups) to values; a YAML file with one; ``kit``, ``legacy`` or
            ``nanobench``; or a list of these, of which the later ones win.
        folder: Where relative names of files are seen from; or several folders, of which the first that has it counts.

    Raises:
        UnknownNameError: If there is no such parameter or file; the message suggests the nearest name.
        RangeError: If a value is outside its range; the message names parameter, value and range.
    """
    is_list = isinstance(source, Sequence) and not isinstance(source, str)
    folders = [folder] if isinstance(folder, Path) else folder
    known = parameters()
    found: dict[str, Value] = {}
    for part in source if is_list else [source]:
        for name, value in _flat(_content(part, folders)).items():
            names = (f"{_BOTH}_up", f"{_BOTH}_down") if name == _BOTH else (name,)
            if names[0] not in known:
                near = get_close_matches(str(name)[:40], [*known, _BOTH], n=1)
                hint = f", did you mean '{near[0]}'?" if near else "; `crazychoir vehicle` lists them"
                raise UnknownNameError(f"vehicle: no parameter '{str(name)[:60]}'{hint}")
            found |= {each: known[each].check(value) for each in names}
    return found


def as_text(values: Mapping[str, Value]) -> str:
    """Return checked parameters as the engine plugin reads them: ``name=value name=a,b,c``."""
    return " ".join(f"{name}={_text(value)}" for name, value in values.items())


def _text(value: Value) -> str:
    if isinstance(value, tuple):
        return ",".join(repr(number) for number in value)
    return value if isinstance(value, str) else repr(value)
