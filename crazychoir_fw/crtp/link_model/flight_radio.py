"""The radios of a flight without a server: what the mission asks of its drones goes through a link as packets.

Requests leave by the transport of each drone's uplink, and arrive between two steps, at the first tick that is not
before their simulated arrival. What has arrived is delivered to the drone like any request, so that the journal has it
and a replay needs no radio. Answers that a client reads from the drone are not disturbed, and nothing goes down.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.crtp.link_model.link import Direction
from crazychoir_fw.crtp.link_model.radios import SimulatedRadios

if TYPE_CHECKING:
    from crazychoir_fw.simulation.world import World


PACKET_BYTES = {
    "cf_send_rpyt": 15,
    "cf_send_stop": 2,
    "cf_send_velocity_world": 18,
    "cf_send_zdistance": 18,
    "cf_send_hover": 18,
    "cf_send_position": 18,
    "cf_send_manual": 17,
    "cf_notify_setpoint_stop": 6,
    "cf_send_external_position": 13,
    "cf_send_external_pose": 30,
    "cf_set_group_mask": 3,
    "cf_stop": 3,
    "cf_takeoff": 16,
    "cf_land": 16,
    "cf_go_to": 25,
    "cf_spiral": 25,
    "cf_define_trajectory": 10,
    "cf_start_trajectory": 11,
    "cf_arm": 3,
    "cf_recover_from_crash": 2,
    "cf_emergency_stop": 2,
    "feed_watchdog": 2,
    "param": 7,
}
"""Header and payload of what cflib sends (docs/reference/crtp-cflib.md#12 to #14)."""

FULL_BYTES = 31
"""Of whatever else there is."""

MEMORY_CHUNK = 24
"""Bytes of a memory that one packet writes; 6 more say which and where."""


@dataclass
class _Request:
    """What a client asked of a drone."""

    tick: int
    drone: int
    verb: str
    arguments: tuple[Any, ...]
    arrived: set[int] = field(default_factory=set)
    """Numbers of its packets that have come through."""


class _Letter(bytes):
    """One packet of a request."""

    request: _Request
    number: int
    of: int
    """Packets that the request needs."""


class FlightRadio:
    """A link between the clients in this process and the drones of a world.

    A world that goes back in time finds under way what was under way then: the link is made again and told all that was
    sent before. Requests of the very tick that it goes back to count as not yet sent, and so does everything in a world
    that restores the snapshot of another one. A fork takes along what is under way.
    """

    def __init__(self, world: World, link: SimulatedRadios) -> None:
        """Let all requests of a world go through a link.

        Args:
            world: The world; time may have passed already.
            link: A link that knows its drones and has carried nothing yet.
        """
        self._join(world, link, copy.deepcopy(link), [])

    def _join(self, world: World, link: SimulatedRadios, fresh: SimulatedRadios, history: list[_Request]) -> None:
        self.link = link
        """What it sends through, with its statistics."""
        self._world = world
        self._fresh = fresh
        self._history = history  # all requests so far
        for number, drone in enumerate(world.drones):
            drone.uplink.transport = partial(self._send, number)
        world.agenda.when_sought.append(self._time_has_changed)
        world.when_forked.append(self._follow)
        self._expect()

    def _send(self, drone: int, verb: str, arguments: tuple[Any, ...]) -> None:
        request = _Request(self._world.tick, drone, verb, arguments)
        self._history.append(request)
        self._hand_over(request)
        self._expect()

    def _hand_over(self, request: _Request) -> None:
        sizes = packet_sizes(request.verb, request.arguments)
        for number, size in enumerate(sizes):
            letter = _Letter(size)
            letter.request, letter.number, letter.of = request, number, len(sizes)
            name = self._world.drones[request.drone].id
            self.link.send(request.tick / TICKS_PER_SECOND, name, Direction.UP, letter)

    def _expect(self) -> None:
        """Look again when something may have come; to look once too often does no harm."""
        when = self.link.next_arrival()
        if when < math.inf:
            tick = max(math.ceil(when * TICKS_PER_SECOND - 1e-9), self._world.tick + 1)
            self._world.agenda.at(tick, self._fetch)

    def _fetch(self) -> None:
        for request in self._come_through(self._world.tick):
            # the client has gone on and hears of no refusal
            with suppress(CrazychoirError):
                self._world.drones[request.drone].uplink.dispatch(request.verb, *request.arguments)
        self._expect()

    def _come_through(self, tick: int) -> Iterator[_Request]:
        """Yield the requests that are complete by a tick; one whose packet came twice, twice."""
        for arrival in self.link.arrivals(tick / TICKS_PER_SECOND):
            letter = arrival.datagram
            assert isinstance(letter, _Letter)
            letter.request.arrived.add(letter.number)
            if len(letter.request.arrived) == letter.of:
                yield letter.request

    # ---------------------------------------------------------------- other times, other worlds

    def _time_has_changed(self, tick: int) -> None:
        self.link = copy.deepcopy(self._fresh)
        self._history = [replace(request, arrived=set()) for request in self._history if request.tick < tick]
        for request in self._history:
            self._hand_over(request)
        for _ in self._come_through(tick):
            pass  # the drones are what these have made of them
        self._expect()

    def _follow(self, world: World) -> None:
        """Do the same in a fork."""
        world.when_forked.remove(self._follow)
        radio = copy.copy(self)
        radio._join(world, *copy.deepcopy((self.link, self._fresh, self._history)))


def packet_sizes(verb: str, arguments: tuple[Any, ...]) -> list[int]:
    """Return how many bytes the packets have that cflib sends for a request, with their headers."""
    if verb == "packet":
        _port, _channel, data, *_ = arguments
        return [1 + min(len(data), FULL_BYTES - 1)]
    if verb == "setpoint":
        return [1 + min(len(arguments[0]), FULL_BYTES - 1)]
    if verb == "cf_write_trajectory":
        length = arguments[1]
        chunks = [min(MEMORY_CHUNK, length - start) for start in range(0, length, MEMORY_CHUNK)]
        return [6 + chunk for chunk in chunks] or [6]
    return [PACKET_BYTES.get(verb, FULL_BYTES)]
