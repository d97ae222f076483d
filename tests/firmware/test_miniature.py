"""The miniature checkout: whole in every release and form, and read like the real one."""

import subprocess
import sys
from types import SimpleNamespace

import pytest
from miniature import RELEASES, SETUP_PY, lay_out

from crazychoir_fw.errors import CheckoutError
from crazychoir_fw.firmware.checkout import SETUP, describe, open_checkout
from crazychoir_fw.firmware.configuration import settings
from crazychoir_fw.firmware.setup_lists import read_setup_lists

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
