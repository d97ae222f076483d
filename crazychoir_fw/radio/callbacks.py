"""A user's function may raise anything, and stops nothing but itself."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

LOGGER = logging.getLogger("crazychoir_fw.radio")


def call(function: Callable[..., Any] | None, *arguments: object) -> None:
    """Call a user's function, if there is one; what it raises is logged."""
    if function is None:
        return
    try:
        function(*arguments)
    except Exception:
        LOGGER.exception("a callback failed: %r", function)
