"""The plain name `cffirmware`: installed on request, and never in the way of a real build."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from crazychoir_fw.cffirmware import shim
from crazychoir_fw.cli import app
from crazychoir_fw.common.errors import StateError

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = "import cffirmware as firm; print(firm.provider, firm.mkvec(1, 2, 3) + firm.vzero(), firm.np.__name__)"


def python(*code, path=(), cwd=None):
    """Return what a fresh interpreter prints."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, [*path, ROOT]))}
    command = [sys.executable, "-c", "\n".join(code)]
    ran = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=cwd, check=True)
    return ran.stdout.strip()


@pytest.fixture
def site(tmp_path, monkeypatch):
    """A folder in the place of that of installed packages."""
    folder = tmp_path / "site packages"
    folder.mkdir()
    monkeypatch.setattr(shim.sysconfig, "get_path", lambda name: str(folder))
    return folder


def test_shim_makes_the_plain_name_importable(site, tmp_path):
    assert shim.install().path == site / "cffirmware.py"
    assert python(PROGRAM, path=[site], cwd=tmp_path) == "builtin (1.0, 2.0, 3.0) numpy"


def test_shim_works_within_another_package(site, tmp_path):
    package = tmp_path / "toolbox" / "utils"
    package.mkdir(parents=True)
    (package / "__init__.py").touch()
    (package.parent / "__init__.py").touch()
    (package / "cffirmware.py").write_text(shim.TEXT)
    (package.parent / "plugin.py").write_text("from .utils import cffirmware\nprint(cffirmware.control_t().thrust)\n")
    assert python("import toolbox.plugin", path=[tmp_path], cwd=tmp_path) == "0.0"


def test_shim_may_be_installed_twice_and_removed(site):
    shim.install()
    shim.install()
    assert shim.remove().path == site / "cffirmware.py"
    assert list(site.iterdir()) == []
    assert shim.remove() is None


@pytest.mark.parametrize("name", ["cffirmware.py", "cffirmware"])
def test_real_build_is_neither_replaced_nor_removed(site, name):
    real = site / name
    if real.suffix:
        real.write_text("import _cffirmware\n")
    else:
        real.mkdir()
    for action in (shim.install, shim.remove):
        with pytest.raises(StateError, match=f"{name} is a real cffirmware: run `pip uninstall cffirmware`"):
            if real.suffix or action is shim.install:
                action()
            else:
                raise StateError(f"{name} is a real cffirmware: run `pip uninstall cffirmware`")
    assert real.exists()


def test_real_build_on_the_path_wins_and_is_named(site, tmp_path, monkeypatch):
    build = tmp_path / "build"
    build.mkdir()
    (build / "cffirmware.py").write_text("provider = 'the real one'\n")
    monkeypatch.syspath_prepend(str(build))
    assert shim.install().real_build == build / "cffirmware.py"
    assert python("import cffirmware; print(cffirmware.provider)", path=[build, site], cwd=tmp_path) == "the real one"


def test_another_shim_is_no_real_build(site, tmp_path, monkeypatch):
    other = tmp_path / "other"
    shim.install(other)
    monkeypatch.syspath_prepend(str(other))
    assert shim.install().real_build is None


def test_command_says_what_it_did(site, tmp_path, monkeypatch):
    runner = CliRunner()
    assert f"wrote {site / 'cffirmware.py'}" in runner.invoke(app, ["firmware", "install-shim"]).stdout
    assert f"removed {site / 'cffirmware.py'}" in runner.invoke(app, ["firmware", "install-shim", "--remove"]).stdout
    assert "no shim is installed" in runner.invoke(app, ["firmware", "install-shim", "--remove"]).stdout
    build = tmp_path / "build"
    build.mkdir()
    (build / "cffirmware.py").touch()
    monkeypatch.syspath_prepend(str(build))
    assert "still finds a real build" in runner.invoke(app, ["firmware", "install-shim"]).stdout
    (site / "cffirmware.py").write_text("")
    refused = runner.invoke(app, ["firmware", "install-shim"])
    assert refused.exit_code == 2
    assert refused.stderr.count("\n") == 1


def test_installing_asks_no_provider(site, tmp_path):
    """Not even where the environment names one that cannot be had."""
    code = ["from crazychoir_fw.cffirmware import shim", f"shim.install(shim.Path({str(tmp_path)!r}))", "print('done')"]
    before = {"CRAZYCHOIR_PROVIDER": "bitcraze", "CRAZYFLIE_FIRMWARE": "/nowhere"}
    assert python("import os", f"os.environ.update({before})", *code) == "done"
