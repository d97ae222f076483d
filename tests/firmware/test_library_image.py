"""Which memory of a library belongs to a drone, and which words of it are pointers: compared with the symbol table."""

import itertools
import re
import shutil
import subprocess
import sysconfig

import pytest

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import BuildError, CrazychoirError
from crazychoir_fw.firmware.image import MAX_BYTES, image_map

COMPILER = (sysconfig.get_config_var("CC") or "cc").split()[0]

VARIABLES = r"""
#include <stdint.h>
#define SEEN __attribute__((used))
#define IN(name) __attribute__((section(name), used))

typedef struct node { struct node *next; int value; } node_t;
typedef const volatile node_t *alias_t;

SEEN static int number = 3;
SEEN static int zero;
SEEN static int *to_number = &number;
SEEN static char *null;
SEEN static alias_t of_typedef;
SEEN static node_t chain[3] = {{&chain[1], 1}};
SEEN static int *matrix[2][3];
SEEN static struct { char tag; struct { double a; void *inner[2]; } part; } nested;
SEEN static struct __attribute__((packed)) { char tag; int *unaligned; } packed;
SEEN static union { float number; void *pointer; uint64_t word; } either;
SEEN static void (*function)(void);
SEEN static struct { unsigned low : 3; unsigned high : 5; char *after; } bits;
SEEN static uintptr_t hidden = (uintptr_t)&number;
IN(".ccmbss") static int in_ccm;
IN(".ccmbss") static char *pointer_in_ccm;
IN(".cf_keep") static char *kept = "kept";
IN("cf_logs") static const char *const row = "row";
SEEN static const char *const sealed[2] = {"sealed", "too"};
SEEN static const int constant = 4;

int *local_static(void);
int *local_static(void) {
  SEEN static int count;
  SEEN static int *where;
  {
    SEEN static void *deeper[2];
    deeper[0] = &count;
    where = deeper[0];
  }
  count++;
  return where;
}
static inline int inlined(int by) {
  SEEN static int *total_of;
  SEEN static int total;
  total_of = &total;
  *total_of += by;
  return total;
}
int use(int);
int use(int n) { return inlined(n) + inlined(2 * n); }
"""


def build(folder, text, *flags, linked=("-shared",), compiler=COMPILER):
    source, target = folder / "code.c", folder / "library.so"
    source.write_text(text)
    command = [compiler, "-O2", "-fPIC", "-fno-common", *flags, *linked, str(source), "-o", str(target)]
    subprocess.run(command, check=True, capture_output=True, text=True)
    return target


@pytest.fixture(
    scope="module",
    params=[
        (COMPILER, "-g", "-gdwarf-4"),
        (COMPILER, "-g", "-gdwarf-5"),
        (COMPILER, "-g", "-O3", "-gz"),
        (COMPILER, "-g", "-O0"),
        ("clang", "-g", "-gdwarf-5"),
    ],
    ids=" ".join,
)
def library(request, tmp_path_factory):
    compiler, *flags = request.param
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler} here")
    return build(tmp_path_factory.mktemp("image"), VARIABLES, *flags, compiler=compiler)


def symbols(path):
    """Address of each variable by its name, without what compilers add: a number behind, a function before."""
    lines = subprocess.run(["nm", str(path)], capture_output=True, text=True, check=True).stdout.splitlines()
    rows = [line.split() for line in lines if line[0] != " "]
    return {re.sub(r"(\.\d+)+$", "", name).split(".")[-1]: int(address, 16) for address, _, name in rows}


def covers(ranges, address):
    return any(start <= address < start + size for start, size in ranges)


def test_ranges_hold_the_variables_of_the_code_and_nothing_else(library):
    ranges, _ = image_map(library)
    at = symbols(library)
    mutable = ["number", "zero", "to_number", "null", "chain", "matrix", "nested", "either", "function", "in_ccm"]
    mutable += ["pointer_in_ccm", "count", "where", "deeper", "total", "total_of"]
    assert [name for name in mutable if not covers(ranges, at[name])] == []
    not_of_a_drone = ["kept", "row", "sealed", "constant", "_DYNAMIC", "_GLOBAL_OFFSET_TABLE_", "use"]
    assert [name for name in not_of_a_drone if covers(ranges, at[name])] == []


