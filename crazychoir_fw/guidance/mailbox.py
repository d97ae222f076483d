"""What has come from one neighbor and waits for its round."""

from __future__ import annotations

import enum
from typing import Any, Final

LARGEST_LABEL = 1 << 53
"""Labels are below: what a neighbor sends must leave room to count on."""


class _Nothing(enum.Enum):
    NOTHING = enum.auto()


NOTHING: Final = _Nothing.NOTHING
"""Stands for a message that is not there; None may be sent."""

_MAX_WAITING = 10_000  # early messages of one neighbor: a limit for memory, not for any use


class Mailbox:
    """Messages by label: those of rounds to come wait, those of rounds that are over are dropped."""

    __slots__ = ("bytes", "handed_out", "heard", "late", "latest", "newest_label", "refused", "waiting")

    def __init__(self) -> None:
        self.waiting: dict[int, Any] = {}
        self.newest_label = -1
        """Label of the message that came last: a neighbor that was started again counts from 0."""
        self.latest: Any = NOTHING
        """The message that came last, of any round."""
        self.heard = 0
        """Messages that came, also late ones."""
        self.handed_out = 0
        """How many had come when an asynchronous receive took the latest."""
        self.late = 0
        self.refused = 0
        self.bytes = 0

    def put(self, label: int, data: Any, current: int) -> bool:
        """Take in a message while the round `current` is open; False if it is none."""
        if not 0 <= label < LARGEST_LABEL:
            self.refused += 1
            return False
        self.heard += 1
        self.newest_label = label
        self.latest = data
        if label < current:
            self.late += 1
        elif len(self.waiting) < _MAX_WAITING or label in self.waiting:
            self.waiting[label] = data
        else:
            self.refused += 1
        return True

    def drop_before(self, label: int) -> None:
        """Drop messages of rounds before `label`: those rounds are over."""
        waiting = self.waiting
        for old in [one for one in list(waiting) if one < label]:
            if waiting.pop(old, NOTHING) is not NOTHING:
                self.late += 1
