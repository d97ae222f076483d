"""Writes sine_table.c: `python bindings/builtin/math/sine_table.py > bindings/builtin/math/sine_table.c`.

Entry k is the float nearest to sin(2 pi k / 512) after rounding to 8 decimals (docs/reference/estimators.md#2).
"""

import math

SEGMENTS = 512
PER_LINE = 7


def main() -> None:
    """Print the table as C."""
    # "+ 0.0" turns a rounded -0.0 into 0.0
    entries = [f"{round(math.sin(2.0 * math.pi * k / SEGMENTS), 8) + 0.0:.8f}f" for k in range(SEGMENTS + 1)]
    print("// Written by sine_table.py.")
    print('#include "builtin/math/sine_table.h"\n')
    print("// clang-format off")
    print("const float CF_SINE_TABLE[CF_SINE_TABLE_SEGMENTS + 1] = {")
    for start in range(0, len(entries), PER_LINE):
        print("  " + ", ".join(entries[start : start + PER_LINE]) + ",")
    print("};\n// clang-format on")


if __name__ == "__main__":
    main()
