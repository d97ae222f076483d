"""Links are closed when the program ends, however it ends.

cflib's threads that ping keep a program alive after its main thread has ended, and the functions of `atexit` run only
after such threads. So a thread of our own waits for the end of the main thread.
"""

from __future__ import annotations

import threading
import weakref
from typing import Protocol

from crazychoir_fw.radio.callbacks import call


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
