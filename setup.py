"""The one Python build: metadata in pyproject.toml, C sources in bindings/sources.txt."""

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from itertools import chain

from setuptools import setup
from setuptools.command.build_ext import build_ext


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
    cmdclass={"build_ext": ParallelBuild},
    options={"bdist_wheel": {"py_limited_api": PYTHON}},
)
