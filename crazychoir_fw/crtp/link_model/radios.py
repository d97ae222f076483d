"""All simulated Crazyradios of a server or a flight, as one `Link`."""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from dataclasses import replace
from difflib import get_close_matches
from fnmatch import fnmatchcase
from typing import Any

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.crtp.link_model.airtime import LARGEST_BYTES
from crazychoir_fw.crtp.link_model.config import RadioConfig
from crazychoir_fw.crtp.link_model.dongle import Dongle
from crazychoir_fw.crtp.link_model.link import Arrival, Direction
from crazychoir_fw.crtp.link_model.link_state import LinkState, QueuedPacket

DEFAULT_CHANNELS = (*range(80, 126, 3), *range(77, -1, -3))
"""Far enough from each other at every data rate."""


class SimulatedRadios:
    """Crazyradios with their drones: late, lossy, and with only so much time for all.

    The same packets at the same times arrive at the same times, however often and whenever `arrivals` is asked for.
    Drones that no radio serves have a perfect link. Not for two threads at once, except for `statistics`.
    """

    def __init__(self, configs: Sequence[RadioConfig], drones: Sequence[str], seed: int = 0) -> None:
        """Turn on the radios.

        Args:
            configs: The radios.
            drones: Ids of all drones there are.
            seed: Seed of all losses and delays.

        Raises:
            UnknownNameError: If a radio names no drone that there is.
            RangeError: If a drone has two radios.
        """
        served = assign(configs, drones)
        self._now = -math.inf
        self._count = 0  # of arrivals, which settles which of two at one time is first
        self._arriving: list[tuple[float, int, LinkState, Direction, QueuedPacket, bool]] = []
        self.dongles = [
            Dongle(name, config, ids, seed, self._deliver)
            for config, (name, ids) in zip(_tuned(configs), served.items(), strict=True)
        ]
        self._places = {link.drone: (dongle, link) for dongle in self.dongles for link in dongle.links}
        self._wired = {drone: LinkState(drone) for drone in drones if drone not in self._places}
        for dongle in self.dongles:
            dongle.neighbors = [other for other in self.dongles if other is not dongle and _disturb(dongle, other)]

    # ---------------------------------------------------------------- Link

    def send(self, now: float, drone: str, direction: Direction, datagram: bytes, droppable: bool = False) -> None:
        """Take a packet on its way; `droppable` ones may be lost when too much waits.

        Raises:
            UnknownNameError: If there is no such drone.
            RangeError: If it is too long for a frame (32 bytes).
        """
        if len(datagram) > LARGEST_BYTES:
            raise RangeError(f"{drone}: a packet of {len(datagram)} bytes, allowed: {LARGEST_BYTES}")
        self._advance(now)
        place = self._places.get(drone)
        if place is not None:
            dongle, link = place
            dongle.put(self._now, link, direction, datagram, droppable)
            return
        wired = self._wired.get(drone)
        if wired is None:
            raise UnknownNameError(f"no drone named '{drone}', there are: {', '.join([*self._places, *self._wired])}")
        self._deliver(self._now, wired, direction, wired.new_packet(direction, datagram, self._now), False)

    def broadcast(self, now: float, radio: str, datagram: bytes) -> None:
        """Send a packet to all drones of a radio at once, which is neither acknowledged nor repeated.

        Raises:
            UnknownNameError: If there is no such radio.
        """
        self._advance(now)
        for dongle in self.dongles:
            if dongle.name == radio:
                dongle.broadcast(self._now, datagram)
                return
        raise UnknownNameError(f"no radio named '{radio}', there are: {', '.join(d.name for d in self.dongles)}")

    def arrivals(self, now: float) -> list[Arrival]:
        """Return the packets that have come through by now, in the order of their coming."""
        self._advance(now)
        arrived = []
        while self._arriving and self._arriving[0][0] <= self._now:
            time, _, link, direction, packet, is_copy = heapq.heappop(self._arriving)
            tally = link.tallies[direction]
            if is_copy:
                tally.duplicated += 1
            else:
                tally.note_arrival(packet.number, time - packet.sent)
            arrived.append(Arrival(link.drone, direction, packet.datagram))
        return arrived

    def next_arrival(self) -> float:
        """Return when to look again (s): nothing comes through before; infinity when nothing is under way."""
        first = self._arriving[0][0] if self._arriving else math.inf
        return min([first, *(dongle.first_possible_arrival() for dongle in self.dongles)])

    def _advance(self, now: float) -> None:
        """Carry out all exchanges that begin before now; one that begins right now may still take what is sent now."""
        self._now = max(self._now, now)
        while True:
            dongle = min(self.dongles, key=Dongle.next_start, default=None)
            if dongle is None or dongle.next_start() >= self._now:
                return
            dongle.exchange()

    def _deliver(self, time: float, link: LinkState, direction: Direction, packet: QueuedPacket, is_copy: bool) -> None:
        heapq.heappush(self._arriving, (time, self._count, link, direction, packet, is_copy))
        self._count += 1

    # ---------------------------------------------------------------- figures

    def is_lost(self, drone: str) -> bool:
        """Tell whether the link to a drone is lost at present."""
        return drone in self._places and self._places[drone][1].is_lost

    def statistics(self) -> dict[str, Any]:
        """Return what has been counted, as JSON can hold it.

        ``radios``: by name, its channel, drones, `utilization` (share of the time in exchanges that carried a packet),
        `on_air`, exchanges, those without an answer, collisions, lost links. ``drones``: by id, the name of the radio,
        lost links, and `up` and `down` with the counts of `Tally`.
        """
        links = [(dongle.name, link) for dongle in self.dongles for link in dongle.links]
        links += [(None, link) for link in self._wired.values()]
        return {
            "radios": {dongle.name: dongle.as_dict(self._now) for dongle in self.dongles},
            "drones": {
                link.drone: {
                    "radio": name,
                    "lost_links": link.lost_links,
                    **{direction.value: tally.as_dict() for direction, tally in link.tallies.items()},
                }
                for name, link in links
            },
        }


