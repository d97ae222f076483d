"""What threads of a handler need: guarded callbacks, calls for several drones at once, and links closed at the end."""

from __future__ import annotations

import logging
import threading
import weakref
from collections.abc import Callable, Iterable
from typing import Any, Protocol, TypeVar

from crazychoir_fw.common.errors import CrazychoirError

LOGGER = logging.getLogger("crazychoir_fw.radio")


def call(function: Callable[..., Any] | None, *arguments: object) -> None:
    """Call a user's function, if there is one; what it raises is logged."""
    if function is None:
        return
    try:
        function(*arguments)
    except Exception:
        LOGGER.exception("a callback failed: %r", function)


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


class _Closes(Protocol):
    def close(self) -> None: ...


_open: weakref.WeakSet[_Closes] = weakref.WeakSet()
_lock = threading.Lock()
_watcher: threading.Thread | None = None


def close_at_exit(handler: _Closes) -> None:
    """Have `close` called when the main thread has ended, unless it is forgotten before."""
    global _watcher
    with _lock:
        _open.add(handler)
        if _watcher is None or not _watcher.is_alive():
            _watcher = threading.Thread(target=_watch, name="radio-exit", daemon=False)
            _watcher.start()


def forget(handler: _Closes) -> None:
    """Take back `close_at_exit`."""
    with _lock:
        _open.discard(handler)


def _watch() -> None:
    threading.main_thread().join()
    with _lock:
        handlers = list(_open)
    for handler in handlers:
        call(handler.close)
