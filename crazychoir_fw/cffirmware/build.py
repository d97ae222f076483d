"""From a checkout to an extension module with upstream's functions; from the cache when nothing changed."""

from __future__ import annotations

import io
import re
import secrets
import sysconfig
import tempfile
from collections.abc import Sequence
from pathlib import Path

from crazychoir_fw import _core
from crazychoir_fw.cffirmware.declarations import declarations_of, features
from crazychoir_fw.common.errors import BuildError, CompileError, LinkError
from crazychoir_fw.common.version import __version__
from crazychoir_fw.firmware import linking
from crazychoir_fw.firmware.cache import Cache, Fingerprints, digest_of, digest_of_code, sha256_of, used
from crazychoir_fw.firmware.checkout import open_checkout
from crazychoir_fw.firmware.objects import Compiled, Objects, Unit, demand_all
from crazychoir_fw.firmware.own_sources import bindings_folder
from crazychoir_fw.firmware.probes import source_flag
from crazychoir_fw.firmware.recipe import Recipe, bitcraze_recipe
from crazychoir_fw.firmware.toolchain import Compiler, find_compiler

MODULE = "_crazychoir_cffirmware"

# sources beyond the checkout's own list whose functions have a name here; sources with other needs are left out
_CONTROLLERS = tuple(f"controller_{name}.c" for name in ("brescianini", "lee", "mellinger"))
_MEASURED = ("tdoa", "position", "pose", "distance", "tof", "flow", "absolute_height", "yaw_error")
_OPTIONAL = (*_CONTROLLERS, *(f"mm_{name}.c" for name in _MEASURED))

# upstream adds and leaves out const at will
_TOLERANT = ("-Wno-incompatible-pointer-types", "-Wno-discarded-qualifiers", "-Wno-unknown-warning-option", "-w")
_STRICT = (
    "-Werror=implicit-function-declaration",
    "-Werror=incompatible-pointer-types",
    "-Werror=int-conversion",
    "-Wno-discarded-qualifiers",
    "-Wno-unknown-warning-option",
    "-Wno-incompatible-pointer-types-discards-qualifiers",
)


def build_module(checkout: Path | str | None = None, platform: str = "cf2") -> Path:
    """Return the extension module of a checkout; built if need be.

    Nothing is written into the checkout. When no file that takes part has changed, the module of the last build is
    returned.

    Args:
        checkout: Folder of a checkout; None: the one that the environment names, else the submodule ``firmware/``.
        platform: ``cf2``, ``cf21bl`` or ``bolt``.

    Raises:
        CheckoutError: If the checkout is missing, incomplete or too old.
        UnknownNameError: If there is no such platform.
        CompileError: If sources do not compile; with what the compiler printed.
        LinkError: If symbols are undefined.
        BuildError: If there is no compiler, or Python's headers are missing.
    """
    return _ModuleBuild(bitcraze_recipe(open_checkout(checkout), platform)).run()


