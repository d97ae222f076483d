"""Compute figure8.csv: a closed figure-8 of 2 m by 1 m, at rest at both ends, as polynomials of degree 7.

    python examples/make_figure8.py [OUTPUT.csv]

The path is x = sin(theta), y = sin(2 theta) / 2. Its phase theta gathers speed smoothly, keeps it, and loses it again.
Each piece takes position, velocity, acceleration and jerk of the path at both of its ends: eight numbers per axis,
as many as a polynomial of degree 7 has.
"""

import sys
from math import cos, factorial, pi, sin
from pathlib import Path

import numpy as np

from crazychoir_fw.common.trajectory_files import write_pieces

RATE = 0.8  # [rad/s], of the phase at full speed
RAMP = 2.0  # [s], to reach it, and to leave it
DURATION = 2 * pi / RATE + RAMP  # [s]
PIECES = 10


def phase(t):
    """Return the phase (rad) and its first three derivatives at time t (s)."""
    if t > DURATION / 2:
        theta, rate, acceleration, jerk = phase(DURATION - t)
        return 2 * pi - theta, rate, -acceleration, jerk
    if t > RAMP:
        return RATE * (t - RAMP / 2), RATE, 0.0, 0.0
    # the rate follows 10 s^3 - 15 s^4 + 6 s^5
    s = t / RAMP
    return (
        RATE * RAMP * (2.5 * s**4 - 3 * s**5 + s**6),
        RATE * (10 * s**3 - 15 * s**4 + 6 * s**5),
        RATE / RAMP * (30 * s**2 - 60 * s**3 + 30 * s**4),
        RATE / RAMP**2 * (60 * s - 180 * s**2 + 120 * s**3),
    )


def path(t):
    """Return x and y with their first three derivatives at time t (s), shape (2, 4)."""
    theta, w, a, j = phase(t)
    rows = []
    for size, k in ((1.0, 1), (0.5, 2)):
        f = [size * k**n * g for n, g in enumerate((sin(k * theta), cos(k * theta), -sin(k * theta), -cos(k * theta)))]
        # chain rule
        rows.append([f[0], f[1] * w, f[2] * w**2 + f[1] * a, f[3] * w**3 + 3 * f[2] * w * a + f[1] * j])
    return np.array(rows)


def septic(begin, end, duration):
    """Return the coefficients of degree 0 to 7 that join two lists of position, velocity, acceleration and jerk."""
    low = begin / [factorial(n) for n in range(4)]
    # d-th derivative of t^n at the end of the piece
    slope = np.array(
        [[factorial(n) / factorial(n - d) * duration ** (n - d) if n >= d else 0.0 for n in range(8)] for d in range(4)]
    )
    high = np.linalg.solve(slope[:, 4:], end - slope[:, :4] @ low)
    return np.concatenate([low, high])


def pieces():
    """Return the pieces in the layout of the trajectory memory, shape (n, 33)."""
    duration = round(DURATION / PIECES, 6)
    rows = []
    for begin in np.arange(PIECES) * duration:
        start, end = path(begin), path(min(begin + duration, DURATION))
        axes = [septic(start[axis], end[axis], duration) for axis in range(2)]
        rows.append([*np.round(np.concatenate([*axes, np.zeros(16)]), 6) + 0.0, duration])
    return np.array(rows, dtype=np.float32)


if __name__ == "__main__":
    write_pieces(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("figure8.csv"), pieces())
