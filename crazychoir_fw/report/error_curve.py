"""An error over time, as the page about a flight shows it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class ErrorCurve:
    """Mean and largest of several errors at each sample of a log."""

    label: str
    """What it is, with its unit."""
    mean: NDArray[np.float64]  # (T,)
    largest: NDArray[np.float64]  # (T,)
    limit: float | None = None
    """What is allowed at the end."""
