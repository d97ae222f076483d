"""Values from a file as they may stand in a message: short, on one line, whatever they are."""

import reprlib
from typing import Any

_short = reprlib.Repr()
_short.maxstring = 40
_short.maxother = 40
_short.maxlevel = 3


def show(value: Any) -> str:
    """Return a value from a file as it may stand in a message."""
    if isinstance(value, int) and abs(value) >= 10**30:
        return "a huge number"
    try:
        return one_line(_short.repr(value))
    except Exception:  # a repr of nested data may fail in ways of its own, and a message must not
        return f"a {type(value).__name__}"


def one_line(text: str) -> str:
    """Return a text without line breaks, cut short."""
    return " ".join(text.split())[:160]
