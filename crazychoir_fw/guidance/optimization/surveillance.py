r"""Cost of a defender between an intruder and the target that all of them guard (docs/reference/crazychoir.md#8.3).

.. math::
    f_i(x, \sigma) = \gamma_{intr} |x - r_i|^2 + \gamma_{targ} |\sigma - b|^2 + \gamma_{shape} |x - \sigma|^2

With all weights 1 the optimum is half-way: :math:`x_i = (r_i + b)/2`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.optimization.algorithm import vector

Array = NDArray[np.float64]


class SurveillanceProblem:
    """One defender's cost; what is not there drops out of it."""

    def __init__(
        self,
        intruder: ArrayLike | None = None,
        target: ArrayLike | None = None,
        *,
        gamma_intruder: float = 1.0,
        gamma_target: float = 1.0,
        gamma_shape: float = 1.0,
    ) -> None:
        """Choose it.

        Args:
            intruder: Where this agent's intruder is (m), shape (n,).
            target: Where the target is (m), shape (n,).
            gamma_intruder: Weight of being near the intruder.
            gamma_target: Weight of all agents' center being near the target.
            gamma_shape: Weight of being near all agents' center.

        Raises:
            RangeError: If there is neither intruder nor target, or a weight is negative.
        """
        if intruder is None and target is None:
            raise RangeError("surveillance: there is neither intruder nor target, allowed: at least one")
        for name, gamma in (("intruder", gamma_intruder), ("target", gamma_target), ("shape", gamma_shape)):
            if not 0.0 <= gamma < np.inf:
                raise RangeError(f"surveillance: gamma_{name} is {gamma}, allowed: 0 or more")
        self.intruder = None if intruder is None else vector("intruder", intruder)
        self.target = None if target is None else vector("target", target)
        self.gamma_intruder, self.gamma_target, self.gamma_shape = gamma_intruder, gamma_target, gamma_shape

    def value(self, x: Array, sigma: Array) -> float:
        """Return the cost (m^2)."""
        cost = self.gamma_shape * np.sum((x - sigma) ** 2)
        if self.intruder is not None:
            cost += self.gamma_intruder * np.sum((x - self.intruder) ** 2)
        if self.target is not None:
            cost += self.gamma_target * np.sum((sigma - self.target) ** 2)
        return float(cost)

    def gradients(self, x: Array, sigma: Array) -> tuple[Array, Array]:
        """Return the gradients by own position and by center (m), each of shape (n,)."""
        by_own = 2.0 * self.gamma_shape * (x - sigma)
        by_mean = -by_own
        if self.intruder is not None:
            by_own = by_own + 2.0 * self.gamma_intruder * (x - self.intruder)
        if self.target is not None:
            by_mean = by_mean + 2.0 * self.gamma_target * (sigma - self.target)
        return by_own, by_mean
