"""Which memories a drone has, in the order of their ids."""

from __future__ import annotations

from crazychoir_fw.crtp.memories.core_memories import (
    LedRingMemory,
    LedTimingsMemory,
    LighthouseMemory,
    TesterMemory,
    TrajectoryMemory,
)
from crazychoir_fw.crtp.memories.deck_memories import LOCO, DeckMemory, Loco2Memory, LocoMemory, OneWireMemory, decks_of
from crazychoir_fw.crtp.memories.eeprom import EepromMemory
from crazychoir_fw.crtp.memories.memory import Memory
from crazychoir_fw.crtp.service_context import ServiceContext

_ALWAYS = (
    EepromMemory,
    LedRingMemory,
    LedTimingsMemory,
    TrajectoryMemory,
    LighthouseMemory,
    TesterMemory,
    DeckMemory,
)
"""Also without LED ring and lighthouse deck: scripts that write them find them, and nothing comes of it."""


def fitted_memories(context: ServiceContext) -> list[Memory]:
    """Return the memories of a drone: those that all have, those of its decks, and the 1-wire memories last."""
    decks = decks_of(context.drone)
    memories: list[Memory] = [make(context) for make in _ALWAYS]
    if LOCO in decks:
        memories += [LocoMemory(context), Loco2Memory(context)]
    return memories + [OneWireMemory(context, deck) for deck in decks]
