import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.firmware import fallback_lists
from crazychoir_fw.firmware.setup_lists import parse_setup_lists, read_setup_lists

LITERALS = """
include = [
    "src/modules/interface",  # a comment
    "build/include/generated",
]
fw_sources = [
    "src/modules/src/pptraj.c",
    # "src/modules/src/power_distribution_flapper.c",
    "src/modules/src/planner.c",
]
"""
CALL = """
cffirmware = Extension(
    "_cffirmware",
    include_dirs=include,
    sources=fw_sources + ["build/cffirmware_wrap.c"],
    extra_compile_args=["-O3", "-DUNIT_TEST_MODE"],
)
"""
DISTUTILS = """
import os
from distutils.command.build import build as build_
from distutils.core import setup, Extension
"""
SETUPTOOLS = """
from setuptools import Extension, setup
from setuptools.command.build import build as build_
"""
REST = """
class build(build_):
    def initialize_options(self):
        super().initialize_options()
        self.build_base = "build"

setup(name="cffirmware", version="1.0", cmdclass={"build": build}, package_dir={"": "build"},
      py_modules=["cffirmware"], ext_modules=[cffirmware])
"""
SOURCES = ("src/modules/src/pptraj.c", "src/modules/src/planner.c")
INCLUDES = ("src/modules/interface", "build/include/generated")


@pytest.mark.parametrize("imports", [DISTUTILS, SETUPTOOLS], ids=["distutils", "setuptools"])
def test_lists_of_literals(imports):
    lists = parse_setup_lists(imports + LITERALS + CALL + REST)
    assert lists.sources == SOURCES
    assert lists.include_dirs == INCLUDES
    assert lists.flags == ("-O3", "-DUNIT_TEST_MODE")
    assert lists.notes == ()


def test_joined_paths_and_comprehensions():
    lists = parse_setup_lists(
        """
import os
import numpy as np
fw_dir = "."
module = "src/modules"
include = [os.path.join(fw_dir, module, "interface"), np.get_include(), os.path.join("build", "include/generated")]
modules = ["pptraj.c", "planner.c"]
fw_sources = [os.path.join(module, "src", name) for name in modules]
Extension("_cffirmware", include_dirs=include, sources=fw_sources + ["bin/cffirmware_wrap.c"],
          extra_compile_args=["-O3", "-D__fp16=uint16_t"], define_macros=[("A", None), ("B", "2")])
"""
    )
    assert lists.sources == SOURCES
    assert lists.include_dirs == ("./src/modules/interface", "build/include/generated")
    assert lists.flags == ("-O3", "-D__fp16=uint16_t", "-DA", "-DB=2")
    assert lists.notes == ("line 6 has something that is not a literal, left out",)


def test_lists_that_grow():
    lists = parse_setup_lists(
        'a: list = ["x.c"]\na += ["y.c"]\nb = a + unknown()\nb = b + ["z.c"]\nsetuptools.Extension("_c", b)\n'
    )
    assert lists.sources == ("x.c", "y.c", "z.c")
    assert len(lists.notes) == 1


def test_nothing_is_executed(tmp_path):
    traces = [tmp_path / str(i) for i in range(5)]
    evil = [f'open({str(trace)!r}, "w").close()' for trace in traces]
    text = f"""
{evil[0]}
fw_sources = ["x.c", {evil[1]}, __import__("os").system("touch {traces[2]}") or "y.c"]
more = [{evil[3]} for name in fw_sources]
flags = [f'''{{{evil[4]}}}''']
Extension("_c", sources=fw_sources + more, extra_compile_args=flags)
"""
    lists = parse_setup_lists(text)
    assert lists.sources == ("x.c",)
    assert lists.flags == ()
    assert not any(trace.exists() for trace in traces)


def test_link_arguments_and_other_languages_are_left_out():
    lists = parse_setup_lists(
        'Extension("_c", ["a.c", "b.cpp"], libraries=["m", "evil"], extra_link_args=["-Wl,-plugin,evil.so"])'
    )
    assert lists.sources == ("a.c",)
    assert lists.notes == (
        "source b.cpp is not C, left out",
        "extra_link_args -Wl,-plugin,evil.so left out",
        "libraries evil left out",
    )


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("fw_sources = [", "not Python"),
        ("x = 1\0", "not Python"),
        ("x = 1", "calls no Extension"),
        ("Extension('_c', sources=find())", "not a list"),
        ("(" * 5000 + ")" * 5000, ""),
        ("a = ['x.c']\n" + "a = a + a\n" * 60 + "Extension('_c', a)", "longer than"),
        (f"a = {['x'] * 5000!r}\nb = [[y for y in a] for x in a]\nExtension('_c', b)", "too much"),
    ],
)
def test_unreadable_files_give_the_known_lists_and_a_note(tmp_path, text, reason):
    path = tmp_path / "setup.py"
    path.write_text(text)
    lists = read_setup_lists(path)
    assert lists.sources == fallback_lists.SOURCES
    assert lists.include_dirs == fallback_lists.INCLUDE_DIRS
    assert len(lists.notes) == 1
    assert reason in lists.notes[0]


def test_a_missing_file_gives_the_known_lists(tmp_path):
    assert read_setup_lists(tmp_path / "setup.py").sources == fallback_lists.SOURCES


names = st.from_regex(r"[a-z]{1,8}(/[a-z]{1,8}){0,3}\.c", fullmatch=True)


@given(st.lists(names, min_size=1, max_size=8), st.lists(names, max_size=5))
def test_sums_keep_the_order(first, second):
    text = f"a = {first!r}\nb = {tuple(second)!r}\nc = [x for x in b]\nExtension('_c', sources=a + c)"
    assert parse_setup_lists(text).sources == (*first, *second)
