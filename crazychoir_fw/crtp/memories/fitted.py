"""Which memories a drone has, in the order of their ids."""

from __future__ import annotations

from crazychoir_fw.crtp.memories.deck_memory import DeckMemory
from crazychoir_fw.crtp.memories.decks import LOCO, decks_of
from crazychoir_fw.crtp.memories.eeprom import EepromMemory
from crazychoir_fw.crtp.memories.led_ring import LedRingMemory
from crazychoir_fw.crtp.memories.led_timings import LedTimingsMemory
from crazychoir_fw.crtp.memories.lighthouse import LighthouseMemory
from crazychoir_fw.crtp.memories.loco import LocoMemory
from crazychoir_fw.crtp.memories.loco_2 import Loco2Memory
from crazychoir_fw.crtp.memories.memory import Memory
from crazychoir_fw.crtp.memories.one_wire import OneWireMemory
from crazychoir_fw.crtp.memories.tester import TesterMemory
from crazychoir_fw.crtp.memories.trajectory import TrajectoryMemory
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
