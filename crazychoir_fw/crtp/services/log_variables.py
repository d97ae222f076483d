"""Where log variables are and how they are read, by their numbers in the table of contents."""

from __future__ import annotations

import functools
from typing import NamedTuple

from crazychoir_fw.crtp.toc import LOG_TYPES, log_toc
from crazychoir_fw.simulation.clients.variables import is_computed_when_read


class LogVariable(NamedTuple):
    """Where a variable is, and what must be done to read it."""

    offset: int
    """Place within ``cf_t`` (bytes)."""
    stored: int
    """Type, as the log service numbers them."""
    is_computed_when_read: bool
    """Whether the log variables are brought up to date first."""


@functools.cache
def log_variables(provider: int) -> tuple[LogVariable, ...]:
    """Return all log variables of drones with this provider."""
    return tuple(
        LogVariable(row.offset, LOG_TYPES[row.dtype.str[1:]], is_computed_when_read(row, provider))
        for row in log_toc(provider).variables
    )
