"""`Presence`: which neighbors are present and which are lost, by time or by rounds."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from crazychoir_fw.guidance.communicator import TopicCommunicator

LATE_ROUNDS = 3
"""A neighbor that is farther behind counts rounds by itself, and no round waits for its message."""


class Presence:
    """Counts what neighbors send. A neighbor is lost after a time of silence, or after rounds without its message."""

    def __init__(self, communicator: TopicCommunicator) -> None:
        """Begin with every neighbor present."""
        self._communicator = communicator
        self.lost: set[int] = set()
        """Neighbors that have fallen silent."""
        self.reset()

    def reset(self) -> None:
        """Take every neighbor for present."""
        neighbors = self._communicator.in_neighbors
        self.lost -= set(neighbors)
        self._heard = {one: self._communicator.heard(one) for one in neighbors}
        self._last_heard: dict[int, float] = {}
        self._missed = dict.fromkeys(neighbors, 0)

    def forget(self, neighbor: int) -> None:
        """Begin the time of silence of a neighbor with the next look."""
        self._last_heard.pop(neighbor, None)

    def look(self, now: float, neighbors: Iterable[int], silence: float) -> tuple[list[int], list[int]]:
        """Return which neighbors are lost now and which are back, by time (s)."""
        lost, back = [], []
        for one in neighbors:
            if self._has_news(one):
                self._last_heard[one] = now
                if one in self.lost:
                    back.append(one)
            elif now - self._last_heard.setdefault(one, now) >= silence and one not in self.lost:
                lost.append(one)
        self.lost.update(lost)
        self.lost.difference_update(back)
        return lost, back

    def count(self, missing: Collection[int], neighbors: Iterable[int], rounds: int = 1) -> list[int]:
        """Return which neighbors are lost now, having been missing for so many rounds in a row."""
        lost = []
        for one in neighbors:
            if one not in self.lost:
                self._missed[one] = self._missed[one] + 1 if one in missing else 0
                if self._missed[one] >= rounds:
                    lost.append(one)
                    self._has_news(one)  # what counts is what comes from now on
        self.lost.update(lost)
        return lost

    def welcome(self, late_rounds: int | None = None) -> list[int]:
        """Return which lost neighbors are back: heard again, and at most so many rounds behind."""
        communicator, back = self._communicator, []
        for one in communicator.in_neighbors:
            is_late = (
                late_rounds is not None and communicator.newest_label(one) < communicator.current_label - late_rounds
            )
            if one in self.lost and self._has_news(one) and not is_late:
                back.append(one)
                self._missed[one] = 0
        self.lost.difference_update(back)
        return back

    def _has_news(self, neighbor: int) -> bool:
        heard = self._communicator.heard(neighbor)
        is_new = heard != self._heard[neighbor]
        self._heard[neighbor] = heard
        return is_new
