"""The one registry of laws: names that a mission may use, of ours and of installed packages.

A package offers a law as an entry point of a group such as ``crazychoir.guidance``, see `KINDS`:
``Rendezvous = "my_package.laws:Rendezvous"``. Classes of a file or a module need no entry: a mission names them
``file.py:Class`` or ``package.module:Class``.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from crazychoir_fw.common.errors import CrazychoirError, RangeError, UnknownNameError
from crazychoir_fw.common.user_code import USER_ERRORS, describe, load_module

_OURS: Mapping[str, Mapping[str, str]] = {
    "guidance": {
        "crazychoir_fw.guidance": (
            "BearingFormation SimpleGuidance GoToGuidance TargetListGuidance SimpleDIControl FormationControl "
            "FormationControlGuidance Containment ContainmentGuidance TimeVaryingContainment "
            "TimeVaryingContainmentGuidance"
        ),
        "crazychoir_fw.guidance.schemes.tasks": "TaskGuidance",
        "crazychoir_fw.guidance.schemes.delivery": "DeliveryGuidance",
        "crazychoir_fw.guidance.schemes.mpc": "MPCGuidance",
        "crazychoir_fw.guidance.schemes.aggregative": (
            "AggregativeGuidance AggregativeGuidanceCrazyflie AggregativeGuidanceCrazyflieMovingIntruder"
        ),
    },
    "planning": {"crazychoir_fw.planning": "Spline SplinePosition Polynomial7th MinimumSnap"},
    "control": {"crazychoir_fw.control": "HierarchicalController VelocityController"},
    "position": {"crazychoir_fw.control": "FlatnessPositionCtrl"},
    "acceleration": {"crazychoir_fw.control": "FlatnessAccelerationCtrl"},
    "attitude": {"crazychoir_fw.control": "GeometryAttitudeCtrl"},
    "velocity": {"crazychoir_fw.control": "VelocityCtrlStrategy"},
    "safety": {"crazychoir_fw.control.safety": "SingleIntegratorCBF DoubleIntegratorCBF"},
}

KINDS = tuple(_OURS)
"""Kinds of laws; a module is imported when a mission names one of its laws."""


@cache
def our_names(kind: str) -> Mapping[str, str]:
    """Return the modules of our laws of a kind, by name."""
    return {name: module for module, names in _OURS[kind].items() for name in names.split()}


@cache
def installed_names(kind: str) -> Mapping[str, EntryPoint]:
    """Return the laws of a kind that installed packages offer, by name."""
    return {entry.name: entry for entry in entry_points(group=f"crazychoir.{kind}")}


def our_laws(kind: str) -> dict[str, type]:
    """Return all our laws of a kind by name; their modules are imported."""
    return {name: getattr(import_module(module), name) for name, module in our_names(kind).items()}


def law_named(kind: str, word: str, key: str, base: type | None = None) -> type:
    """Return the law of a word; the module of a user's is executed.

    Args:
        kind: One of `KINDS`.
        word: A name of the registry, or module:Class, or file.py:Class.
        key: Where the word stands in the mission.
        base: What the law must derive from.

    Raises:
        UnknownNameError: If there is no such class.
        RangeError: If it is of another kind.
        CrazychoirError: If its module raises.
    """
    if word in our_names(kind):
        return getattr(import_module(our_names(kind)[word]), word)
    what = f"{key} '{word}'"
    if ":" in word:
        found = _class_in(word, what)
    else:
        entry = installed_names(kind)[word]
        try:
            found = entry.load()
        except USER_ERRORS as error:  # whatever a module may do while it is imported
            raise CrazychoirError(f"{what}: the installed {entry.value} cannot be loaded: {describe(error)}") from error
    if not isinstance(found, type) or (base is not None and not issubclass(found, base)):
        must = f"a subclass of {base.__name__}" if base is not None else "a class"
        raise RangeError(f"{what}: {found!r} is allowed to be {must} only")
    return found


def _class_in(word: str, what: str) -> Any:
    module_name, _, class_name = word.rpartition(":")
    module = load_module(module_name, what)
    found = getattr(module, class_name, None)
    if found is None:
        classes = [value for value in vars(module).values() if isinstance(value, type)]
        own = [value.__name__ for value in classes if value.__module__ == module.__name__]
        raise UnknownNameError(f"{what}: there is no such class, only {', '.join(own) or 'none at all'}")
    return found
