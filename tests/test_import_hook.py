"""A package is prepared at its first import."""

import subprocess
import sys
from contextlib import contextmanager, nullcontext
from importlib.machinery import BuiltinImporter, FrozenImporter, PathFinder

import pytest

from crazychoir_fw.common.import_hook import at_import


def test_code_runs_around_and_after_the_first_import(tmp_path, monkeypatch):
    (tmp_path / "prepared_toy.py").write_text("import seen\nseen.calls.append('toy')\n")
    (tmp_path / "seen.py").write_text("calls = []\n")
    monkeypatch.syspath_prepend(tmp_path)
    import seen

    @contextmanager
    def around():
        seen.calls.append("before")
        yield
        seen.calls.append("end")

    finders = list(sys.meta_path)
    at_import("prepared_toy", around, lambda: seen.calls.append("after"))
    import prepared_toy

    assert seen.calls == ["before", "toy", "end", "after"]
    assert sys.meta_path == finders
    assert prepared_toy.__loader__ is prepared_toy.__spec__.loader
    assert type(prepared_toy.__loader__).__name__ == "SourceFileLoader"
    at_import("prepared_toy", around, lambda: seen.calls.append("at once"))
    assert seen.calls[-1] == "at once"


class AsksAllOthers:
    """Finds modules as tools do that count lines: by asking all finders but itself."""

    def find_spec(self, name, path, target=None):
        specs = (finder.find_spec(name, path, target) for finder in sys.meta_path if finder is not self)
        return next((spec for spec in specs if spec is not None), None)


def test_finders_that_ask_each_other_come_to_an_end(tmp_path, monkeypatch):
    (tmp_path / "counted_toy.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    # without the finders of tools that count lines, which ask all others as well
    monkeypatch.setattr(sys, "meta_path", [BuiltinImporter, FrozenImporter, PathFinder])
    called = []
    at_import("counted_toy", nullcontext, lambda: called.append("after"))
    sys.meta_path.insert(0, AsksAllOthers())
    import counted_toy

    assert counted_toy.__loader__ is not None
    assert called == ["after"]


def run(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()


def loaded_by(statement):
    """Return the modules that a statement imports in a fresh interpreter."""
    code = f"import sys; before = set(sys.modules); {statement}; print(*sorted(sys.modules.keys() - before))"
    return set(run(code))


SLOW = {"mujoco", "numpy", "pydantic", "matplotlib", "cffi", "http.client"}


def test_the_package_is_imported_without_mujoco_and_numpy():
    loaded = loaded_by("import crazychoir_fw")
    assert "crazychoir_fw._core" in loaded
    assert not loaded & (SLOW | {"rich", "importlib.metadata"})


def test_the_command_line_is_imported_without_mujoco_and_numpy():
    loaded = loaded_by("import crazychoir_fw.cli")
    assert "typer" in loaded
    assert not loaded & SLOW


MODEL = """<mujoco>
  <extension><plugin plugin="crazychoir.crazyflie"><instance name="cf"/></plugin></extension>
  <worldbody><body><freejoint/><geom size="0.1" mass="1"/><plugin instance="cf"/></body></worldbody>
</mujoco>"""
STEP = f"""model = mujoco.MjModel.from_xml_string({MODEL!r})
data = mujoco.MjData(model)
mujoco.mj_step(model, data)
print(data.timer[mujoco.mjtTimer.mjTIMER_STEP].duration)"""


@pytest.mark.parametrize("order", ["crazychoir_fw, mujoco", "mujoco, crazychoir_fw"])
def test_steps_are_not_timed_whatever_is_imported_first(order):
    assert run(f"import {order}\n{STEP}") == ["0.0"]


def test_a_broken_choice_of_opengl_does_not_keep_mujoco_from_importing():
    code = "import os; os.environ['MUJOCO_GL'] = 'nonsense'; import crazychoir_fw, mujoco"
    assert run(f"{code}; print(os.environ['MUJOCO_GL'])") == ["nonsense"]


SIGNALED = """import os, signal, sys, threading, time
import crazychoir_fw

def end(number, frame):
    print("mujoco" in sys.modules and hasattr(sys.modules["mujoco"], "mj_step"))
    raise SystemExit(7)

signal.signal(signal.SIGTERM, end)
threading.Timer({delay}, os.kill, (os.getpid(), signal.SIGTERM)).start()
import mujoco
time.sleep(10.0)
"""


@pytest.mark.parametrize("delay", [0.02, 0.05, 0.1, 0.2])
def test_a_signal_waits_until_mujoco_is_imported(delay):
    """Its extensions take an exception of a handler for a mistake of theirs."""
    ended = subprocess.run([sys.executable, "-c", SIGNALED.format(delay=delay)], capture_output=True, text=True)
    assert (ended.returncode, ended.stdout.split(), ended.stderr) == (7, ["True"], "")
