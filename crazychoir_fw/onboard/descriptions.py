"""What parameters and log variables are, for people: unit and description by name."""

from __future__ import annotations

import fnmatch
import functools
from importlib.resources import files
from typing import Literal, NamedTuple

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.common.plain_yaml import parse_yaml


class Description(NamedTuple):
    """What a variable is."""

    unit: str
    """Such as ``m/s``; "1" of numbers without unit, "" of what is no quantity."""
    text: str
    """A few words."""


@functools.cache
def _rows() -> dict[str, list[list[str]]]:
    text = files("crazychoir_fw.onboard").joinpath("descriptions.yaml").read_text(encoding="utf-8")
    rows: dict[str, list[list[str]]] = parse_yaml(text, "descriptions.yaml", CrazychoirError)
    return rows


@functools.cache
def describe_variable(name: str, kind: Literal["parameters", "logs"]) -> Description:
    """Return what a parameter or log variable is; one that only a checkout or an app knows has no description."""
    for pattern, unit, text in _rows()[kind]:
        if fnmatch.fnmatchcase(name, pattern):
            return Description(unit, text)
    return Description("", "")
