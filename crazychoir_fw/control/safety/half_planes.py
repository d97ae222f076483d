"""What barriers leave of the inputs of agents."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class HalfPlanes(NamedTuple):
    """Half-planes of inputs that are safe for N agents, one per agent near each."""

    normals: Array
    """Shape (N, K, 2); an input is safe where its product with the normal is not above the side."""
    sides: Array
    """Shape (N, K)."""
    barriers: Array
    """Values of the barriers, shape (N, K)."""

    def of_some(self, agents: NDArray[np.intp]) -> HalfPlanes:
        """Return those of some of the agents."""
        return HalfPlanes(*(part[agents] for part in self))
