"""Builder of crazychoir_fw._core: sources from bindings/sources.txt, declarations from core.h.

CMakeLists.txt reads the same list, so that the two builds cannot drift apart.
"""

import importlib.util
import os
import re
import sys
from pathlib import Path

from cffi import FFI

BINDINGS = Path(__file__).resolve().parents[1]
ROOT = BINDINGS.parent
SOURCES = (BINDINGS / "sources.txt").read_text().split()

# the flags that decide the bits; -fno-builtin-*: with constant arguments gcc would fold these calls with another
# rounding than libm's (docs/reference/control-pid.md#7), and the two providers would differ by an ulp
CFLAGS = ["-std=c11", *(BINDINGS / "cflags.txt").read_text().split()]

# small functions in files of their own cost nothing when linked with LTO; to count executed lines they must stay
# apart, and those within a file must not be inlined before lines are counted
LINKING = ["--coverage", "-fno-early-inlining"] if os.environ.get("CRAZYCHOIR_COVERAGE") else ["-flto=auto"]

# debug information would be three quarters of the extension; CMakeLists.txt builds the core that is looked into
STRIP = "-Wl,-S"

_LOCAL_INCLUDE = re.compile(r'#include "(.+)"')
_INTEGER_CONSTANT = re.compile(r"#define \w+ +-?\d+\s*(//.*)?$")


def declarations(header: str, seen: set[str]) -> str:
    """Return what *header* and the headers it includes declare, in the form cffi reads."""
    if header in seen:
        return ""
    seen.add(header)
    lines = []
    for line in (BINDINGS / header).read_text().splitlines():
        if local := _LOCAL_INCLUDE.match(line):
            lines.append(declarations(local[1], seen))
        elif not line.startswith("#") or _INTEGER_CONSTANT.match(line):
            lines.append(line)
    return "\n".join(lines)


def mujoco_include() -> str:
    """Return the folder of MuJoCo's C headers, which the mujoco-core wheel carries."""
    spec = importlib.util.find_spec("mujoco")
    if spec is None or not spec.submodule_search_locations:
        raise SystemExit("MuJoCo's headers are missing: run `pip install 'mujoco-core>=4.0,<4.1'`")
    return str(Path(spec.submodule_search_locations[0]) / "include")


ffi = FFI()
ffi.cdef(declarations("cffi/core.h", seen=set()))
ffi.set_source(
    "crazychoir_fw._core",
    '#include "cffi/core.h"',
    sources=SOURCES,
    include_dirs=[str(BINDINGS), mujoco_include()],
    define_macros=[("CF_BUILD_FLAGS", f'"{" ".join(CFLAGS)}"')],
    extra_compile_args=[*CFLAGS, *LINKING],
    extra_link_args=[*LINKING, *CFLAGS, "-pthread", STRIP],
    depends=[str(path) for path in sorted(BINDINGS.rglob("*.h"))],
)

if __name__ == "__main__":
    # for CMake: the source of the extension, and where MuJoCo's headers are
    ffi.emit_c_code(sys.argv[1])
    print(mujoco_include())
