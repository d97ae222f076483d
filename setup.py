"""The one Python build: metadata in pyproject.toml, C sources in bindings/sources.txt."""

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from itertools import chain
from pathlib import Path

from setuptools import setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py

ROOT = Path(__file__).resolve().parent
# what the installed package reads of the repository (crazychoir_fw/common/shared_folders.py)
SHARED = {
    "bindings": (".c", ".h", ".txt"),  # compiled again for provider libraries
    "examples": (".c", ".csv", ".npz", ".py", ".xml", ".yaml"),  # starting points of `crazychoir new`
    "mujoco_models": (".xml", ".obj", ".png"),
}


def shared_files():
    """Return the files of the repository that a wheel holds, relative to its root."""
    for folder, suffixes in SHARED.items():
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in suffixes:
                yield path.relative_to(ROOT).as_posix()


class BuildWithSharedFiles(build_py):
    """Copies files of the repository into the package; an editable install finds them where they are."""

    def run(self):
        super().run()
        if not self.editable_mode:
            for target, source in self.shared_targets().items():
                self.mkpath(str(Path(target).parent))
                self.copy_file(source, target)

    def shared_targets(self):
        folder = Path(self.build_lib, "crazychoir_fw", "_shared")
        return {str(folder / file): file for file in shared_files()}

    def get_outputs(self, include_bytecode=1):
        return [*super().get_outputs(include_bytecode), *self.shared_targets()]

    def get_output_mapping(self):
        return {**super().get_output_mapping(), **self.shared_targets()}


class ParallelBuild(build_ext):
    """Compiles the sources of the extension side by side."""

    def finalize_options(self):
        super().finalize_options()
        if os.environ.get("CRAZYCHOIR_COVERAGE"):
            self.build_temp = "build/counted"  # the counters of a run appear beside the objects

    def build_extensions(self):
        compile_in_turn = self.compiler.compile

        def compile_side_by_side(sources, **options):
            with ThreadPoolExecutor(os.cpu_count()) as pool:
                return list(chain(*pool.map(lambda source: compile_in_turn([source], **options), sources)))

        self.compiler.compile = compile_side_by_side
        super().build_extensions()


# the core keeps to Python's stable ABI; but Python 3.10 has another MuJoCo, whose layout it is compiled for
PYTHON = "cp311" if sys.version_info >= (3, 11) else "cp310"

setup(
    cffi_modules=["bindings/cffi/build.py:ffi"],
    cmdclass={"build_ext": ParallelBuild, "build_py": BuildWithSharedFiles},
    options={"bdist_wheel": {"py_limited_api": PYTHON}},
)
