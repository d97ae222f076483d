"""What the radio chip of a Crazyflie does by itself: it switches the rest of the drone off and on, and starts it again.

cflib's `PowerSwitch` and `Cloader` send these requests in packets of port 15, channel 3, beside any session, from a
socket of their own: a byte that names the chip, one that names the request, and what belongs to it. As on a vehicle
the radio chip obeys every client, whether or not that client owns the session of the drone.

====================  ==========================================================================================
``FE 01``             All off, the radio chip too: nothing answers any more.
``FE 02``, ``FE 03``  Off and on, all but the radio chip. In between only scans and these requests are answered.
``FE FF``             Announces a reset; answered with the address of the drone.
``FE F0 01``          Boot again.
``FE F0 00``          Start the boot loader. A simulated drone has none, so this is refused: without an answer, which
                      `PowerSwitch` raises as an error, with a warning and an event ``bootloader_refused``.
====================  ==========================================================================================

A drone that boots is as after power on: its lock is gone, its parameters have their defaults or the stored values.
"""

from __future__ import annotations

import enum
import logging
from typing import Any

from crazychoir_fw.crtp.packet import NULL
from crazychoir_fw.crtp.service_context import ServiceContext

_RADIO_CHIP, _MAIN_CHIP = 0xFE, 0xFF
_ALL_OFF, _OFF, _ON, _RESET, _ANNOUNCE = 0x01, 0x02, 0x03, 0xF0, 0xFF
_TO_FIRMWARE = 1
_ADDRESS = bytes.fromhex("e7e7e7")

logger = logging.getLogger("crazychoir_fw.crtp")


class Power(enum.Enum):
    """What of a drone has power."""

    ON = "on"
    RADIO_ONLY = "radio only"
    OFF = "off"


def is_power_request(datagram: bytes) -> bool:
    """Tell whether a datagram is for the radio chip or the boot loader, and no null packet."""
    return len(datagram) > 2 and datagram[0] & 0xF3 == 0xF3 and datagram[1] in (_RADIO_CHIP, _MAIN_CHIP)


class PowerSwitch:
    """The power of one drone; the radio thread asks, the drone follows between two steps."""

    def __init__(self, context: ServiceContext) -> None:
        """Begin with power on."""
        self._context = context
        self.state = Power.ON
        self.boots = 0
        """How often a client had the drone boot."""
        uplink = context.drone.uplink
        uplink.listeners.append(self._listen)
        context.closing.callback(uplink.listeners.remove, self._listen)
        context.when_sought(self._look)

    def receive(self, datagram: bytes) -> bytes | None:
        """Take a request. Returns the datagram that answers it, None where no answer is sent."""
        if self.state is Power.OFF:
            return None
        chip, request, rest = datagram[1], datagram[2], datagram[3:]
        if chip == _RADIO_CHIP and request == _ANNOUNCE:
            radio_id = int(self._context.drone.struct.onboard.radio_id)
            return NULL + datagram[1:3] + bytes((radio_id & 0xFF,)) + _ADDRESS
        if chip == _RADIO_CHIP and request in (_ALL_OFF, _OFF):
            self.state = Power.OFF if request == _ALL_OFF else Power.RADIO_ONLY
            self._later(self._cut)
        elif chip == _RADIO_CHIP and request == _ON:
            if self.state is Power.RADIO_ONLY:
                self._boot()
        elif chip == _RADIO_CHIP and request == _RESET and rest[:1] == bytes((_TO_FIRMWARE,)):
            self._boot()
        else:
            self._refuse()
            return None
        return NULL

    def _boot(self) -> None:
        self.state = Power.ON
        self.boots += 1
        self._later(self._start)

    def _later(self, change: Any) -> None:
        # a request that is acknowledged happens, whatever waits
        self._context.later(change, is_bounded=True)

    def _refuse(self) -> None:
        name = self._context.drone.id
        reason = "a simulated drone has none; its firmware is that of the program which simulates it"
        logger.warning("%s: a client asked for the boot loader: refused, %s", name, reason)
        world = self._context.world
        self._context.later(lambda: world.note("bootloader_refused", name, reason=reason))

    # ---------------------------------------------------------------- on the simulation thread

    def _cut(self) -> None:
        self._context.drone.uplink.dispatch("cf_inject_battery_cut", True)

    def _start(self) -> None:
        self._context.drone.uplink.dispatch("cf_inject_battery_cut", False)
        self._context.drone.uplink.dispatch("cf_reboot")

    def _listen(self, verb: str, arguments: tuple[Any, ...]) -> None:
        if verb == "cf_reboot" and self.state is not Power.ON:  # by its button, or from the page
            self.state = Power.ON
            self._context.drone.uplink.dispatch("cf_inject_battery_cut", False)

    def _look(self, tick: int) -> None:
        """Go by the state that the world was taken to."""
        del tick
        if not self._context.drone.struct.injected.is_battery_cut:
            self.state = Power.ON
