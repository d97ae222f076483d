"""Curves that are piecewise polynomials of time."""

from __future__ import annotations

from bisect import bisect_right
from math import factorial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError

Array = NDArray[np.float64]

_FLAT_ORDERS = 4  # position, velocity, acceleration, jerk


class Polynomial:
    """A curve over [0, `duration`] made of polynomial pieces; a value, never changed.

    Times outside are taken for the nearer end. At a knot the piece that begins there counts.

    Attributes:
        durations: Duration of each piece (s), shape (n,).
        coefficients: Of ascending powers of the time since the begin of the piece, shape (n, axes, k).
        knots: Where pieces begin, and the end (s), shape (n + 1,).
        duration: Duration of the whole (s).
    """

    def __init__(self, durations: ArrayLike, coefficients: ArrayLike) -> None:
        durations, coefficients = np.array(durations, dtype=float), np.array(coefficients, dtype=float)
        if coefficients.ndim != 3 or not coefficients.size or durations.shape != coefficients.shape[:1]:
            shapes = f"{durations.shape} and {coefficients.shape}"
            raise RangeError(
                f"Polynomial: durations and coefficients have shapes {shapes}, allowed: (n,) and (n, axes, k)"
            )
        if not (np.isfinite(coefficients).all() and np.isfinite(durations).all() and durations.min() > 0.0):
            raise RangeError("Polynomial: allowed: finite coefficients, and durations above 0 s")
        self.durations = durations
        self.coefficients = coefficients
        self.knots = np.concatenate([[0.0], np.cumsum(durations)])
        self.duration = float(self.knots[-1])
        for array in (self.durations, self.coefficients, self.knots):
            array.flags.writeable = False
        # for one instant at a time: all derivatives of all axes of a piece in one product of matrix and powers
        pieces, axes, size = coefficients.shape
        stacked = np.zeros((pieces, _FLAT_ORDERS, axes, size))
        for order in range(min(_FLAT_ORDERS, size)):
            stacked[:, order, :, : size - order] = self.derived(order)
        self._stacked = list(stacked.reshape(pieces, _FLAT_ORDERS * axes, size))
        self._begins = self.knots[:-1].tolist()
        self._powers = range(size - 1)
        self._flat_shape = (_FLAT_ORDERS, axes)

    def __len__(self) -> int:
        return len(self.durations)

    def __repr__(self) -> str:
        return f"<Polynomial of {len(self)} pieces, degree {self.coefficients.shape[2] - 1}, {self.duration:g} s>"

    @property
    def axes(self) -> int:
        """Number of axes."""
        return self.coefficients.shape[1]

    def at(self, times: ArrayLike, order: int = 0) -> Array:
        """Return a derivative at any number of times.

        Args:
            times: Times since the begin (s), shape (...).
            order: 0 is the position, 1 the velocity, and so on.

        Returns:
            Shape (..., axes).
        """
        t = np.clip(np.asarray(times, dtype=float), 0.0, self.duration)
        piece = np.clip(np.searchsorted(self.knots, t, side="right") - 1, 0, len(self) - 1)
        tau = (t - self.knots[piece])[..., None]
        coefficients = self.derived(order)[piece]
        value = np.zeros(coefficients.shape[:-1])
        for k in reversed(range(coefficients.shape[-1])):
            value = value * tau + coefficients[..., k]
        return value

    def position(self, times: ArrayLike) -> Array:
        """Return positions (m), shape (..., axes), at *times* (s), shape (...)."""
        return self.at(times, 0)

    def velocity(self, times: ArrayLike) -> Array:
        """Return velocities (m/s), shape (..., axes)."""
        return self.at(times, 1)

    def acceleration(self, times: ArrayLike) -> Array:
        """Return accelerations (m/s^2), shape (..., axes)."""
        return self.at(times, 2)

    def jerk(self, times: ArrayLike) -> Array:
        """Return jerks (m/s^3), shape (..., axes)."""
        return self.at(times, 3)

    def snap(self, times: ArrayLike) -> Array:
        """Return snaps (m/s^4), shape (..., axes)."""
        return self.at(times, 4)

    def flat(self, time: float) -> Array:
        """Return position, velocity, acceleration and jerk at one time (s), shape (4, axes); made for control loops."""
        t = 0.0 if time < 0.0 else self.duration if time > self.duration else time
        piece = bisect_right(self._begins, t) - 1
        tau = t - self._begins[piece]
        powers = [1.0]
        power = 1.0
        for _ in self._powers:
            power *= tau
            powers.append(power)
        return self._stacked[piece].dot(powers).reshape(self._flat_shape)

    def end(self, order: int = 0) -> Array:
        """Return a derivative at the end, shape (axes,)."""
        return self.at(self.duration, order)

    def stretched(self, factor: float) -> Polynomial:
        """Return the same path flown *factor* times as slowly: the k-th derivative falls by factor^k."""
        if not 0.0 < factor < np.inf:
            raise RangeError(f"Polynomial: it cannot be stretched by {factor}, allowed: a number above 0")
        powers = float(factor) ** -np.arange(self.coefficients.shape[2])
        return Polynomial(self.durations * factor, self.coefficients * powers)

    def cost(self, order: int = 4) -> float:
        """Return the integral of the squared derivative of that order over time, summed over axes."""
        derived = self.derived(order)
        k = np.arange(derived.shape[2])
        powers = k[:, None] + k + 1
        grams = self.durations[:, None, None] ** powers / powers
        return float(np.einsum("pai,pij,paj->", derived, grams, derived))

    def derived(self, order: int) -> Array:
        """Return the coefficients of a derivative, shape (n, axes, k - order); one zero where nothing is left."""
        size = self.coefficients.shape[2]
        if order >= size:
            return np.zeros((*self.coefficients.shape[:2], 1))
        factors = np.array([factorial(k) / factorial(k - order) for k in range(order, size)])
        return self.coefficients[:, :, order:] * factors
