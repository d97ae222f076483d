"""One Crazyradio: it asks its drones one after the other, and they answer.

An *exchange* is one packet to a drone, a null packet when there is none, and the answer in the acknowledgment, empty
when the drone has nothing. Drones take turns. While no packet waits anywhere, exchanges are not computed one by one:
they would only tell in which one of them the next packet finds the dongle, and that is drawn instead.
"""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

from crazychoir_fw.crtp.link_model.airtime import LARGEST_BYTES, NULL_BYTES, SETTLE_S, AirUse, transmission
from crazychoir_fw.crtp.link_model.config import RadioConfig, draw_delay
from crazychoir_fw.crtp.link_model.link import Direction
from crazychoir_fw.crtp.link_model.link_state import LinkState, QueuedPacket

MAX_WAITING = 1000
"""So many packets of a drone may wait one way whatever they are; a flood must not fill the memory."""

Deliver = Callable[[float, LinkState, Direction, QueuedPacket, bool], None]
"""Called with the time of arrival (s), and True for a packet that arrives once more."""


class Dongle:
    """One Crazyradio with its drones."""

    def __init__(self, name: str, config: RadioConfig, drones: Sequence[str], seed: int, deliver: Deliver) -> None:
        self.name = name
        self.config = config
        self.links = [LinkState(drone) for drone in drones]
        self.neighbors: list[Dongle] = []
        """Others that it can disturb."""
        self._deliver = deliver
        self._random = random.Random(f"{seed} {name}")
        self._air = [transmission(size, config.data_rate) for size in range(LARGEST_BYTES + 1)]
        self._half_turn = config.turnaround_ms / 2e3
        self._null = 2 * self._half_turn + 2 * self._air[NULL_BYTES] + SETTLE_S
        self._broadcasts: deque[tuple[bytes, list[QueuedPacket]]] = deque()
        self._waiting = 0  # packets and broadcasts, all together
        self._turn = 0  # link that is next
        self._pause = config.idle_poll_ms / 1e3
        self._all_lost = False
        self._use = AirUse(self._air[NULL_BYTES], self._polls_per_second)
        self._began = math.inf  # [s]
        self._unanswered = 0
        self._collisions = 0

    # ---------------------------------------------------------------- packets come

    def put(self, now: float, link: LinkState, direction: Direction, datagram: bytes, droppable: bool) -> None:
        """Let a packet wait for its turn, or drop it."""
        tally = link.tallies[direction]
        packet = link.new_packet(direction, datagram, now)
        waiting = link.up if direction is Direction.UP else link.down
        if len(waiting) >= (self.config.queue if droppable else MAX_WAITING):
            tally.dropped += 1
            return
        if direction is Direction.DOWN and link.is_lost:
            tally.lost += 1  # a drone without a link throws away what it has to say
            return
        self._wake(now)
        waiting.append(packet)
        self._waiting += 1
        tally.note_waiting(len(waiting))

    def broadcast(self, now: float, datagram: bytes) -> None:
        """Let a packet wait that is sent once, to all drones, and acknowledged by none."""
        packets = [link.new_packet(Direction.UP, datagram, now) for link in self.links]
        if len(self._broadcasts) >= self.config.queue:
            for link in self.links:
                link.tallies[Direction.UP].dropped += 1
            return
        self._wake(now)
        self._broadcasts.append((datagram, packets))
        self._waiting += 1

    def _wake(self, now: float) -> None:
        """Begin to compute exchanges one by one; draw where the dongle stands, if it has been asking all the time."""
        self._began = min(self._began, now)
        if not self._waiting and now > self._use.free_at:
            rest = self._random.random() / max(self._polls_per_second() * self._null, 1e-9)
            self._use.free_at = now + (rest * self._null if rest < 1.0 else 0.0)
            self._turn = int(self._random.random() * len(self.links))
            for link in self.links:
                link.next_poll = now + self._pause * self._random.random() if self._pause else now
        self._use.last_use = max(self._use.last_use, now)

    # ---------------------------------------------------------------- exchanges

    def next_start(self) -> float:
        """Return when the next exchange begins (s), infinity while no packet waits."""
        if not self._waiting:
            return math.inf
        if self._broadcasts:
            return max(self._use.free_at, self._broadcasts[0][1][0].sent)
        if not self._pause and not self._all_lost:
            return self._use.free_at  # there is always a drone to ask
        return max(self._use.free_at, min(link.ready_at() for link in self.links))

    def first_possible_arrival(self) -> float:
        """Return a time before which nothing that waits can arrive (s)."""
        return self.next_start() + self._half_turn

    def exchange(self) -> None:
        """Carry out the next exchange, or the next broadcast."""
        start = self.next_start()
        clear, rate = self._quiet(start)
        if self._broadcasts:
            self._send_broadcast(start, clear, rate)
            return
        link = self._whose_turn(start)
        up = link.up[0] if link.up else None
        down = link.down[0] if link.down else None
        up_air = self._air[len(up.datagram) if up else NULL_BYTES]
        down_air = self._air[len(down.datagram) if down else NULL_BYTES]
        wait = SETTLE_S + self._air[LARGEST_BYTES]

        time = start + self._half_turn
        heard_at = math.inf
        is_acknowledged = False
        tries = answers = 0
        for _ in range(1 + self.config.retries):
            tries += 1
            time += up_air
            if self._gets_through(self.config.lost_up, up_air, clear, rate):
                heard_at = min(heard_at, time)
                answers += 1
                if self._gets_through(self.config.lost_down, down_air, clear, rate):
                    is_acknowledged = True
                    time += SETTLE_S + down_air
                    break
            time += wait
        end = time + self._half_turn

        on_air = tries * up_air + answers * down_air
        is_of_use = up is not None or down is not None
        self._use.count(start, end, on_air, tries + answers, is_of_use)
        link.next_poll = end + (0.0 if up or down else self._pause)
        if up is not None:
            self._settle_up(link, up, tries, heard_at, is_acknowledged)
        if down is not None:
            self._settle_down(link, down, answers, end, is_acknowledged)
        self._judge_link(link, start, end, is_acknowledged)

    def _whose_turn(self, start: float) -> LinkState:
        count = len(self.links)
        for step in range(count):
            number = (self._turn + step) % count
            if self.links[number].ready_at() <= start:
                self._turn = (number + 1) % count
                return self.links[number]
        raise AssertionError("an exchange without a drone")

    def _settle_up(self, link: LinkState, up: QueuedPacket, tries: int, heard_at: float, is_acknowledged: bool) -> None:
        tally = link.tallies[Direction.UP]
        tally.repeated += tries - 1 + up.was_tried
        up.was_tried = True
        if heard_at < math.inf and not up.has_arrived:
            up.has_arrived = True
            self._send_on(heard_at, link, Direction.UP, up)
        if is_acknowledged or not self.config.reliable:
            link.up.popleft()
            self._waiting -= 1
            tally.lost += not up.has_arrived

    def _settle_down(
        self, link: LinkState, down: QueuedPacket, answers: int, end: float, is_acknowledged: bool
    ) -> None:
        if not answers:
            return  # the drone was never asked
        tally = link.tallies[Direction.DOWN]
        tally.repeated += answers - 1 + down.was_tried
        down.was_tried = True
        if is_acknowledged:
            self._send_on(end, link, Direction.DOWN, down)
        elif self.config.reliable:
            return
        else:
            tally.lost += 1
        link.down.popleft()
        self._waiting -= 1

    def _judge_link(self, link: LinkState, start: float, end: float, is_acknowledged: bool) -> None:
        if is_acknowledged:
            self._all_lost = False
            link.note_acknowledged()
            return
        self._unanswered += 1
        link.failed += 1
        link.failing_since = min(link.failing_since, start)
        if link.failed >= self.config.link_tries or end - link.failing_since >= self.config.link_timeout:
            # the drone is not asked any more until there is a packet for it
            self._waiting -= link.lose_link()
            self._all_lost = all(other.is_lost for other in self.links)

    def _send_broadcast(self, start: float, clear: float, rate: float) -> None:
        datagram, packets = self._broadcasts.popleft()
        self._waiting -= 1
        air = self._air[len(datagram)]
        heard_at = start + self._half_turn + air
        for link, packet in zip(self.links, packets, strict=True):
            if self._gets_through(self.config.lost_up, air, clear, rate):
                self._send_on(heard_at, link, Direction.UP, packet)
            else:
                link.tallies[Direction.UP].lost += 1
        self._use.count(start, heard_at + self._half_turn, air, 1, True)

    def _send_on(self, time: float, link: LinkState, direction: Direction, packet: QueuedPacket) -> None:
        """Let a packet that has left the air arrive, later by what hosts and processors need."""
        config = self.config
        arrival = time + draw_delay(config, self._random)
        if config.reorder and self._random.random() < config.reorder:
            arrival += self._random.random() * config.reorder_ms / 1e3
        else:
            # whatever the jitter, nothing overtakes
            arrival = max(arrival, link.last_arrival[direction])
            link.last_arrival[direction] = arrival
        self._deliver(arrival, link, direction, packet, False)
        if config.duplicate and self._random.random() < config.duplicate:
            self._deliver(arrival, link, direction, packet, True)

    # ---------------------------------------------------------------- the air

    def _gets_through(self, loss: float, air: float, clear: float, rate: float) -> bool:
        draw = self._random.random()
        if draw < loss:
            return False
        if clear < 1.0 and draw >= loss + (1.0 - loss) * clear * math.exp(-rate * air):
            self._collisions += 1
            return False
        return True

    def _quiet(self, time: float) -> tuple[float, float]:
        """Return how probable it is that no neighbor is on the air, and how often they begin to be (1/s)."""
        clear, rate = 1.0, 0.0
        for neighbor in self.neighbors:
            share, count = neighbor._use.activity(time)
            clear *= 1.0 - min(share, 1.0)
            rate += count
        return clear, rate

    def _polls_per_second(self) -> float:
        """Return how many null packets it sends while it has nothing else to do (1/s)."""
        asked = sum(not link.is_lost for link in self.links)
        return min(1.0 / self._null, asked / (self._pause + self._null))

    # ---------------------------------------------------------------- figures

    def as_dict(self, now: float) -> dict[str, Any]:
        """Return all figures, as JSON can hold them."""
        elapsed = max(now - self._began, 0.0) if self._began < math.inf else 0.0
        return {
            "channel": self.config.channel,
            "data_rate": self.config.data_rate,
            "drones": [link.drone for link in self.links],
            "seconds": elapsed,
            "utilization": min(self._use.seconds_busy / elapsed, 1.0) if elapsed else 0.0,
            "on_air": min(self._use.seconds_on_air / elapsed, 1.0) if elapsed else 0.0,
            "exchanges": self._use.exchanges,
            "unanswered": self._unanswered,
            "collisions": self._collisions,
            "lost_links": sum(link.lost_links for link in self.links),
        }
