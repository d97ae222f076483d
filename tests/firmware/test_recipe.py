import subprocess

import pytest

from crazychoir_fw.common.errors import CheckoutError, UnknownNameError
from crazychoir_fw.firmware.checkout import Checkout
from crazychoir_fw.firmware.own_sources import bindings_folder, deciding_flags, read_list
from crazychoir_fw.firmware.recipe import bitcraze_recipe, builtin_recipe, header_names
from crazychoir_fw.firmware.toolchain import find_compiler

SETUP = """
include = ["src/modules/interface", "build/include/generated", "vendor/CMSIS/CMSIS/DSP/Include"]
sources = ["src/modules/src/planner.c", "vendor/CMSIS/CMSIS/DSP/Source/a.c"]
Extension("_cffirmware", include_dirs=include, sources=sources + ["build/cffirmware_wrap.c"],
          extra_compile_args={flags})
"""


@pytest.fixture
def checkout(tmp_path):
    """Lay out the names that a recipe looks at; compiler flags as given."""

    def make(flags=("-O3", "-DUNIT_TEST_MODE"), root=tmp_path / "it's firmware"):
        files = {
            "bindings/setup.py": SETUP.format(flags=list(flags)),
            "src/modules/src/planner.c": "",
            "src/modules/interface/log.h": "",
            "src/modules/interface/param.h": "",
            "vendor/CMSIS/CMSIS/DSP/Source/a.c": "",
            "build/include/generated/autoconf.h": "#error theirs\n",
        }
        for name, text in files.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text)
        return Checkout(root)

    return make


def test_lists_become_paths_in_the_checkout(checkout):
    opened = checkout()
    recipe = bitcraze_recipe(opened, "cf21bl")
    assert (recipe.name, recipe.platform) == ("bitcraze", "cf21bl")
    assert recipe.sources[0] == opened.root / "src/modules/src/planner.c"
    assert opened.root / "build/include/generated" not in recipe.include_dirs
    assert opened.root / "src/modules/interface" in recipe.include_dirs
    assert recipe.first_include_dirs[0] == bindings_folder() / "library" / "include"
    assert "#define CONFIG_PLATFORM_CF21BL 1\n" in recipe.generated["autoconf.h"]


TABLES = """
static uint8_t x;
LOG_GROUP_START(mine)
LOG_ADD(LOG_UINT8, x, &x)
LOG_GROUP_STOP(mine)
_Static_assert(sizeof cf_logs_mine == 64, "a group and a variable");
"""

LOG = """
#include <stdint.h>
#define LOG_ADD(A, B, C)
#define LOG_GROUP_START(A)
#define LOG_GROUP_STOP(A)
#define LOG_UINT8 1
typedef struct { int x; } logByFunction_t;
typedef uint16_t logVarId_t;
static inline int logVarIdIsValid(logVarId_t id) { return id != 1; }
"""


