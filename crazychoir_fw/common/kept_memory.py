"""Lets a process that flies one flight after the other use the same memory for all of them."""

from __future__ import annotations

import ctypes
import sys

_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD = -1, -3  # of <malloc.h>
_LARGE = 1 << 30  # [bytes]


def keep_freed_memory() -> bool:
    """Ask the C library to keep freed memory of any size, and return whether it does.

    Blocks above some 100 KiB otherwise go back to the system, and every page of the next flight's log is a page fault:
    a tenth of the CPU time of a flight. Does nothing where the C library has no such request.
    """
    if not sys.platform.startswith("linux"):
        return False
    request = getattr(ctypes.CDLL(None), "mallopt", None)
    if request is None:
        return False
    return bool(request(_M_MMAP_THRESHOLD, _LARGE)) and bool(request(_M_TRIM_THRESHOLD, _LARGE))
