"""The core keeps everything in `cf_t`: its objects have no writable data and no allocator (design rule 2.1)."""

import re
import subprocess
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PARTS = ("bindings/api/", "bindings/builtin/", "bindings/onboard/", "bindings/vehicle/")
SOURCES = [
    source
    for source in (ROOT / "bindings/sources.txt").read_text().split()
    if source.startswith(PARTS) or source.count("/") == 1
]
COMPILER = (sysconfig.get_config_var("CC") or "cc").split()[0]

# tables of constants that hold addresses are writable for the loader alone: .data.rel.ro
WRITABLE = re.compile(r"\s\.(?:data(?!\.rel\.ro)|bss|tdata|tbss)\S*\s+[0-9a-f]+\s+(?!\.)(\S+)$")
FORBIDDEN_CALLS = re.compile(r"\*UND\*\s+[0-9a-f]+\s+(malloc|calloc|realloc|free|clock_gettime|time|rand|srand)$")


@pytest.fixture(scope="module")
def symbols(tmp_path_factory):
    """Symbol table of each source file."""
    folder = tmp_path_factory.mktemp("objects")
    tables = {}
    for source in SOURCES:
        target = folder / (source.replace("/", "_") + ".o")
        subprocess.run(
            [COMPILER, "-std=c11", "-O1", "-fPIC", "-Ibindings", "-c", source, "-o", str(target)], cwd=ROOT, check=True
        )
        tables[source] = subprocess.run(
            ["objdump", "-t", str(target)], capture_output=True, text=True, check=True
        ).stdout.splitlines()
    return tables


def test_core_has_no_mutable_file_scope_state(symbols):
    found = [
        f"{source}: {match[1]}"
        for source, lines in symbols.items()
        for line in lines
        if (match := WRITABLE.search(line))
    ]
    assert found == []


def test_core_neither_allocates_nor_reads_a_clock(symbols):
    found = [
        f"{source}: {match[1]}"
        for source, lines in symbols.items()
        for line in lines
        if (match := FORBIDDEN_CALLS.search(line))
    ]
    assert found == []


def test_the_search_finds_what_it_looks_for(tmp_path):
    source = tmp_path / "bad.c"
    source.write_text("#include <stdlib.h>\nstatic int counter;\nvoid *grow(void) { return malloc(++counter); }\n")
    subprocess.run([COMPILER, "-c", "-fPIC", str(source), "-o", str(tmp_path / "bad.o")], check=True)
    lines = subprocess.run(
        ["objdump", "-t", str(tmp_path / "bad.o")], capture_output=True, text=True, check=True
    ).stdout.splitlines()
    assert any(WRITABLE.search(line) for line in lines)
    assert any(FORBIDDEN_CALLS.search(line) for line in lines)