@pytest.mark.parametrize("guard", ["#pragma once\n", "#ifndef ODD\n#define ODD\n"])
@pytest.mark.parametrize("included", ['"log.h"', "<log.h>"])
def test_their_headers_come_first_and_only_tables_are_ours(checkout, tmp_path, guard, included):
    opened = checkout()
    interface = opened.root / "src/modules/interface"
    (interface / "log.h").write_text(guard + LOG + ("#endif\n" if "ifndef" in guard else ""))
    # one header includes itself by way of another one, by angle brackets
    (interface / "param.h").write_text('#pragma once\n#include "param_logic.h"\n#define PARAM_UINT8 8\n')
    (interface / "param_logic.h").write_text(
        "#pragma once\n#include <param.h>\ntypedef struct { int mine; } paramVarId_t;\n"
    )
    (interface / "planner.h").write_text(f"#include {included}\n#include <param.h>\n")
    source = opened.root / "src/modules/src/planner.c"
    source.write_text(
        f'#include "planner.h"\nlogByFunction_t y; int *z = &y.x; paramVarId_t i = {{.mine = 1}};\n{TABLES}'
    )
    recipe = bitcraze_recipe(opened, "cf2")
    for name, text in recipe.generated.items():
        (tmp_path / name).write_text(text)
    for flags in (recipe.host_flags(tmp_path), recipe.vehicle_flags(tmp_path)):
        command = [*find_compiler().command, *flags, "-Wall", "-Werror", "-fsyntax-only", str(source)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr


def test_the_two_modes_differ_in_two_macros(checkout, tmp_path):
    recipe = bitcraze_recipe(checkout(), "cf2")
    host, vehicle = set(recipe.host_flags(tmp_path)), set(recipe.vehicle_flags(tmp_path))
    assert (host - vehicle, vehicle - host) == ({"-DUNIT_TEST_MODE"}, {"-DCRAZYFLIE_FW"})
    assert {path.name for path in recipe.vehicle_mode} == {"planner.c"}, "not what the vendor wrote"


def test_flags_of_the_checkout_first_those_that_decide_the_bits_last(checkout):
    flags = bitcraze_recipe(checkout(["-O2", "-fno-strict-aliasing", "-ffp-contract=fast", "-DX=a b"]), "cf2").flags
    assert [flag for flag in flags if flag.startswith("-O")] == ["-O3", "-O2"]
    assert [flag for flag in flags if flag.startswith("-ffp-contract")][-1] == "-ffp-contract=off"
    assert "-DX=a b" in flags
    assert set(deciding_flags()) <= set(flags)
    assert {"-g", "-fPIC", "-fno-common", "-fvisibility=hidden"} <= set(flags)


@pytest.mark.parametrize(
    "flag",
    [
        "-fplugin=evil.so",
        "-fpass-plugin=evil.so",
        "-fplugin-arg-evil-x",
        "-wrapper",
        "@evil",
        "-specs=evil",
        "-B/evil",
        "-Wl,-plugin,evil.so",
        "-Wp,-MD,/evil",
        "-Wa,-o",
        "-save-temps",
        "-fdump-tree-all",
        "-fprofile-arcs",
        "-fuse-ld=/evil",
        "-flto",
        "-o",
        "/evil",
        "-mllvm",
        "-include",
        "-x",
        "--coverage",
        "-fsanitize=address",
    ],
)
def test_flags_that_write_or_run_something_are_left_out(checkout, flag):
    recipe = bitcraze_recipe(checkout(["-O3", flag]), "cf2")
    assert flag not in recipe.flags
    assert recipe.notes == (f"flag {flag} left out",)


@pytest.mark.parametrize("flag", ["-fwrapv", "-std=gnu99", "-m64", "-Wno-error=x", "-DA=1", "-UA", "-fno-math-errno"])
def test_flags_that_say_how_c_is_compiled_are_kept(checkout, flag):
    recipe = bitcraze_recipe(checkout(["-O3", flag]), "cf2")
    assert flag in recipe.flags
    assert recipe.notes == ()


def test_a_missing_source_is_told_with_a_command(checkout):
    opened = checkout()
    (opened.root / "vendor/CMSIS/CMSIS/DSP/Source/a.c").unlink()
    with pytest.raises(CheckoutError, match=r"a\.c is missing in .* submodule update --init --force vendor/CMSIS`$"):
        bitcraze_recipe(opened, "cf2")
    (opened.root / "src/modules/src/planner.c").unlink()
    with pytest.raises(CheckoutError, match=r"names src/modules/src/planner\.c and 1 more, which is missing"):
        bitcraze_recipe(opened, "cf2")


def test_with_the_known_lists_only_what_is_there_counts(checkout):
    opened = checkout()
    (opened.root / "bindings" / "setup.py").write_text("sources = find_them()")
    recipe = bitcraze_recipe(opened, "cf2")
    assert recipe.sources == (opened.root / "src/modules/src/planner.c",)
    assert len(recipe.notes) == 2


def test_apps_switch_their_part_of_the_firmware_on(checkout, tmp_path):
    law, filter_, mention = tmp_path / "my law.c", tmp_path / "filter.c", tmp_path / "mention.c"
    law.write_text("void controllerOutOfTree (int x) {}")
    filter_.write_text("void estimatorOutOfTree(int x) {}")
    mention.write_text(
        "// like controllerOutOfTree(...)\n/* estimatorOutOfTree() */\nvoid controllerOutOfTreeInit(void);"
    )
    opened = checkout()
    assert bitcraze_recipe(opened, "cf2", [law]).settings["CONFIG_CONTROLLER_OOT"] == "1"
    assert bitcraze_recipe(opened, "cf2", [law]).name == "bitcraze+my_law"
    assert bitcraze_recipe(opened, "cf2", [filter_]).settings["CONFIG_ESTIMATOR_OOT"] == "1"
    assert (
        not {"CONFIG_CONTROLLER_OOT", "CONFIG_ESTIMATOR_OOT"}
        & bitcraze_recipe(opened, "cf2", [mention]).settings.keys()
    )
    both = builtin_recipe("cf21bl", [law, filter_])
    assert both.settings == {
        "CONFIG_CONTROLLER_OOT": "1",
        "CONFIG_ESTIMATOR_OOT": "1",
        "CONFIG_PLATFORM_CF21BL": "1",
    }
    assert (both.name, both.platform) == ("builtin+my_law+filter", "cf21bl")
    with pytest.raises(UnknownNameError, match="no platform named 'bolt', allowed: cf2, cf21bl"):
        builtin_recipe("bolt", [law])
    with pytest.raises(UnknownNameError, match="there is no app file"):
        builtin_recipe("cf2", [tmp_path / "none.c"])


def test_a_configuration_header_of_the_user(checkout, tmp_path):
    path = tmp_path / "autoconf.h"
    path.write_text("#define CONFIG_PLATFORM_CF2 1\n#define CONFIG_MINE 7\n")
    recipe = bitcraze_recipe(checkout(), "cf2", configured=path)
    assert recipe.settings == {"CONFIG_MINE": "7", "CONFIG_PLATFORM_CF2": "1"}
    assert "#define CONFIG_MINE 7\n" in recipe.generated["autoconf.h"]


def test_names_of_headers_below_folders(tmp_path):
    (tmp_path / "deep").mkdir()
    for name in ("a.h", "b.c", "deep/c.h"):
        (tmp_path / name).write_text("")
    assert header_names([tmp_path, tmp_path / "deep", tmp_path / "none"]) == [f"{tmp_path}/a.h", f"{tmp_path}/deep/c.h"]


def test_lists_of_files_may_have_comments(tmp_path):
    path = tmp_path / "list.txt"
    assert read_list(path) == []
    path.write_text("# why\n\na/b.c  # because\nc.c\n")
    assert read_list(path) == ["a/b.c", "c.c"]


def test_what_is_compiled_at_run_time_is_of_kinds_that_are_installed():
    folder = bindings_folder()
    kinds = {
        path.suffix
        for name in ("app", "bitcraze", "library", "builtin", "api")
        for path in (folder / name).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    # pyproject.toml names these; Python files are tools that wrote a table
    assert kinds <= {".c", ".h", ".txt", ".py"}


def test_a_source_behind_a_symbol_is_compiled_where_the_symbol_is_set(checkout):
    opened = checkout()
    steps = opened.root / "src/modules/src/outlierfilter/outlierFilterTdoaSteps.c"
    steps.parent.mkdir(parents=True)
    steps.write_text("")
    assert steps not in bitcraze_recipe(opened, "cf2").extras
    (opened.root / "configs").mkdir()
    symbol = "CONFIG_ESTIMATOR_KALMAN_TDOA_OUTLIERFILTER_FALLBACK"
    (opened.root / "configs" / "cf2_defconfig").write_text(f"{symbol}=y\n")
    assert steps in bitcraze_recipe(opened, "cf2").extras


def test_folders_that_the_list_lacks_are_searched_for_headers(checkout):
    opened = checkout()
    estimator = opened.root / "src/modules/interface/estimator"
    estimator.mkdir()
    recipe = bitcraze_recipe(opened, "cf2")
    assert estimator in recipe.include_dirs
    shadow = bindings_folder() / "bitcraze" / "shadow"
    assert shadow in recipe.first_include_dirs
    assert {"stm32fxxx.h", "stm32f4xx.h"} <= {path.name for path in shadow.iterdir()}


@pytest.mark.parametrize("is_link", [True, False])
def test_files_outside_of_a_checkout_are_taken_only_from_folders_that_the_user_names(
    checkout, tmp_path, monkeypatch, is_link
):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "planner.c").write_text("")
    opened = checkout(flags=("-O3", f"-I{elsewhere}", "-I../elsewhere"))
    setup, source = opened.root / "bindings/setup.py", opened.root / "src/modules/src/planner.c"
    if is_link:
        source.unlink()
        source.symlink_to(elsewhere / "planner.c")
        headers = opened.root / "vendor/CMSIS/CMSIS/DSP/Include"
        headers.symlink_to(elsewhere)
    else:
        headers = opened.root / "../elsewhere"
        text = setup.read_text().replace("src/modules/src/planner.c", "../elsewhere/planner.c")
        setup.write_text(text.replace("vendor/CMSIS/CMSIS/DSP/Include", "../elsewhere"))
    with pytest.raises(CheckoutError, match=r"planner\.c of .* lies outside of this checkout, at .*elsewhere/planner"):
        bitcraze_recipe(opened, "cf2")

    monkeypatch.setenv("CRAZYFLIE_FIRMWARE_ALSO", str(elsewhere))
    assert headers in bitcraze_recipe(opened, "cf2").include_dirs

    monkeypatch.delenv("CRAZYFLIE_FIRMWARE_ALSO")
    if is_link:
        source.unlink()
        source.write_text("")
    else:
        setup.write_text(setup.read_text().replace("../elsewhere/planner.c", "src/modules/src/planner.c"))
    recipe = bitcraze_recipe(opened, "cf2")
    assert headers not in recipe.include_dirs
    assert not any("elsewhere" in flag for flag in recipe.flags)
    assert any("elsewhere left out, outside of the checkout" in note for note in recipe.notes)
