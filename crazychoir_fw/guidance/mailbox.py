"""What has come from one neighbor and waits for its round."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from crazychoir_fw.errors import MessageError

LARGEST_LABEL = 1 << 53
"""Labels are below: what a neighbor sends must leave room to count on."""

NOTHING = object()
"""Stands for a message that is not there; None may be sent."""


class Mailbox:
    """Messages by label: those of rounds to come wait, those of rounds that are over are dropped."""

    def __init__(self, most_waiting: int) -> None:
        """Make an empty one that holds at most so many messages."""
        self.waiting: dict[int, Any] = {}
        self.newest_label = -1
        """Label of the message that came last: a neighbor that was started again counts from 0."""
        self.latest: Any = NOTHING
        """The message that came last, of any round."""
        self.fresh = False
        """`latest` has not been handed out by an asynchronous receive."""
        self.heard = 0
        """Messages that came, also late ones."""
        self.late = 0
        self.refused = 0
        self.bytes = 0
        self.current = 0
        """Label of the round that is open: older ones are late."""
        self._most_waiting = most_waiting

    def put(self, label: int, data: Any, decode: Callable[[bytes], Any] | None) -> bool:
        """Take a message in; False if it is none."""
        if decode is not None:
            try:
                self.bytes += len(data)
                data = decode(data)
            except MessageError:
                self.refused += 1
                return False
        if not 0 <= label < LARGEST_LABEL:
            self.refused += 1
            return False
        self.heard += 1
        self.newest_label = label
        self.latest = data
        self.fresh = True
        if label < self.current:
            self.late += 1
        elif len(self.waiting) < self._most_waiting or label in self.waiting:
            self.waiting[label] = data
        else:
            self.refused += 1
        return True

    def drop_before(self, label: int) -> None:
        """Begin the round `label`: older messages will never be asked for."""
        self.current = label
        waiting = self.waiting
        if waiting:
            for old in [one for one in list(waiting) if one < label]:
                if waiting.pop(old, NOTHING) is not NOTHING:
                    self.late += 1
