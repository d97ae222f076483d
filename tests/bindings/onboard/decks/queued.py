"""The queue of an estimator, as the tests of the deck drivers look into it."""

from typing import Any

from crazychoir_fw._core import ffi

_taken: list[Any] = []  # a view of a member does not keep its struct alive, so this does


def take(estimator: Any) -> list[Any]:
    """Return copies of the measurements in the queue, oldest first, and empty it."""
    count, estimator.queue_count = estimator.queue_count, 0
    copies = [ffi.new("measurement_t *", estimator.queue[i]) for i in range(count)]
    _taken.extend(copies)
    return copies
