"""What the services of one drone share: the drone, the way down to its client, and the way to the simulation.

Two threads meet here. A *radio* thread brings packets and must have its replies at once, whether the simulation runs,
is slow or is paused. The *simulation* thread alone may change a drone, and only between two steps. So a service

- answers in `Service.receive` at once, from tables, from constants, from what it keeps itself, and by reading single
  numbers of the drone's memory, which is allowed while the drone ticks;
- lets everything that changes the drone happen `later`;
- sends what is no answer with `send`, from either thread.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from crazychoir_fw.crtp.packet import HEADERS

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone
    from crazychoir_fw.simulation.world import World

MAX_WAITING = 1000
"""Changes that wait for the simulation; more are refused, so that a flood cannot fill the memory."""


class ServiceContext:
    """One drone, seen from its services."""

    def __init__(self, world: World, drone: Drone, storage: str | Path | None = None) -> None:
        self.world = world
        self.drone = drone
        self.storage = storage
        """Folder of what clients store on the drone; None keeps it in memory."""
        self.received = 0
        """Packets that came from clients."""
        self.sent = 0
        """Packets that went to them."""
        self.reads_ahead = False
        """Whether tables of contents are sent ahead of the questions for their items, and read in turns."""
        self.looks: set[Callable[[], None]] = set()
        """What the radio calls whenever it looks around, every 20 ms while there is a client; only it writes here."""
        self.closing = ExitStack()
        """What takes the appointments and listeners of the services off again, when the station closes."""
        self._later: deque[Callable[[], None]] = deque()
        self._out: deque[tuple[bytes, bool]] = deque()
        self._lock = threading.Lock()
        self.wake_simulation: Callable[[], None] = lambda: None
        """Called when there is something to carry out; a simulation that waits for the clock need not wait for it."""
        self.wake_radio: Callable[[], None] = lambda: None
        """Called when there is something to send."""

    def every(self, period: int, call: Callable[[], None]) -> None:
        """Have `call` called at all multiples of so many ticks, until the station closes."""
        self.closing.callback(self.world.agenda.every(period, call))

    def when_sought(self, call: Callable[[int], None]) -> None:
        """Have `call` called with the tick after every jump in time, until the station closes."""
        self.world.agenda.when_sought.append(call)
        self.closing.callback(self.world.agenda.when_sought.remove, call)

    def later(self, change: Callable[[], None], *, is_bounded: bool = False) -> bool:
        """Have a change carried out by the simulation thread between two steps, in the order of their coming.

        Args:
            change: What is to be done.
            is_bounded: True for callers that limit the number of their pending changes; they are never refused, so that
                a flood of something else does not keep an emergency stop from the drone.

        Returns:
            False when too many wait already, and this one is dropped.
        """
        with self._lock:
            if len(self._later) >= MAX_WAITING and not is_bounded:
                return False
            self._later.append(change)
        self.wake_simulation()
        return True

    @property
    def has_changes(self) -> bool:
        """Whether something waits for the simulation."""
        return bool(self._later)

    def carry_out(self) -> None:
        """Carry out what waits; only the simulation thread calls this."""
        while self._later:
            self._later.popleft()()

    def send(self, port: int, channel: int, payload: bytes, *, droppable: bool = False) -> None:
        """Send a packet to the client, if there is one.

        Args:
            port: Port of the packet.
            channel: Channel of the packet.
            payload: Up to 30 bytes.
            droppable: True for what may be lost when the client is behind: log data and console text.
        """
        self._out.append((HEADERS[port][channel] + payload, droppable))
        self.wake_radio()

    def put_out(self, datagrams: Iterable[tuple[bytes, bool]]) -> None:
        """Put datagrams that are packed already, each with whether it may be dropped, where the radio finds them.

        With output for many drones, wake their radio afterwards, so that it does not begin with the first alone.
        """
        self._out.extend(datagrams)

    def take_out(self) -> list[tuple[bytes, bool]]:
        """Return datagrams to send, oldest first, each with whether it may be dropped; only the radio calls this."""
        taken = []
        while self._out:
            taken.append(self._out.popleft())
        self.sent += len(taken)
        return taken
