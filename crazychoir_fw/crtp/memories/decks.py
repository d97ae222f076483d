"""Which expansion decks a drone carries, by the names that are written on them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from crazychoir_fw._core import lib

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone


class Deck(NamedTuple):
    """What a deck says of itself."""

    name: str
    """Name of the board, as in the parameters of group ``deck``."""
    product: int
    """Product id among those of the vendor 0xBC. General knowledge, not from docs/reference."""


LOCO = Deck("bcDWM1000", 0x06)
MULTIRANGER = Deck("bcMultiranger", 0x0C)
ZRANGER = Deck("bcZRanger2", 0x0E)
FLOW = Deck("bcFlow2", 0x0F)
LIGHTHOUSE = Deck("bcLighthouse4", 0x10)

_OF_POSITIONING = {
    lib.CF_POSITIONING_FLOW: FLOW,
    lib.CF_POSITIONING_LIGHTHOUSE: LIGHTHOUSE,
    lib.CF_POSITIONING_LOCO_TWR: LOCO,
    lib.CF_POSITIONING_LOCO_TDOA2: LOCO,
    lib.CF_POSITIONING_LOCO_TDOA3: LOCO,
}


def decks_of(drone: Drone) -> list[Deck]:
    """Return the decks of a drone: the one that positions it, then those that only measure ranges."""
    vehicle = drone.struct.config.vehicle
    positioning = _OF_POSITIONING.get(vehicle.positioning)
    found = [positioning] if positioning is not None else []
    if vehicle.rangers.has_multiranger:
        found.append(MULTIRANGER)
    if vehicle.rangers.has_zranger:
        found.append(ZRANGER)
    return found
