"""The extension module over a checkout: cached, rebuilt, and refused with a reason."""

import shutil
import subprocess
import sysconfig
from pathlib import Path

import pytest

from crazychoir_fw.cffirmware import build, loading
from crazychoir_fw.common.errors import BuildError, CompileError, LinkError
from crazychoir_fw.firmware.linking import Undefined
from crazychoir_fw.firmware.toolchain import find_compiler

KALMAN = "src/modules/src/kalman_core/kalman_core.c"


@pytest.fixture
def shared_cache(shared_folder, monkeypatch):
    monkeypatch.setenv("CRAZYCHOIR_CACHE", str(shared_folder / "cache"))


@pytest.fixture
def own_checkout(checkout, tmp_path, shared_cache):
    """A checkout that a test may spoil, with a space in its path."""
    return shutil.copytree(checkout("2026.08"), tmp_path / "my firmware")


def test_second_build_compiles_nothing(over_miniature, checkout, shared_cache, monkeypatch):
    over_miniature("2026.08")
    monkeypatch.setattr(build.Objects, "compile_all", None)
    path = build.build_module(checkout("2026.08"))
    assert path == build.build_module(checkout("2026.08"))
    assert path.is_file()


def test_what_changed_during_the_build_is_built_again(own_checkout, monkeypatch, tmp_path):
    source = own_checkout / KALMAN
    made = []

    def build_slowly(self, generated, suffix):
        made.append(self.cache.modules / f"built-{len(made)}" / f"a{suffix}")
        made[-1].parent.mkdir()
        made[-1].touch()
        self.inputs = self.fingerprints.all_of([str(source)])
        if len(made) == 1:
            source.write_text(f"{source.read_text()}\n")
        return made[-1]

    monkeypatch.setenv("CRAZYCHOIR_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(build._ModuleBuild, "_build", build_slowly)
    paths = [build.build_module(own_checkout) for _ in range(3)]
    assert [made.index(path) for path in paths] == [0, 1, 1]


def test_every_load_is_another_copy(over_miniature, checkout, shared_cache):
    over_miniature("2026.08")
    path = build.build_module(checkout("2026.08"))
    one, other = loading.load(path)[1], loading.load(path)[1]
    one.controllerPidInit()
    assert one.controllerPidTest()
    assert not other.controllerPidTest()


def test_source_that_does_not_compile_is_shown(own_checkout):
    source = own_checkout / KALMAN
    source.write_text(f"#error not yet finished\n{source.read_text()}")
    with pytest.raises(CompileError, match="1 file does not compile") as caught:
        build.build_module(own_checkout)
    assert "not yet finished" in str(caught.value)
    assert str(source) in str(caught.value)


def test_undefined_symbol_is_named(tmp_path):
    source = tmp_path / "module.c"
    source.write_text(
        f"void nobodyHasThis(void);\nvoid *PyInit_{build.MODULE}(void) {{ nobodyHasThis(); return 0; }}\n"
    )
    library = tmp_path / f"{build.MODULE}{sysconfig.get_config_var('EXT_SUFFIX')}"
    subprocess.run([*find_compiler().command, "-shared", "-fPIC", "-o", library, source], check=True)
    with pytest.raises(LinkError, match="undefined symbol nobodyHasThis"):
        loading.load(library)


def test_source_that_needs_more_is_left_out_if_it_can_be(over_miniature, checkout, shared_cache, monkeypatch):
    """A measurement model can, a controller of the checkout's own list cannot."""
    over_miniature("2026.08")
    tried = []

    def undefined(compiler, objects, path):
        tried.append({source.name for source in objects.values()})
        model = next((source for source in objects.values() if source.name == "mm_pose.c"), None)
        return [Undefined("nobodyHasThis", (model,))] if model else []

    monkeypatch.setattr(build.linking, "link", undefined)
    builder = build._ModuleBuild(build.bitcraze_recipe(build.open_checkout(checkout("2026.08")), "cf2"))
    model, other = (_compiled(name) for name in ("mm_pose.c", "mm_tof.c"))
    assert builder._complete([_compiled("planner.c")], [model, other])[1:] == [other]
    assert [len(names) for names in tried] == [3, 2]
    with pytest.raises(LinkError, match="undefined symbol nobodyHasThis, needed by .*mm_pose.c"):
        builder._complete([model], [other])


def _compiled(name):
    return build.Compiled(build.Unit(Path(name), ()), True, "", {}, Path(f"{name}.o"))


def test_missing_headers_of_python_are_one_sentence(own_checkout, monkeypatch, tmp_path):
    monkeypatch.setenv("CRAZYCHOIR_CACHE", str(tmp_path / "cache"))
    real = build.sysconfig.get_path
    monkeypatch.setattr(build.sysconfig, "get_path", lambda name: str(tmp_path) if name == "include" else real(name))
    monkeypatch.setattr(build._ModuleBuild, "_compile", _only_the_module(build._ModuleBuild._compile))
    with pytest.raises(BuildError, match=r"Python.h is missing: run `apt install python3-dev`"):
        build.build_module(own_checkout)


def _only_the_module(compile_units):
    """Return a function that compiles the module and checks headers, but compiles no other sources."""

    def compile_some(self, units, must=True):
        some = [unit for unit in units if unit.syntax_only or unit.source.name == f"{build.MODULE}.c"]
        return compile_units(self, some, must)

    return compile_some


def test_failed_assertion_of_c_is_a_system_error(old_firm):
    core, params = old_firm.kalmanCoreData_t(), old_firm.kalmanCoreParams_t()
    with pytest.raises(SystemError) as caught:
        old_firm.kalmanCoreDecoupleXY(core)
    assert str(caught.value.__cause__) == 'P < 0 in File: "kalman_core.c", line 12\n'
    old_firm.kalmanCoreDefaultParams(params)
    old_firm.kalmanCoreInit(core, params, 0)  # the failure is reported once
