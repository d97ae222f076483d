"""Motors that fade as they warm up.

On every recorded flight the thrust at a given voltage falls by some percent within the first ten seconds, and then
rests: the windings of the brushed motors get warm. The plant has no such state; here it is a factor on the thrust.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class WarmUp:
    """Thrust over cold thrust: 1 - loss (1 - exp(-t / time)), t since the motors were switched on."""

    loss: float = 0.0
    """What is lost in the end, in [0, 1)."""
    time: float = 5.0
    """Time constant (s)."""

    def factor(self, since_on: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the factor at times since the motors were switched on (s)."""
        return 1.0 - self.loss * (1.0 - np.exp(-np.maximum(since_on, 0.0) / self.time))
