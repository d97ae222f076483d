"""The miniature checkout: whole in every release and form, and read like the real one."""

import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from miniature import RELEASES, SETUP_PY, lay_out
from miniature.layout import SYSTEM

from crazychoir_fw.common.errors import CheckoutError
from crazychoir_fw.firmware.checkout import SETUP, describe, open_checkout
from crazychoir_fw.firmware.configuration import settings
from crazychoir_fw.firmware.setup_lists import read_setup_lists

NEWEST = "2026.08"
ONCE = "#pragma once"
SHAPE = yaml.safe_load((Path(__file__).parent / "shape.yaml").read_text())

# what a function or member came with, as it is written, and where
CAME_WITH = {
    ("src/modules/interface/planner.h", "bool linear"): "2025.02",
    ("src/modules/interface/planner.h", "plan_spiral"): "2025.02",
    ("src/modules/interface/planner.h", "float start_yaw"): "2026.08",
    ("src/modules/interface/pptraj.h", "struct vec omega;"): "2025.02",
    ("src/modules/interface/pptraj.h", "shift_yaw"): "2026.08",
    ("src/modules/interface/stabilizer_types.h", "jerk_t"): "2025.12",
    ("src/modules/interface/stabilizer_types.h", "setpoint_mode_t"): "2026.08",
    ("src/modules/interface/stabilizer_types.h", "coneHalfAngle"): "2026.08",
    ("src/modules/interface/power_distribution.h", "bool powerDistributionCap"): "2025.12",
    ("src/modules/interface/power_distribution.h", "powerDistributionGetMaxThrust"): "2025.12",
    ("src/modules/interface/controller/attitude_controller.h", "ResetAllPID(float rollActual"): "2025.02",
    ("src/modules/interface/controller/position_controller.h", "ResetAllPID(float xActual"): "2025.02",
    ("src/modules/interface/controller/controller.h", "ControllerTypeLee"): "2025.12",
    ("src/modules/interface/controller/controller_pid.h", "EnterPreciseLanding"): "after",
    ("src/modules/interface/kalman_core/kalman_core.h", "float attitudeReversion"): "2025.12",
    ("src/modules/interface/kalman_core/kalman_core.h", "const kalmanCoreParams_t *params, Axis3f *acc"): "2025.12",
    ("src/modules/interface/kalman_core/kalman_core.h", "dragB_x"): "2026.08",
    ("src/modules/interface/outlierfilter/outlierFilterLighthouse.h", "openingWindowMs;"): "2025.02",
    ("src/modules/interface/console.h", "ConsoleSource"): "2026.08",
    ("src/modules/interface/crtp.h", "CRTP_PORT_SUPERVISOR"): "2026.08",
    ("src/modules/src/planner.c", "if (p->trajectory == NULL)"): "2025.02",
    ("src/platform/interface/platform_defaults_cf2.h", "CONFIG_CRAZYFLIE_21_PLUS"): "2026.08",
    ("src/utils/interface/cfassert.h", "stm32fxxx.h"): "2025.02",
    ("src/utils/interface/pid.h", "pidReset(PidObject *pid, float initial)"): "2025.02",
    ("bindings/setup.py", "controller_lee.c"): "2025.12",
    ("bindings/cffirmware.i", "controller_lee.h"): "2025.12",
}


@pytest.mark.parametrize("release", RELEASES)
def test_a_release_has_what_came_with_it_and_before(tmp_path, release):
    checkout = lay_out(tmp_path / "firmware", release=release)
    for (name, text), since in CAME_WITH.items():
        assert (text in (checkout / name).read_text()) == (release >= since), (name, text)
    assert not [path for path in checkout.rglob("*") if path.is_file() and "MINIATURE" in path.read_text()]
    assert not [path for path in checkout.rglob("*.[ch]") if "PRECISE_LANDING" in path.read_text()]


@pytest.mark.parametrize("release", RELEASES)
def test_all_forms_of_the_list_name_the_same_files_and_these_exist(tmp_path, release):
    found = set()
    for form in SETUP_PY:
        checkout = lay_out(tmp_path / form, release=release, setup_py=form)
        lists = read_setup_lists(checkout / SETUP)
        sources = sorted(str((checkout / name).resolve().relative_to(checkout.resolve())) for name in lists.sources)
        assert lists.notes == ()
        assert all((checkout / name).is_file() for name in sources)
        found.add((tuple(sources), len(lists.include_dirs), tuple(lists.flags)))
    assert len(found) == 1
    assert len(sources) == (29 if release >= "2025.12" else 28)


