"""Python's garbage collector during a flight."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def present_objects_frozen() -> Iterator[None]:
    """Leave the objects that exist now, such as modules and missions, out of garbage collection for a while.

    A collection looks at all objects with references; in a flight it would look at a hundred thousand that stay.
    Nothing happens where another component has frozen objects already.
    """
    if gc.get_freeze_count():
        yield
        return
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
