"""Python values as C integers and truth values, as strict as SWIG where that matters and no stricter."""

from __future__ import annotations

import operator
from typing import Any

import numpy as np

integer = operator.index
"""Returns an int; TypeError for a float, also one that is whole."""


def truth(value: Any) -> bool:
    """Return a bool from a bool or an int.

    Raises:
        TypeError: For anything else.
    """
    if value is True or value is False:
        return value
    if isinstance(value, np.bool_):
        return bool(value)
    return operator.index(value) != 0
