"""The same for several drones at once."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from crazychoir_fw.common.errors import CrazychoirError

T = TypeVar("T")


def in_parallel(items: Iterable[T], do: Callable[[T], Any]) -> list[tuple[T, Exception]]:
    """Do something for every item, each in a thread of its own, and return what failed, in the order of items."""
    wanted = list(items)
    failures: list[tuple[T, Exception]] = []

    def one(item: T) -> None:
        try:
            do(item)
        except Exception as error:
            failures.append((item, error))

    if len(wanted) == 1:
        one(wanted[0])
    else:
        threads = [threading.Thread(target=one, args=(item,), name="radio-parallel", daemon=True) for item in wanted]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    return sorted(failures, key=lambda failure: wanted.index(failure[0]))


def raise_together(failures: list[tuple[Any, Exception]], of: int) -> None:
    """Raise what failed, as one error.

    Args:
        failures: What `in_parallel` returned.
        of: How many there were in all.
    """
    if not failures:
        return
    errors = [error for _, error in failures]
    for error in errors:
        if not isinstance(error, CrazychoirError):
            raise error
    if len(errors) == 1:
        raise errors[0]
    text = f"{len(errors)} of {of} drones: " + "; ".join(str(error) for error in errors)
    raise type(errors[0])(text) from errors[0]
