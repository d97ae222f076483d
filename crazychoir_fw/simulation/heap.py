"""Memory that building a world has used for a while, given back to the system."""

from __future__ import annotations

import ctypes
import sys

WORTH_IT = 30
"""Drones from which on a world leaves enough behind, 60 KiB each."""


def give_back_memory() -> None:
    """Ask the C library to return what it keeps of freed memory, which takes some milliseconds.

    MuJoCo's description of a model is larger than the model, and made of small pieces: freed, they stay with the
    process, which would count more than half of a large world's memory twice. Does nothing where the C library has no
    such request.
    """
    if not sys.platform.startswith("linux"):
        return
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(ctypes.c_size_t(0))
