"""Switches a drone off and on over the radio: its radio chip stays awake, and starts the rest again."""

from __future__ import annotations

from cflib.utils.power_switch import PowerSwitch

from crazychoir_fw.common.errors import RadioError, StateError
from crazychoir_fw.radio.connection import init_drivers

BOOT_S = 4.0
"""How long a drone takes until it answers again, sensors and decks included (s)."""


def can_switch(uri: str) -> bool:
    """Return whether the power of a drone can be switched over this link: by a Crazyradio only."""
    return uri.startswith("radio://")


def power_cycle(who: str, uri: str) -> None:
    """Switch the drone off for a second, and on again; the link must have been closed. Takes more than 1 s.

    Raises:
        StateError: If this link cannot do that.
        RadioError: If the radio chip of the drone does not answer.
    """
    if not can_switch(uri):
        raise StateError(f"{who}: its power can be switched over radio:// only")
    init_drivers()
    try:
        switch = PowerSwitch(uri)
        try:
            switch.stm_power_cycle()
        finally:
            switch.close()
    except Exception as error:  # of many kinds: no dongle, no answer, an address that is none
        raise RadioError(f"{who}: the power could not be switched: {error}") from error