@pytest.mark.parametrize("form", SETUP_PY)
def test_the_list_is_read_as_python_would_run_it(tmp_path, monkeypatch, form):
    """Ours may be run, which is never done with that of a checkout."""
    handed = {}
    commands = SimpleNamespace(build=type("build", (), {}))
    tools = SimpleNamespace(
        Extension=lambda name, **words: handed.update(words),
        setup=lambda **words: None,
        command=SimpleNamespace(build=commands),
    )
    tools.core = tools
    for name in ("distutils", "setuptools"):
        for module in (name, f"{name}.core", f"{name}.command", f"{name}.command.build"):
            monkeypatch.setitem(sys.modules, module, commands if module.endswith("build") else tools)
    script = lay_out(tmp_path, setup_py=form) / SETUP
    exec(compile(script.read_text(), "setup.py", "exec"), {})
    lists = read_setup_lists(script)
    assert [*lists.sources, "build/cffirmware_wrap.c"] == handed["sources"]
    assert list(lists.include_dirs) == handed["include_dirs"]
    assert list(lists.flags) == handed["extra_compile_args"]


def test_without_the_nested_submodule_its_folder_is_empty(tmp_path):
    checkout = lay_out(tmp_path, cmsis=False)
    assert list((checkout / "vendor" / "CMSIS").iterdir()) == []
    with pytest.raises(CheckoutError, match=r"submodule update --init.* vendor/CMSIS"):
        open_checkout(checkout)


def test_as_a_repository_it_has_a_version(tmp_path):
    checkout = lay_out(tmp_path, release="2025.02", git=True)
    assert describe(checkout) == "2025.02"
    status = subprocess.run(["git", "-C", checkout, "status", "--porcelain"], check=True, capture_output=True)
    assert status.stdout == b""
    (checkout / "src" / "modules" / "src" / "planner.c").write_text("")
    assert describe(checkout) == "2025.02-dirty"


@pytest.mark.parametrize("platform", ["cf2", "cf21bl", "bolt"])
def test_it_has_platforms(tmp_path, platform):
    assert settings(lay_out(tmp_path), platform)[f"CONFIG_PLATFORM_{platform.upper()}"] == "1"


# ------------------------------------------------------------------------------------------------------------- shape

COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]+(?:"([^"]+)"|(<[^>]+>))', re.MULTILINE)
GUARD = re.compile(r"^#ifndef (\w+)\n#define \1$", re.MULTILINE)


def code_of(path):
    return COMMENT.sub("", path.read_text())


def includes_of(text):
    return [quoted or angled for quoted, angled in INCLUDE.findall(text)]


@pytest.fixture(scope="module")
def trees(tmp_path_factory):
    """The newest release, the oldest, and others on request."""
    laid = {}

    def tree(release):
        if release not in laid:
            laid[release] = lay_out(tmp_path_factory.mktemp("tree") / release, release=release)
        return laid[release]

    return tree


@pytest.mark.parametrize("release", RELEASES)
def test_headers_lie_where_the_firmware_has_them(trees, release):
    root = trees(release)
    for name, folder in SHAPE["folders"].items():
        assert [str(path.relative_to(root)) for path in root.rglob(name)] == [f"{folder}/{name}"]
    for name in SHAPE["nowhere"]:
        assert list(root.rglob(name)) == []


@pytest.mark.parametrize("name", SHAPE["headers"])
def test_a_header_has_its_guard_and_includes(trees, name):
    header = SHAPE["headers"][name]
    code = code_of(trees(NEWEST) / name)
    assert includes_of(code) == header.get("includes", "").split()
    named = GUARD.search(code)
    if header["guard"] == "once":
        assert code.count(ONCE) == 1
        before, _, _ = code.partition(ONCE)
    elif header["guard"] is None:
        assert ONCE not in code
        assert named is None or named.group(1) == "DEBUG_FMT"
        before = ""
    else:
        assert named.group(1) == header["guard"]
        assert ONCE not in code
        before = code[: named.start()]
    assert len(includes_of(before)) == header.get("before", 0)
    if name in SHAPE["first_line"]:
        assert (trees(NEWEST) / name).read_text().startswith(ONCE)


@pytest.mark.parametrize("name", SHAPE["sources"])
def test_a_source_includes_what_it_does(trees, name):
    assert includes_of(code_of(trees(NEWEST) / name)) == SHAPE["sources"][name].split()


@pytest.mark.parametrize("fact", SHAPE["facts"], ids=lambda fact: f"{Path(fact['path']).name}: {fact['says']}")
def test_a_fact_holds(trees, fact):
    path = trees(fact.get("release", NEWEST)) / fact["path"]
    assert [wanted for wanted in fact.get("has", ()) if wanted not in path.read_text()] == []
    assert [unwanted for unwanted in fact.get("lacks", ()) if unwanted in code_of(path)] == []


@pytest.mark.parametrize("name", SHAPE["symbols"])
def test_a_symbol_is_configured(trees, name):
    symbol = SHAPE["symbols"][name]
    entries = (trees(NEWEST) / symbol["path"]).read_text().split("\n\n")
    (entry,) = [one for one in entries if one.startswith(f"config {name}\n")]
    assert [line for line in symbol["lines"] if f"    {line}" not in entry] == []


@pytest.mark.parametrize("platform", SHAPE["defconfigs"])
def test_defconfigs_are_as_stored(trees, platform):
    lines = (trees(NEWEST) / "configs" / f"{platform}_defconfig").read_text().split()
    assert lines == SHAPE["defconfigs"][platform]


