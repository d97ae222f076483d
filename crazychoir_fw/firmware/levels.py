"""How much of a checkout flies: its algorithms, the modules around them, or its own loop as well.

A level is taken as a whole: modules of one level call each other, so that a mixture of theirs and ours would be neither
the vehicle nor the simulation.
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from crazychoir_fw.common.errors import UnknownNameError

BITCRAZE = "bitcraze"
ALGORITHMS, MODULES, STABILIZER = "algorithms", "modules", "stabilizer"
LEVELS = (ALGORITHMS, MODULES, STABILIZER)
"""Each contains the ones before it."""

ALL = "all"
"""The highest level that compiles."""

DEFAULT = ALGORITHMS
"""What the plain word of the provider means."""

LEVEL_OF_MODULE = {
    "commander": MODULES,
    "crtp_commander": MODULES,
    "high_level": MODULES,
    "supervisor": MODULES,
    "controller_table": MODULES,
    "estimator_task": MODULES,
    "collision_avoidance": MODULES,
    "peer_localization": MODULES,
    "stabilizer": STABILIZER,
    "health": STABILIZER,
}
"""Modules that users name, and the level that brings them."""


def modules_of(level: str) -> list[str]:
    """Return the modules beyond the algorithms that are the checkout's at a level."""
    there = LEVELS[: LEVELS.index(level) + 1]
    return [module for module, needed in LEVEL_OF_MODULE.items() if needed in there]


def word_of(level: str) -> str:
    """Return the word of the provider that flies a checkout at a level, such as ``bitcraze:modules``."""
    return BITCRAZE if level == DEFAULT else f"{BITCRAZE}:{level}"


def level_of(word: str) -> str | None:
    """Return the level that the word of a provider asks for, or `ALL`; None if the word means no checkout.

    Raises:
        UnknownNameError: If a checkout is meant, and the level does not exist.
    """
    provider, colon, level = word.partition(":")
    if provider != BITCRAZE:
        return None
    if not colon:
        return DEFAULT
    if level in (*LEVELS, ALL):
        return level
    near = get_close_matches(level[:64], (*LEVELS, ALL), n=1)
    hint = f" (did you mean '{near[0]}'?)" if near else ""
    raise UnknownNameError(f"provider is '{word[:80]}', allowed after '{BITCRAZE}:': {', '.join((*LEVELS, ALL))}{hint}")


def word_for_modules(modules: str | Iterable[str]) -> str:
    """Return the word of the provider that flies at least these modules of a checkout.

    Args:
        modules: Names out of `LEVEL_OF_MODULE`, or ``"all"`` for whatever compiles.

    Raises:
        UnknownNameError: If there is no such module.
    """
    if modules == ALL:
        return word_of(ALL)
    names = [modules] if isinstance(modules, str) else list(modules)
    for name in names:
        if name not in LEVEL_OF_MODULE:
            near = get_close_matches(str(name)[:64], LEVEL_OF_MODULE, n=1)
            hint = f" (did you mean '{near[0]}'?)" if near else ""
            raise UnknownNameError(f"no module named '{name}', allowed: {', '.join(LEVEL_OF_MODULE)}{hint}")
    highest = max((LEVELS.index(LEVEL_OF_MODULE[name]) for name in names), default=0)
    return word_of(LEVELS[highest])