def assign(configs: Sequence[RadioConfig], drones: Sequence[str]) -> dict[str, list[str]]:
    """Return which drones each radio serves, by its name.

    Raises:
        UnknownNameError: If a radio names no drone that there is; the message begins with the number of the radio.
        RangeError: If a drone or a name has two radios.
    """
    served: dict[str, list[str]] = {}
    owner: dict[str, int] = {}
    for number, config in enumerate(configs):
        name = config.name or f"radio{number + 1}"
        if name in served:
            raise RangeError(f"[{number}].name is '{name}', but another radio is called that")
        served[name] = []
        for pattern in config.drones:
            meant = [drone for drone in drones if fnmatchcase(drone, pattern)]
            if not meant:
                near = get_close_matches(pattern[:40], drones, n=1)
                hint = f" (did you mean '{near[0]}'?)" if near else ""
                raise UnknownNameError(f"[{number}].drones names '{pattern[:40]}', but there is no such drone{hint}")
            for drone in meant:
                if owner.setdefault(drone, number) != number:
                    raise RangeError(f"[{number}].drones names '{drone}', but radios[{owner[drone]}] serves it already")
                if drone not in served[name]:
                    served[name].append(drone)
    return served


def _tuned(configs: Sequence[RadioConfig]) -> list[RadioConfig]:
    """Return the same radios, each with a channel; a radio without one gets a free channel, while there is one."""
    taken = {config.channel for config in configs if config.channel is not None}
    free = (channel for channel in DEFAULT_CHANNELS if not taken & {channel - 1, channel, channel + 1})
    return [
        config if config.channel is not None else replace(config, channel=next(free, DEFAULT_CHANNELS[0]))
        for config in configs
    ]


def _disturb(one: Dongle, other: Dongle) -> bool:
    """Tell whether two radios are on one channel. Channels are 1 MHz apart, and 2M is 2 MHz wide."""
    width = 2 if "2M" in (one.config.data_rate, other.config.data_rate) else 1
    return abs(one.config.channel - other.config.channel) < width
