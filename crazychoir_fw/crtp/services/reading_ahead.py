"""A table of contents, sent ahead of its questions.

A client asks for one item after the other, and each of the thirty clients of a swarm waits for its turn in one process
before it sees the answer. So a client that has asked for some items in a row gets the following ones unasked. A
question for one of these is answered already; the last item is sent only when it is asked for. In all every question
has one answer, in the order of the questions, and a client that stops in between finds items that it does not wait for,
which cflib ignores.

Over UDP a client never repeats a request. So when no question has followed for some time, the pending item is sent
again: if the client is only slow, it ignores the second copy.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable

from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.services.service import Reply
from crazychoir_fw.crtp.toc import ITEM, TableOfContents

AHEAD = 128
"""So many items are under way at most: the socket of a client holds 256 packets (docs/reference/crtp-cflib.md#3.4), a
burst of log data among them."""
IN_A_ROW = 4
"""So many items a client asks for, one after the other, before the next ones come unasked."""
LOOKS = 10
"""Looks of the radio without a question, after which an item is sent again: 0.2 s."""
MAX_COPIES = 20

_CHANNEL = 0


class ReadingAhead:
    """Answers questions about one table of contents of one drone. Only the radio thread calls it."""

    def __init__(self, context: ServiceContext, port: int, toc: TableOfContents) -> None:
        self._context = context
        self._port = port
        self._toc = toc
        self._last = len(toc) - 1
        self.forget()

    def forget(self) -> None:
        """Begin again, with another client."""
        self._next = -1  # a question for this one goes on in order
        self._in_a_row = 0
        self._sent = 0  # items below are with the client or on their way
        self._looks = self._copies = 0
        self._context.looks.discard(self._look)

    def receive(self, payload: bytes) -> Iterable[Reply]:
        """Return the answers to a request on channel 0."""
        if not self._context.reads_ahead or len(payload) != 3 or payload[0] != ITEM:
            answer = self._toc.answer(payload)
            return () if answer is None else ((_CHANNEL, answer),)
        return tuple((_CHANNEL, self._item(number)) for number in self._due(int.from_bytes(payload[1:], "little")))

    def _due(self, number: int) -> Iterable[int]:
        """Return which items are to be sent now that one is asked for."""
        if number != self._next or number > self._last:
            self.forget()
        self._next = number + 1
        self._in_a_row += 1
        if self._in_a_row < IN_A_ROW or number >= self._last:
            self._context.looks.discard(self._look)
            self._sent = number + 1
            return (number,)
        self._looks = self._copies = 0
        self._context.looks.add(self._look)
        first = max(self._sent, number)
        if first - number > AHEAD // 2:
            return ()
        # the last one only when it is asked for: then no item is under way any more
        self._sent = max(first, min(number + AHEAD, self._last))
        return range(first, self._sent)

    def _item(self, number: int) -> bytes:
        answer = self._toc.answer(struct.pack("<BH", ITEM, number))
        assert answer is not None
        return answer

    def _look(self) -> None:
        """Send the pending item again after a timeout."""
        self._looks += 1
        if self._looks < LOOKS:
            return
        self._looks = 0
        self._copies += 1
        if self._copies >= MAX_COPIES:
            self._context.looks.discard(self._look)
        self._context.send(self._port, _CHANNEL, self._item(self._next - 1))
