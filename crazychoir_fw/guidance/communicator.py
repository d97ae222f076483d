"""Exchange between an agent and its neighbors, in lock-step rounds or asynchronously.

docs/reference/crazychoir.md#17.2.

A round has a label. A message with label k belongs to round k and to no other: one that comes early waits, one that
comes late is dropped, and neither takes a turn. A round ends when every neighbor's message is there, or at its
deadline: a neighbor that is gone blocks no other agent. An agent that finds its neighbors in a later round takes over
their label.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Mapping
from typing import Any

from crazychoir_fw.common.errors import MessageError, RangeError, StateError
from crazychoir_fw.guidance.communicator_interface import Communicator, Ids, Statistics
from crazychoir_fw.guidance.frozen import SharedPose, frozen, handed_out
from crazychoir_fw.guidance.graph import NeighborSchedule
from crazychoir_fw.guidance.mailbox import NOTHING, Mailbox
from crazychoir_fw.guidance.serialization import LARGEST_BYTES, dumps, loads
from crazychoir_fw.guidance.transport import Transport

TOPIC = "agent_{agent}/communicator"
"""Where an agent publishes; with differentiated topics there is one such topic per receiver, followed by ``_{j}``."""

_LOOK_EVERY = 0.01  # [s] of real time, at which a waiting thread looks at its clock and at the stop event


class TopicCommunicator(Communicator):
    """A communicator over topics of any transport; any number of them may live in one process."""

    unkept = ("_arrival",)
    reliable = True
    """Ask the transport not to lose messages."""

    def __init__(
        self,
        agent_id: int,
        size: int,
        in_neighbors: Ids,
        out_neighbors: Ids | None = None,
        synchronous_mode: bool = True,
        differentiated_topics: bool = False,
        *,
        transport: Transport,
        deadline: float = 1.0,
        clock: Callable[[], float] | None = None,
        schedule: NeighborSchedule | None = None,
        topic: str = TOPIC,
        largest_bytes: int = LARGEST_BYTES,
    ) -> None:
        """Join.

        Args:
            agent_id: Number of this agent, [0, size - 1].
            size: Number of agents.
            in_neighbors: Agents that it may receive from: the largest graph, of which calls may name parts.
            out_neighbors: Agents that may receive from it; None is the same as `in_neighbors`.
            synchronous_mode: Rounds in lock step; otherwise the latest message of each neighbor.
            differentiated_topics: One topic per receiver, so that each may get something else.
            transport: How messages travel.
            deadline: Default timeout of a blocking receive for a round (s of `clock`).
            clock: Returns the time (s), for receives that wait and for graphs that change; None: there are none.
            schedule: Neighbors as they change; those above are the largest graph then. A message over an edge that is
                not there is dropped, and no round waits for it.
            topic: Where an agent publishes, with ``{agent}`` for its number.
            largest_bytes: Largest message, sent or received.

        Raises:
            RangeError: If an agent does not exist or is its own neighbor, or a schedule has no clock.
        """
        if not (isinstance(size, int) and size >= 1):
            raise RangeError(f"size is {size}, allowed: 1 or more")
        if not (isinstance(agent_id, int) and 0 <= agent_id < size):
            raise RangeError(f"agent_id is {agent_id}, allowed: [0, {size - 1}]")
        if not deadline > 0.0:
            raise RangeError(f"agent {agent_id}: deadline is {deadline}, allowed: above 0 s")
        if schedule is not None and clock is None:
            raise RangeError(f"agent {agent_id}: there is no clock, allowed: one, for a graph that changes")
        self.rank = agent_id
        self.size = size
        self.in_neighbors = self._ids("in_neighbors", in_neighbors)
        self.out_neighbors = self.in_neighbors if out_neighbors is None else self._ids("out_neighbors", out_neighbors)
        self.synchronous_mode = synchronous_mode
        self.differentiated_topics = differentiated_topics
        self.deadline = deadline
        self.current_label = 0
        self._transport = transport
        self._clock = clock
        self._schedule = schedule
        self._present: tuple[int, tuple[int, ...]] = (-1, ())  # in-neighbors in the graph of a round
        self._largest_bytes = largest_bytes
        self._objects = transport.carries_objects
        self._boxes = {neighbor: Mailbox() for neighbor in self.in_neighbors}
        self._statistics = Statistics()
        self._last_sent: tuple[object, tuple[int, ...] | None] | None = None
        self._arrival = threading.Condition()
        self._waiting_threads = 0
        self._subscriptions: list[tuple[str, Callable[[int, Any], None]]] = []
        self._out_topics: dict[int | None, str] = {}
        self._connect(topic)

    def _connect(self, topic: str) -> None:
        if self.differentiated_topics:
            own = topic.format(agent=self.rank)
            self._out_topics = {neighbor: f"{own}_{neighbor}" for neighbor in self.out_neighbors}
        else:
            self._out_topics = {None: topic.format(agent=self.rank)}
        for name in self._out_topics.values():
            self._transport.advertise(name, reliable=self.reliable)
        for neighbor in self._boxes:
            name = topic.format(agent=neighbor) + (f"_{self.rank}" if self.differentiated_topics else "")
            callback = self._receiver(neighbor)
            self._transport.subscribe(name, callback)
            self._subscriptions.append((name, callback))

    def _receiver(self, neighbor: int) -> Callable[[int, Any], None]:
        changes = self._schedule is not None

        # No lock here: putting into a mailbox is one step, and a thread that waits is counted before it looks.
        def receive(label: int, data: Any) -> None:
            if changes and neighbor not in self._heard_in(label):
                self._statistics.cut += 1
                return
            if self._boxes[neighbor].put(label, data, self.current_label) and self._waiting_threads:
                with self._arrival:
                    self._arrival.notify_all()

        def receive_bytes(label: int, data: bytes) -> None:
            box = self._boxes[neighbor]
            box.bytes += len(data)
            try:
                message = loads(data, self._largest_bytes)
            except MessageError:
                box.refused += 1
            else:
                receive(label, message)

        return receive if self._objects else receive_bytes

    def _heard_in(self, label: int) -> tuple[int, ...]:
        """Return the in-neighbors in the graph of a round; the schedule is queried once for the open round."""
        if label == self._present[0] and self.synchronous_mode:
            return self._present[1]
        into, _ = self._schedule.neighbors_at(self.rank, self._clock(), label)  # type: ignore[union-attr, misc]
        if label == self.current_label:
            self._present = (label, into)
        return into

    @property
    def is_lossless(self) -> bool:
        """Whether all that neighbors of this process send arrives at once."""
        return self._transport.is_lossless and self._schedule is None

    def _ids(self, what: str, neighbors: Ids) -> tuple[int, ...]:
        ids = tuple(sorted({int(neighbor) for neighbor in neighbors}))
        for neighbor in ids:
            if not 0 <= neighbor < self.size or neighbor == self.rank:
                raise RangeError(
                    f"agent {self.rank}: {what} holds {neighbor}, allowed: agents 0 to {self.size - 1} but itself"
                )
        return ids

    def _named(self, neighbors: Ids | None, all_of_them: tuple[int, ...], what: str) -> tuple[int, ...]:
        if neighbors is None:
            return all_of_them
        ids = tuple(neighbors)
        for neighbor in ids:
            if neighbor not in all_of_them:
                raise RangeError(f"agent {self.rank}: {neighbor} is none of its {what} {list(all_of_them)}")
        return ids

    # ---------------------------------------------------------------- to send

    def neighbors_send(self, obj: object, neighbors: Ids | None = None) -> None:
        """Send an object as the message of the open round.

        Args:
            obj: What `serialization` allows. Later changes of it reach no receiver.
            neighbors: Receivers; None is all. On a shared topic all hear it anyway.

        Raises:
            MessageError: If it may not be sent.
            RangeError: If a receiver is no out-neighbor.
        """
        ids = None if neighbors is None else self._named(neighbors, self.out_neighbors, "out-neighbors")
        self._send(frozen(obj) if self._objects else self._dumped(obj), ids)

    def _send(self, data: Any, ids: tuple[int, ...] | None) -> None:
        self._last_sent = (data, ids)
        label = self.current_label
        topics = self._out_topics
        if not self.differentiated_topics:
            self._publish(topics[None], label, data)
            return
        for neighbor in self.out_neighbors if ids is None else ids:
            self._publish(topics[neighbor], label, data[neighbor] if isinstance(data, _PerNeighbor) else data)

    def _publish(self, topic: str, label: int, data: Any) -> None:
        statistics = self._statistics
        statistics.sent += 1
        if not self._objects:
            statistics.bytes_sent += len(data)
        self._transport.publish(topic, label, data)

    # ---------------------------------------------------------------- to receive without waiting

    def has_round(self, neighbors: Ids | None = None) -> bool:
        """Return whether the messages of the open round are all there."""
        label, boxes = self.current_label, self._boxes
        if self._transport.has_waiting:
            self._transport.deliver()
        for neighbor in self.in_neighbors if neighbors is None else neighbors:
            if label not in boxes[neighbor].waiting and (self._schedule is None or neighbor in self._heard_in(label)):
                return False
        return True

    def collect(self, neighbors: Ids | None = None) -> dict[int, Any]:
        """End the open round: return what is there of it, by neighbor, and open the next one."""
        label, boxes = self.current_label, self._boxes
        if self._transport.has_waiting:
            self._transport.deliver()
        present = None if self._schedule is None else self._heard_in(label)
        self.current_label = label + 1  # first, so that what comes meanwhile is late
        data, lost = {}, 0
        for neighbor in self.in_neighbors if neighbors is None else neighbors:
            message = boxes[neighbor].waiting.pop(label, NOTHING)
            if message is NOTHING:
                lost += present is None or neighbor in present
            else:
                data[neighbor] = message if type(message) is SharedPose else handed_out(message)
        self._statistics.lost += lost
        self._statistics.rounds += 1
        self._drop_old()
        return data

    def _drop_old(self) -> None:
        for box in self._boxes.values():
            if box.waiting:
                box.drop_before(self.current_label)

    def latest(self, neighbor: int) -> Any:
        """Return the message that came last from a neighbor, of any round, or `NOTHING`."""
        return handed_out(self._boxes[neighbor].latest)

    def heard(self, neighbor: int) -> int:
        """Return how many messages came from a neighbor, of any round: it lives while that number grows."""
        return self._boxes[neighbor].heard

    def newest_label(self, neighbor: int) -> int:
        """Return the label of the message that came last from a neighbor, -1 before the first."""
        return self._boxes[neighbor].newest_label

    def catch_up(self) -> bool:
        """Take over the newest label that any neighbor has sent, if it is ahead; return whether it was."""
        label = self.current_label
        for box in self._boxes.values():
            if box.newest_label > label:
                label = box.newest_label
        if label == self.current_label:
            return False
        self._jump(label)
        return True

    @property
    def has_begun_elsewhere(self) -> bool:
        """Whether a neighbor has sent a message of the open round, or of a later one."""
        label = self.current_label
        return any(box.newest_label >= label for box in self._boxes.values())

    def skip(self) -> None:
        """Leave the open round out, which others have had without this agent."""
        self._jump(self.current_label + 1)

    def _jump(self, label: int) -> None:
        self.current_label = label
        self._drop_old()
        self._statistics.jumps += 1

    # ---------------------------------------------------------------- to receive, waiting

    def neighbors_receive(
        self,
        neighbors: Ids | None = None,
        stop_event: threading.Event | None = None,
        timeout: float | None = None,
    ) -> dict[int, Any]:
        """Wait for the messages of the open round and end it.

        Args:
            neighbors: Neighbors to wait for; None is all in-neighbors.
            stop_event: Set by another thread, it ends the wait.
            timeout: How long to wait at most (s of the clock); None is the deadline of this communicator. May be
                infinite.

        Returns:
            Messages by neighbor, without neighbors that did not send in time.

        Raises:
            StateError: In asynchronous mode, or if it had to wait without a clock.
            RangeError: If one is no in-neighbor.
        """
        if not self.synchronous_mode:
            raise StateError(f"agent {self.rank}: neighbors_receive needs synchronous_mode=True")
        ids = self._named(neighbors, self.in_neighbors, "in-neighbors")
        complete = self.has_round(ids) or self._wait(ids, stop_event, self.deadline if timeout is None else timeout)
        data = self.collect(ids)
        if not complete:
            # others may have gone on without this agent
            self.catch_up()
        return data

    def _wait(self, ids: tuple[int, ...], stop_event: threading.Event | None, timeout: float) -> bool:
        clock = self._clock
        if clock is None and timeout < math.inf:
            raise StateError(f"agent {self.rank}: to wait it needs a clock, such as clock=time.monotonic")
        end = math.inf if clock is None else clock() + timeout
        with self._arrival:
            self._waiting_threads += 1
            try:
                while not self.has_round(ids):
                    if self._statistics.rounds == 0 and self._joined(ids):
                        continue
                    if (stop_event is not None and stop_event.is_set()) or (clock is not None and clock() >= end):
                        return False
                    self._arrival.wait(_LOOK_EVERY)
                return True
            finally:
                self._waiting_threads -= 1

    def _joined(self, ids: tuple[int, ...]) -> bool:
        """Take over the first round that all neighbors can still complete, if some are past the one that is open."""
        firsts = [min(list(self._boxes[one].waiting), default=-1) for one in ids]
        label = max(firsts, default=-1)
        if -1 in firsts or label <= self.current_label:
            return False
        self._jump(label)
        if self._last_sent is not None:
            self._send(*self._last_sent)
        return True

    def neighbors_receive_asynchronous(self, neighbors: Ids | None = None) -> dict[int, Any]:
        """Return what came since the last call, the latest of each neighbor, without waiting.

        Raises:
            StateError: In synchronous mode.
            RangeError: If one is no in-neighbor.
        """
        if self.synchronous_mode:
            raise StateError(f"agent {self.rank}: neighbors_receive_asynchronous needs synchronous_mode=False")
        data = {}
        if self._transport.has_waiting:
            self._transport.deliver()
        for neighbor in self._named(neighbors, self.in_neighbors, "in-neighbors"):
            box = self._boxes[neighbor]
            box.waiting.clear()
            if box.heard > box.handed_out:
                box.handed_out = box.heard
                data[neighbor] = handed_out(box.latest)
        return data

    def neighbors_exchange(
        self,
        obj: object,
        in_neighbors: Ids | None = None,
        out_neighbors: Ids | None = None,
        dict_neigh: bool = False,
        stop_event: threading.Event | None = None,
        timeout: float | None = None,
    ) -> dict[int, Any]:
        """Send, then receive the same round.

        Args:
            obj: What to send; with `dict_neigh`, by receiver.
            in_neighbors: Neighbors to wait for; None is all.
            out_neighbors: Receivers; None is all.
            dict_neigh: `obj` is a dictionary from receiver to object; needs differentiated topics.
            stop_event: Set by another thread, it ends the wait.
            timeout: How long to wait at most (s of the clock); None is the deadline of this communicator.

        Returns:
            Messages by neighbor, without neighbors that did not send in time.

        Raises:
            MessageError: If something may not be sent.
            RangeError: If one is no neighbor, or a receiver has no object.
            StateError: With `dict_neigh` on a shared topic, or in asynchronous mode.
        """
        if dict_neigh:
            self._send_each(obj, out_neighbors)
        else:
            self.neighbors_send(obj, out_neighbors)
        return self.neighbors_receive(in_neighbors, stop_event, timeout)

    def _send_each(self, objects: object, neighbors: Ids | None) -> None:
        if not self.differentiated_topics:
            raise StateError(f"agent {self.rank}: an object per neighbor needs differentiated_topics=True")
        if not isinstance(objects, Mapping):
            raise RangeError(f"agent {self.rank}: obj is a {type(objects).__name__}, allowed: objects by neighbor")
        ids = self._named(neighbors, self.out_neighbors, "out-neighbors")
        if missing := [one for one in ids if one not in objects]:
            raise RangeError(f"agent {self.rank}: there is no object for neighbor {missing[0]}")
        pack = frozen if self._objects else self._dumped
        self._send(_PerNeighbor({one: pack(objects[one]) for one in ids}), ids)

    def _dumped(self, obj: object) -> bytes:
        return dumps(obj, self._largest_bytes)

    # ---------------------------------------------------------------- what it has seen

    @property
    def statistics(self) -> Statistics:
        """What happened so far."""
        boxes = self._boxes.values()
        counts = self._statistics
        return Statistics(
            rounds=counts.rounds,
            sent=counts.sent,
            received=sum(box.heard for box in boxes),
            lost=counts.lost,
            cut=counts.cut,
            late=sum(box.late for box in boxes),
            refused=sum(box.refused for box in boxes),
            jumps=counts.jumps,
            bytes_sent=counts.bytes_sent,
            bytes_received=sum(box.bytes for box in boxes),
        )

    def close(self) -> None:
        """Unsubscribe from all neighbors."""
        for topic, callback in self._subscriptions:
            self._transport.unsubscribe(topic, callback)
        self._subscriptions.clear()


class _PerNeighbor(dict[int, Any]):
    """A packed message for each receiver."""
