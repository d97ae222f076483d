"""Writes random_table.c, the inverse normal distribution that random_inline.h interpolates.

The two-sided tail probability p = f / 2^31 runs over 31 octaves of 16 pieces. On each piece the
magnitude |x| is a line in f through the exact quantiles at both ends; the whole is then divided by
its standard deviation (1.000054), which is above 1 because the chords run above the curve.
Run it from anywhere: `python bindings/vehicle/random_table.py`.
"""

import struct
from itertools import pairwise
from pathlib import Path
from statistics import NormalDist

OCTAVES = 31
PIECES = 16
FULL = 2.0**OCTAVES


def magnitude(f: float) -> float:
    """Return |x| whose two-sided tail probability is f / 2^31."""
    return -NormalDist().inv_cdf(f / FULL / 2) if f < FULL else 0.0


def pieces() -> list[tuple[float, float, float, float]]:
    """Return f and |x| at both ends of every piece, of unit variance as a whole."""
    knots = [2.0**octave * (1 + piece / PIECES) for octave in range(OCTAVES) for piece in range(PIECES)] + [FULL]
    rows = [(lo, hi, magnitude(lo), magnitude(hi)) for lo, hi in pairwise(knots)]
    variance = sum((hi - lo) / FULL * (a * a + a * b + b * b) / 3 for lo, hi, a, b in rows)
    return [(lo, hi, a / variance**0.5, b / variance**0.5) for lo, hi, a, b in rows]


def float32(value: float) -> str:
    """Return *value* as an exact C literal of type float."""
    short = struct.unpack("f", struct.pack("f", value))[0].hex()
    mantissa, exponent = short.split("p")
    return f"{mantissa.rstrip('0').rstrip('.')}p{exponent}f"


def table() -> str:
    """Return the text of random_table.c."""
    lines = []
    for lo, hi, at_lo, at_hi in pieces():
        slope = (at_hi - at_lo) / (hi - lo)
        lines.append(f"    {{{float32(at_lo - slope * lo)}, {float32(slope)}}},")
    lines.append(lines[-1])  # for the numbers that round up to 2^31
    return "\n".join(
        [
            "/* Lines of the inverse normal distribution, made by random_table.py. */",
            '#include "vehicle/random_inline.h"',
            "",
            "// clang-format off",
            "const cf_normal_line_t CF_NORMAL_LINES[CF_NORMAL_LINE_COUNT] = {",
            *lines,
            "};",
            "",
        ]
    )


if __name__ == "__main__":
    Path(__file__).with_name("random_table.c").write_text(table())
