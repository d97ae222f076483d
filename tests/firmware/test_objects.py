import shutil

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import CompileError
from crazychoir_fw.firmware.cache import Cache, Fingerprints
from crazychoir_fw.firmware.objects import Objects, Unit, demand_all, read_dependencies
from crazychoir_fw.firmware.toolchain import find_compiler


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "my sources $ ü #1"
    place.mkdir()
    (place / "a.c").write_text('#include "shared.h"\nint a(void) { return SHARED; }\n')
    (place / "b.c").write_text("int b(void) { return 2; }\n")
    (place / "shared.h").write_text("#define SHARED 1\n")
    return place


@pytest.fixture
def compile_all(cache_folder, folder):
    """Compile files of the folder; return the results, and which of them were recompiled."""

    def run(*names, flags=(), headers=(), syntax_only=False, root=None, placed=False):
        objects = Objects(find_compiler(), Cache(), Fingerprints(), headers, root)
        units = [Unit((root or folder) / name, tuple(flags), syntax_only, placed) for name in names]
        results = objects.compile_all(units)
        return results, [one.unit.source.name for one in results if not one.from_cache]

    return run


def test_only_what_changed_is_compiled(compile_all, folder):
    assert compile_all("a.c", "b.c")[1] == ["a.c", "b.c"]
    assert compile_all("a.c", "b.c")[1] == []
    (folder / "shared.h").write_text("#define SHARED 3\n")
    assert compile_all("a.c", "b.c")[1] == ["a.c"]
    (folder / "b.c").write_text("int b(void) { return 4; }\n")
    assert compile_all("a.c", "b.c")[1] == ["b.c"]
    # and back again
    (folder / "shared.h").write_text("#define SHARED 1\n")
    assert compile_all("a.c", "b.c")[1] == []


def test_flags_and_names_of_headers_count(compile_all):
    assert compile_all("b.c")[1] == ["b.c"]
    assert compile_all("b.c", flags=["-DX"])[1] == ["b.c"]
    assert compile_all("b.c", headers=["another header"])[1] == ["b.c"]
    assert compile_all("b.c")[1] == []


def test_a_copy_of_a_checkout_is_not_compiled_again(compile_all, folder):
    (folder / "a.c").write_text('#include "shared.h"\nint unused; const char *a(void) { int b; return __FILE__; }\n')
    copy = folder.with_name("copy")
    shutil.copytree(folder, copy)
    for root, compiled in ((folder, ["a.c"]), (copy, []), (folder, [])):
        (result,), names = compile_all("a.c", root=root, flags=["-Wall", f"-I{root}"], headers=[f"{root}/shared.h"])
        assert names == compiled
        assert f"{root}/a.c:2:" in result.output and result.inputs.keys() >= {f"{root}/a.c", f"{root}/shared.h"}
    content = result.path.read_bytes()
    assert b"a.c\0" in content and bytes(folder) not in content  # from the root on, for both
    assert compile_all("a.c", root=copy, placed=True)[1] == ["a.c"]
    assert compile_all("a.c", root=folder, placed=True)[1] == ["a.c"]
    (copy / "shared.h").write_text("#define SHARED 3\n")
    assert compile_all("a.c", root=copy, flags=["-Wall", f"-I{copy}"], headers=[f"{copy}/shared.h"])[1] == ["a.c"]


def test_objects_are_found_again_after_they_vanished(compile_all):
    (result,), _ = compile_all("b.c")
    result.path.unlink()
    (again,), compiled = compile_all("b.c")
    assert compiled == ["b.c"]
    assert again.path.is_file()


def test_inputs_name_every_file_that_was_read(compile_all, folder):
    (result,), _ = compile_all("a.c")
    assert {str(folder / "a.c"), str(folder / "shared.h")} <= result.inputs.keys()
    assert None not in result.inputs.values()
    (again,), _ = compile_all("a.c")
    assert again.inputs == result.inputs


def test_failures_are_shown_as_the_compiler_printed_them(compile_all, folder):
    (folder / "a.c").write_text('#include "shared.h"\n\nint a(void) { return nothing; }\n')
    (folder / "b.c").write_text("int b(void) { return 2 }\n")
    results, _ = compile_all("a.c", "b.c")
    assert [one.ok for one in results] == [False, False]
    with pytest.raises(CompileError) as raised:
        demand_all(results)
    text = str(raised.value)
    assert text.startswith("2 files do not compile:\n")
    assert f"{folder}/a.c:3:22: error: " in text
    assert f"{folder}/b.c:1:" in text
    assert results[0].output.rstrip() in text


def test_warnings_come_again_from_the_cache(compile_all, folder):
    (folder / "b.c").write_text("int b(void) { int unused; return 2; }\n")
    (first,), _ = compile_all("b.c", flags=["-Wall"])
    (second,), compiled = compile_all("b.c", flags=["-Wall"])
    assert compiled == []
    assert first.output == second.output
    assert "unused" in first.output


def test_answers_of_syntax_checks_are_kept_until_a_header_changes(compile_all, folder):
    (folder / "a.c").write_text('#include "shared.h"\nint a(void) { return OTHER; }\n')
    assert compile_all("a.c", syntax_only=True)[1] == ["a.c"]
    (result,), compiled = compile_all("a.c", syntax_only=True)
    assert (result.ok, compiled) == (False, [])
    (folder / "shared.h").write_text("#define OTHER 1\n")
    (result,), compiled = compile_all("a.c", syntax_only=True)
    assert (result.ok, compiled) == (True, ["a.c"])


def test_a_missing_header_is_looked_for_again(compile_all, folder):
    (folder / "shared.h").write_text('#include "missing.h"\n')
    (result,), _ = compile_all("a.c", syntax_only=True)
    assert not result.ok
    assert str(folder / "shared.h") in result.inputs
    (folder / "shared.h").write_text("#define SHARED 1\n")
    (result,), _ = compile_all("a.c", syntax_only=True)
    assert result.ok


def test_nothing_is_left_beside_the_objects(compile_all, cache_folder, folder):
    (folder / "a.c").write_text("broken")
    compile_all("a.c", "b.c")
    compile_all("a.c", syntax_only=True)
    names = [path.name for path in Cache().objects.iterdir()]
    assert len(names) == 1
    assert not names[0].startswith(".")


def test_dependencies_of_several_lines():
    text = "x: /a/b.c /my\\ sources/c.h \\\n  /d$$/e\\#.h\n"
    assert read_dependencies(text) == ["/a/b.c", "/my sources/c.h", "/d$/e#.h"]
    assert read_dependencies("") == []


@given(st.lists(st.from_regex(r"/[a-z$# ]{0,4}[a-z]", fullmatch=True), max_size=5))
def test_dependencies_with_any_signs(paths):
    escaped = [path.replace("$", "$$").replace("#", "\\#").replace(" ", "\\ ") for path in paths]
    assert read_dependencies("x: " + " \\\n ".join(escaped) + "\n") == paths
