"""Numbers that break things, in every member of a C struct.

The sanitizers of CMakeLists.txt see what such numbers do to memory; the tests say what holds all the same.
"""

import numpy as np

from crazychoir_fw._core import ffi

EXTREMES = np.array(
    [0, -0.0, 1, -1, 0.1, -2.5, 0.7071068, 9.81, 180, -180, 540, 32767, -32769, 65535, 65536, 16777216, 2147483520,
     2147483648, -2147483648, -2147483904, 4.3e9, 1e-45, -1e-38, 1e-20, 1.1754944e-38, 1e10, -1e10, 1e20, -1e20,
     3.4e38, -3.4e38, np.inf, -np.inf, np.nan],
    np.float32,
)  # fmt: skip
FEW = [float(x) for x in EXTREMES[[0, 1, 2, 3, 20, 21, 24, 28, 29, 30, 31, 32, 33]]]
"""Fewer of them, for pairs."""


def leaves(ctype, offset=0):
    """Yield offset and type of every number within a C type; pointers and unions are left alone."""
    if ctype.kind == "struct":
        for _, field in ctype.fields:
            yield from leaves(field.type, offset + field.offset)
    elif ctype.kind == "array":
        for i in range(ctype.length):
            yield from leaves(ctype.item, offset + i * ffi.sizeof(ctype.item))
    elif ctype.kind in ("primitive", "enum"):
        yield offset, ctype


def numbers(rng, ctype, count, calm):
    """Return numbers for a type: extreme ones, but a share of `calm` is between -1 and 1."""
    if ctype.kind == "enum":
        return rng.choice(sorted(ctype.elements), count).astype(np.uint32)
    if ctype.cname == "_Bool":
        return rng.integers(0, 2, count, np.uint8)
    if ctype.cname in ("float", "double"):
        extreme = rng.choice(EXTREMES, count)
        return np.where(rng.random(count) < calm, rng.uniform(-1, 1, count), extreme).astype(f"f{ffi.sizeof(ctype)}")
    kind = np.dtype(f"{'i' if int(ffi.cast(ctype, -1)) < 0 else 'u'}{ffi.sizeof(ctype)}")
    info = np.iinfo(kind)
    return rng.choice(np.array([info.min, 0, 1, 100, info.max - 1, info.max], kind), count)


def many(name, count, seed, calm=0.0):
    """Return an array of `count` structs, or of plain numbers, full of extreme values."""
    rng = np.random.default_rng(seed)
    array = ffi.new(f"{name}[]", count)
    item = ffi.typeof(array).item
    view = np.frombuffer(ffi.buffer(array), np.uint8).reshape(count, ffi.sizeof(item))
    for offset, ctype in leaves(item):
        view[:, offset : offset + ffi.sizeof(ctype)] = (
            numbers(rng, ctype, count, calm).view(np.uint8).reshape(count, ffi.sizeof(ctype))
        )
    return array