def test_the_list_lacks_the_folder_of_estimators(trees):
    lists = read_setup_lists(trees(NEWEST) / SETUP)
    assert len(lists.include_dirs) == 13
    assert not [name for name in lists.include_dirs if name.endswith("/estimator")]


def test_the_bindings_are_described_as_the_firmware_does(trees):
    root = trees(NEWEST)
    assert (root / "cffirmware_setup.py").read_text() == (root / SETUP).read_text()
    interface = (root / "bindings" / "cffirmware.i").read_text()
    included = re.findall(r'^#include "(\w+)\.h"', interface, flags=re.MULTILINE)
    wrapped = re.findall(r'^%include "(\w+)\.h"', interface, flags=re.MULTILINE)
    assert set(included) - set(wrapped) == {"position_controller", "pid", "filter", "num"}
    assert wrapped.index("imu_types") == wrapped.index("controller_pid") + 1
    assert "#define __attribute__(x)" in interface
    for helper in ("piecewise_get", "poly4d_malloc", "svec2vec", "collisionAvoidanceUpdateSetpointWrap", "assertFail"):
        assert f"{helper}(" in interface


KERNEL = """
#ifndef INC_FREERTOS_H
#define INC_FREERTOS_H
#include <stddef.h>
#include <stdint.h>
typedef uint32_t TickType_t;
#define portTickType TickType_t
#include "FreeRTOSConfig.h"
#endif
"""
SETTINGS = {
    "cf2": "PLATFORM_CF2 ENABLE_THRUST_BAT_COMPENSATED CRAZYFLIE_21_PLUS",
    "cf21bl": "PLATFORM_CF21BL ENABLE_THRUST_BAT_COMPENSATED MOTORS_REQUIRE_ARMING",
    "bolt": "PLATFORM_BOLT MOTORS_REQUIRE_ARMING",
}
WARNINGS = (  # of headers of the firmware, on hosts
    "Don't know which stm32fxxx",
    "cast from pointer to integer of different size",
    "implicit declaration of function 'abs'",
    "address of packed member",
    "expects argument of type 'long unsigned int'",
)


def compile_all(root, folder, platform, vehicle):
    """Compile what the shape is about, without a result; return errors and warnings."""
    (folder / "autoconf.h").write_text(
        "".join(f"#define CONFIG_{name} 1\n" for name in ["ESTIMATOR_KALMAN_ENABLE", *SETTINGS[platform].split()])
    )
    lists = read_setup_lists(root / SETUP)
    folders = [f"-I{root / name}" for name in lists.include_dirs]
    command = ["gcc", "-std=gnu11", "-fsyntax-only", "-O1", "-fno-strict-aliasing", f"-I{folder}", *folders]
    # modules of the system want more of a kernel than this has, and are compiled with the libraries of forks
    sources = [path for path in (root / "src").rglob("*.c") if not (SYSTEM / path.relative_to(root)).is_file()]
    if vehicle:
        (folder / "FreeRTOS.h").write_text(KERNEL)
        (folder / "task.h").write_text("#pragma once\nTickType_t xTaskGetTickCount(void);\n")
        (folder / "stm32f4xx.h").write_text("#pragma once\n")
        command += ["-DCRAZYFLIE_FW", "-include", "autoconf.h", f"-I{root / 'src/modules/interface/estimator'}"]
    else:
        sources = [path for path in sources if path.name != "position_estimator_altitude.c"]
        command += ["-DUNIT_TEST_MODE"]
    done = subprocess.run(
        [*command, *sources],
        capture_output=True,
        text=True,
        env={**os.environ, "LC_ALL": "C"},
    )
    return done.returncode, [line for line in done.stderr.splitlines() if "warning: " in line or "error: " in line]


# releases in between, and their modes, are built by test_levels.py
@pytest.mark.parametrize(
    ("release", "platform", "vehicle"),
    [("2024.10", "cf2", False), ("2026.08", "cf2", False), ("2026.08", "cf21bl", True), ("2026.08", "bolt", True)],
)
def test_every_source_compiles(trees, tmp_path, release, platform, vehicle):
    failed, told = compile_all(trees(release), tmp_path, platform, vehicle)
    assert not failed, told
    assert [line for line in told if not any(known in line for known in WARNINGS)] == []
    assert any("stm32fxxx" in line for line in told) == (release > "2024.10")


def test_idle_thrust_without_arming_does_not_compile(trees, tmp_path, monkeypatch):
    monkeypatch.setitem(SETTINGS, "cf21bl", "PLATFORM_CF21BL ENABLE_THRUST_BAT_COMPENSATED")
    failed, told = compile_all(trees(NEWEST), tmp_path, "cf21bl", vehicle=True)
    assert failed
    assert [line for line in told if "idle thrust" in line]


def test_defaults_of_a_platform_are_not_included_directly(trees, tmp_path):
    (tmp_path / "mine.c").write_text('#include "platform_defaults_cf2.h"\n')
    command = ["gcc", "-fsyntax-only", f"-I{trees(NEWEST) / 'src/platform/interface'}", tmp_path / "mine.c"]
    assert subprocess.run(command, capture_output=True).returncode
