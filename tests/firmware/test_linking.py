import subprocess

import pytest

from crazychoir_fw.common.errors import LinkError
from crazychoir_fw.firmware.linking import Undefined, explain, link
from crazychoir_fw.firmware.toolchain import find_compiler


@pytest.fixture
def objects(tmp_path):
    """Compile texts; return object to source, as `link` takes them."""

    def make(**texts):
        made = {}
        for name, text in texts.items():
            source, target = tmp_path / f"{name}.c", tmp_path / f"{name} kept.o"
            source.write_text(text)
            subprocess.run([*find_compiler().command, "-fPIC", "-c", "-o", str(target), str(source)], check=True)
            made[target] = source
        return made

    return make


def test_a_library_with_mathematics(objects, tmp_path):
    library = tmp_path / "a.so"
    assert link(find_compiler(), objects(a="#include <math.h>\nfloat a(float x) { return tanf(x); }"), library) == []
    assert library.is_file()


def test_undefined_symbols_and_who_needs_them(objects, tmp_path):
    made = objects(
        a="int usecTimestamp(void); int other(void); int a(void) { return usecTimestamp() + other(); }",
        b="int usecTimestamp(void); int b(void) { return usecTimestamp(); }",
        c="int a(void); int c(void) { return a(); }",
    )
    undefined = link(find_compiler(), made, tmp_path / "a.so")
    a, b = tmp_path / "a.c", tmp_path / "b.c"
    assert undefined == [Undefined("other", (a,)), Undefined("usecTimestamp", (a, b))]
    assert (
        explain(undefined)
        == f"undefined symbol other, needed by {a}\nundefined symbol usecTimestamp, needed by {a}, {b}"
    )


def test_whoever_loads_it_may_define_the_rest(objects, tmp_path):
    made = objects(a="int usecTimestamp(void); int a(void) { return usecTimestamp(); }")
    library = tmp_path / "a.so"
    assert link(find_compiler(), made, library, is_completed_later=True) == []
    assert library.is_file()


def test_other_failures_are_told_with_names_of_sources(objects, tmp_path):
    made = objects(a="int twice(void) { return 1; }", b="int twice(void) { return 2; }")
    with pytest.raises(LinkError, match="multiple definition") as raised:
        link(find_compiler(), made, tmp_path / "a.so")
    assert str(tmp_path / "a.c") in str(raised.value)
    assert "kept.o" not in str(raised.value)