class _ModuleBuild:
    """One build, from the recipe to the module."""

    def __init__(self, recipe: Recipe) -> None:
        self.recipe = recipe
        self.cache = Cache()
        self.compiler: Compiler = find_compiler()
        self.fingerprints = Fingerprints()
        self.inputs: dict[str, str | None] = {}

    def run(self) -> Path:
        suffix = sysconfig.get_config_var("EXT_SUFFIX")
        code = digest_of_code(Path(__file__).parent, Path(linking.__file__).parent)
        plain = [__version__, code, suffix, self.compiler.command, self.compiler.version, self.recipe.key()]
        key = f"module-{digest_of(plain)}"
        if (path := self._recall(key)) is not None:
            return path
        with self.cache.alone(key):
            generated = self.cache.write_generated(self.recipe.generated)
            # another process may have built it meanwhile
            self.fingerprints = Fingerprints()
            if (path := self._recall(key)) is not None:
                return path
            path = self._build(generated, suffix)
            if not self.fingerprints.changed_meanwhile(self.inputs):
                value = {"module": f"{path.parent.name}/{path.name}", "sha256": sha256_of(path)}
                self.cache.remember(key, self.inputs, value)
        self.cache.prune()
        return path

    def _recall(self, key: str) -> Path | None:
        value = self.cache.recall(key, self.fingerprints)
        if value is None:
            return None
        path = self.cache.modules / value["module"]
        if not path.is_file() or value.get("sha256") != sha256_of(path):
            return None
        used(path.parent)
        return path

    def _build(self, generated: Path, suffix: str) -> Path:
        recipe = self.recipe
        bindings = bindings_folder()
        headers = recipe.header_names()
        self.objects = Objects(self.compiler, self.cache, self.fingerprints, headers, self._root())
        theirs = recipe.host_flags(generated)

        compiled = self._compile([Unit(path, theirs) for path in recipe.sources])
        compiled += self._compile([Unit(bindings / "cffi" / "cffirmware_services.c", recipe.flags)])
        optional = [Unit(path, theirs) for path in recipe.extras if path.name in _OPTIONAL]
        compiled = self._complete(compiled, [one for one in self._compile(optional, must=False) if one.ok])

        self._flags = [*theirs, f"-I{bindings}", *(source_flag("CF_WITH", one.unit.source) for one in compiled)]
        self._flags += [f"-DCF_HAS_{name}={int(there)}" for name, there in features(self._ask).items()]
        self.inputs |= self.fingerprints.all_of([_core.__file__])  # whose types are asked for
        declared = declarations_of(bindings, self._ask)
        compiled += self._compile_module(declared)

        folder = self.cache.modules / f"{recipe.platform}-{secrets.token_hex(8)}"
        with self.cache.workspace(self.cache.modules) as workspace:
            # what Python defines is found when the module is loaded
            linking.link(self.compiler, _sources(compiled), workspace / f"{MODULE}{suffix}", is_completed_later=True)
            workspace.replace(folder)
        return folder / f"{MODULE}{suffix}"

    def _compile(self, units: Sequence[Unit], must: bool = True) -> list[Compiled]:
        results = self.objects.compile_all(units)
        for result in results:
            self.inputs |= {path: content for path, content in result.inputs.items() if not self._is_generated(path)}
        if must:
            demand_all(results)
        return results

    def _is_generated(self, path: str) -> bool:
        return Path(path).is_relative_to(self.cache.root)

    def _complete(self, needed: list[Compiled], optional: list[Compiled]) -> list[Compiled]:
        """Return the objects that need nothing from elsewhere.

        Raises:
            LinkError: If one that cannot be left out does.
        """
        while True:
            objects = _sources([*needed, *optional])
            with tempfile.TemporaryDirectory() as folder:
                undefined = linking.link(self.compiler, objects, Path(folder) / "trial.so")
            if not undefined:
                return [*needed, *optional]
            dispensable = {one.unit.source for one in optional}
            if lost := [one for one in undefined if not one.needed_by or set(one.needed_by) - dispensable]:
                raise LinkError(linking.explain(lost))
            users = {source for symbol in undefined for source in symbol.needed_by}
            optional = [one for one in optional if one.unit.source not in users]

    def _ask(self, includes: str, lines: list[str]) -> set[int]:
        """Return the numbers of the lines of C that do not compile."""
        first = includes.count("\n") + 1
        text = includes + "\n".join(lines) + "\n"
        source = self.cache.write_generated({"asked.c": text}) / "asked.c"
        unlimited = "-ferror-limit=0" if "clang" in self.compiler.version else "-fmax-errors=0"
        unit = Unit(source, (*self._flags, *_STRICT, unlimited), syntax_only=True)
        (answer,) = self._compile([unit], must=False)
        place = re.compile(rf"^{re.escape(str(source))}:(\d+):\d+: (?:fatal )?error", re.MULTILINE)
        failing = {int(number) - first for number in place.findall(answer.output)}
        if not answer.ok and (not failing or min(failing) < 0 or "fatal error" in answer.output):
            raise CompileError(f"the headers of {self._root()} do not compile together:\n{answer.output.rstrip()}")
        return failing

    def _root(self) -> Path:
        assert self.recipe.checkout is not None
        return self.recipe.checkout.root

    def _compile_module(self, declared: str) -> list[Compiled]:
        """Compile what cffi makes of the declarations."""
        from cffi import FFI
        from cffi.recompiler import make_c_source

        builder = FFI()
        builder.cdef(declared)
        written = io.StringIO()
        make_c_source(builder, MODULE, '#include "cffi/cffirmware_bitcraze.h"', written)
        text = written.getvalue()
        source = self.cache.write_generated({f"{MODULE}.c": text}) / f"{MODULE}.c"
        # calls and conversions only: nothing to gain by more, and it takes half of the build
        quick = ("-O1", "-g0")
        unit = Unit(source, (*self._flags, f"-I{sysconfig.get_path('include')}", *_TOLERANT, *quick))
        try:
            return self._compile([unit])
        except CompileError as error:
            if re.search(r"fatal error: '?(Python|pyconfig)\.h", str(error)):
                raise BuildError("Python.h is missing: run `apt install python3-dev` (Debian, Ubuntu)") from None
            raise


def _sources(compiled: Sequence[Compiled]) -> dict[Path, Path]:
    """Return object to source."""
    return {one.path: one.unit.source for one in compiled if one.path is not None}