def test_ranges_are_in_order_and_apart(library):
    ranges, _ = image_map(library)
    assert ranges == sorted(ranges)
    assert all(size > 0 for _, size in ranges)
    assert all(start + size < after for (start, size), (after, _) in itertools.pairwise(ranges))


def test_pointers_are_all_words_that_can_hold_one(library):
    ranges, pointers = image_map(library)
    at = symbols(library)
    expected = {
        at[name] for name in ("to_number", "null", "of_typedef", "either", "function", "where", "pointer_in_ccm")
    }
    expected |= {at["chain"] + 16 * i for i in range(3)}
    expected |= {at["matrix"] + 8 * i for i in range(6)}
    expected |= {at["nested"] + 16, at["nested"] + 24, at["packed"] + 1, at["bits"] + 8}
    expected |= {at["deeper"], at["deeper"] + 8, at["total_of"]}
    # known by its relocation alone, since its type is an integer
    expected |= {at["hidden"]}
    # the run-time's handle of the library is its own address
    assert set(pointers) - {at["__dso_handle"]} == expected
    assert pointers == sorted(pointers)
    assert all(covers(ranges, pointer) and covers(ranges, pointer + 7) for pointer in pointers)


def test_packed_relocations_are_pointers_too(tmp_path):
    try:
        path = build(tmp_path, VARIABLES, "-g", "-Wl,-z,pack-relative-relocs")
    except subprocess.CalledProcessError:
        pytest.skip("this linker packs no relocations")
    assert symbols(path)["hidden"] in image_map(path)[1]


def test_a_library_without_debug_information_is_refused(tmp_path):
    path = build(tmp_path, VARIABLES)
    with pytest.raises(CrazychoirError, match=r"library\.so has no debug information.*compile with -g"):
        image_map(path)


def test_more_than_a_drone_can_carry_is_refused_and_the_largest_named(tmp_path):
    # so large that looking for pointers in it would not end
    text = (
        "volatile char map[300000]; static volatile int small[9];"
        "int use(int i); int use(int i) { static volatile float much[1 << 26]; much[i] = 1; return small[i] + map[i]; }"
    )
    with pytest.raises(BuildError) as raised:
        image_map(build(tmp_path, text, "-g"))
    told = str(raised.value)
    assert told.startswith("the file-scope variables of library take 2687")
    assert told.endswith(
        f"bytes per drone, allowed: {MAX_BYTES}; the largest: much in code.c 268435456, map 300000, small in code.c 36"
    )


def test_the_limit_is_that_of_the_loader():
    assert MAX_BYTES == lib.CF_LIBRARY_MAX_STATE_BYTES


def test_variables_of_threads_are_refused(tmp_path):
    path = build(tmp_path, "__thread int of_thread = 1;\nint *f(void) { return &of_thread; }\n", "-g")
    with pytest.raises(CrazychoirError, match=r"each thread has for itself \(section \.tdata\)"):
        image_map(path)


@pytest.mark.parametrize("content", [b"", b"#include <stdio.h>\n", b"\x7fELF" + bytes(60)])
def test_other_files_are_refused(tmp_path, content):
    path = tmp_path / "other.so"
    path.write_bytes(content)
    with pytest.raises(CrazychoirError, match=r"other\.so is no shared library"):
        image_map(path)


def test_an_object_file_is_refused(tmp_path):
    path = build(tmp_path, VARIABLES, "-g", linked=("-c",))
    with pytest.raises(CrazychoirError, match="is no shared library for"):
        image_map(path)


def test_a_library_without_variables_has_next_to_nothing(tmp_path):
    ranges, _ = image_map(build(tmp_path, "int f(int x);\nint f(int x) { return 2 * x; }\n", "-g"))
    # what the run-time of C keeps in every library
    assert sum(size for _, size in ranges) <= 64
