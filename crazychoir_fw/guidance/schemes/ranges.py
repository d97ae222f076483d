"""Numbers of a scheme that must lie above zero."""

from __future__ import annotations

import math

from crazychoir_fw.common.errors import RangeError


def above_zero(who: str, most: float = math.inf, **values: float) -> None:
    """Check numbers by their names.

    Args:
        who: Says whose numbers they are, in the error.
        most: The largest that is allowed.
        values: The numbers.

    Raises:
        RangeError: If one is not above zero, not finite, or too large.
    """
    upper = f", at most {most:g}" if math.isfinite(most) else ""
    for name, value in values.items():
        if not (math.isfinite(value) and 0.0 < value <= most):
            raise RangeError(f"{who}: {name} is {value}, allowed: above 0{upper}")
