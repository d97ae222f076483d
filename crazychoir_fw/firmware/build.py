"""From a checkout, or a user's own C, to a provider library; from the cache when nothing changed."""

from __future__ import annotations

import re
import secrets
import shlex
import threading
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from crazychoir_fw.common.errors import BuildError, CheckoutError, CompileError, LinkError
from crazychoir_fw.common.version import __version__
from crazychoir_fw.firmware import configuration, levels, linking
from crazychoir_fw.firmware.cache import Cache, Fingerprints, digest_of, digest_of_code, used, write_text
from crazychoir_fw.firmware.checkout import VENDOR, Checkout, open_checkout
from crazychoir_fw.firmware.library import BUILD_LOG, Library
from crazychoir_fw.firmware.objects import Compiled, Objects, Unit, demand_all
from crazychoir_fw.firmware.probes import feature_flags, features, probe_units, source_flag
from crazychoir_fw.firmware.recipe import Recipe, bitcraze_recipe, builtin_recipe, vehicle_mode
from crazychoir_fw.firmware.toolchain import Compiler, find_compiler

Progress = Callable[[str, int, int], None]
"""Told what is at work, how many files are done, and of how many. Called by several threads, one at a time."""

_MAX_LINKS = 4


def build_provider(
    checkout: Path | str | None,
    platform: str = "cf2",
    apps: Sequence[Path] = (),
    *,
    configured: Path | None = None,
    level: str = levels.ALGORITHMS,
    force: bool = False,
    progress: Progress | None = None,
) -> Library:
    """Return the library of a checkout, or of the builtin provider with apps; built if need be.

    Nothing is written into the checkout. When no file that takes part has changed, the library of the last build is
    returned, within a fraction of a second. Several processes may ask at once.

    Args:
        checkout: Folder of a checkout of the firmware (see `checkout.open_checkout`), or None for the builtin provider.
        platform: ``cf2``, ``cf21bl``, or for a checkout also ``bolt``.
        apps: C files of the user that become part of the library.
        configured: A configuration header (autoconf.h) to use instead of ours.
        level: How much of a checkout shall fly, one of `levels.LEVELS`, or `levels.ALL` for the highest that compiles;
            what a higher one lacks is in the notes then.
        force: Build everything again.
        progress: Told how far the build is.

    Raises:
        CheckoutError: If the checkout is missing, incomplete or too old.
        UnknownNameError: If there is no such platform, or no such app file.
        CompileError: If sources do not compile; with what the compiler printed.
        LinkError: If symbols are undefined; with their names and the sources that need them.
        BuildError: If there is no compiler, the cache cannot be written, nothing is to be built, or the variables are
            too large for a drone.
    """
    if checkout is None and not apps:
        raise BuildError("there is nothing to build: the builtin provider without apps is part of the package")
    if checkout is None:
        recipe = builtin_recipe(platform, apps)
    elif level == levels.ALL:
        return _build_highest(open_checkout(checkout), platform, apps, configured, force, progress)
    else:
        recipe = bitcraze_recipe(open_checkout(checkout), platform, apps, configured, level)
    return build(recipe, force, progress)


def _build_highest(
    checkout: Checkout,
    platform: str,
    apps: Sequence[Path],
    configured: Path | None,
    force: bool,
    progress: Progress | None,
) -> Library:
    """Return the library of the highest level that compiles; why a higher one does not is in its notes."""
    notes: list[str] = []
    for level in reversed(levels.LEVELS):
        try:
            recipe = bitcraze_recipe(checkout, platform, apps, configured, level)
            library = build(recipe, force, progress)
            # they are no part of the library, which is the same when its level is asked for
            return replace(library, identity={**library.identity, "notes": [*notes, *library.identity["notes"]]})
        except (CompileError, LinkError, CheckoutError) as error:
            if level == levels.ALGORITHMS:
                raise
            notes.append(f"level {level} left out: {_first_reason(str(error))}")
    raise AssertionError("the lowest level returns or raises")


def _first_reason(text: str) -> str:
    """Return the line of what a compiler or linker said that tells why."""
    lines = [line for line in text.splitlines() if line.strip()]
    return next((line for line in lines if "error" in line or "undefined" in line), lines[0] if lines else "no reason")


def build(recipe: Recipe, force: bool = False, progress: Progress | None = None) -> Library:
    """Return the library of a recipe; see `build_provider`."""
    return _Build(recipe, force, progress).run()


@dataclass
class _Choice:
    """How the sources of a checkout are compiled, after they were tried."""

    vehicle_mode: set[Path]
    extras: set[Path]


class _Build:
    """One build, from the recipe to the library."""

    def __init__(self, recipe: Recipe, force: bool, progress: Progress | None) -> None:
        self.recipe = recipe
        self.force = force
        self.cache = Cache()
        self.compiler: Compiler = find_compiler()
        self.fingerprints = Fingerprints()
        self.notes = list(recipe.notes)
        self.inputs: dict[str, str | None] = {}
        self.printed: list[str] = []
        self._progress = progress
        self._lock = threading.Lock()

    def run(self) -> Library:
        plain = [
            __version__,
            digest_of_code(Path(__file__).parent),
            self.compiler.command,
            self.compiler.version,
            self.recipe.key(),
        ]
        key = f"library-{digest_of(plain)}"
        if (library := self._recall(key)) is not None:
            return library
        with self.cache.alone(key):
            generated = self.cache.write_generated(self.recipe.generated)
            # another process may have built it meanwhile
            self.fingerprints = Fingerprints()
            if (library := self._recall(key)) is not None:
                return library
            library = self._build(generated)
            if not self.fingerprints.changed_meanwhile(self.inputs):
                self.cache.remember(key, self.inputs, {"folder": library.path.parent.name})
        self.cache.prune()
        return library

    def _recall(self, key: str) -> Library | None:
        if self.force:
            return None
        value = self.cache.recall(key, self.fingerprints)
        if value is None:
            return None
        folder = self.cache.libraries / value["folder"]
        try:
            library = Library.load(folder)
        except BuildError:
            return None
        used(folder)
        if self.recipe.checkout is None:
            return library
        # a commit changes the version, but not what is compiled
        version = self.recipe.checkout.version() or library.identity["content"]
        return replace(library, identity={**library.identity, "version": version})

    def _build(self, generated: Path) -> Library:
        recipe = self.recipe
        root = None if recipe.checkout is None else recipe.checkout.root
        headers = recipe.header_names()
        self.objects = Objects(self.compiler, self.cache, self.fingerprints, headers, root, recall=not self.force)
        # behind those of the checkout, which has headers of the same names
        own_includes = tuple(f"-idirafter{path}" for path in recipe.own_include_dirs)
        self._host, self._vehicle = recipe.host_flags(generated), recipe.vehicle_flags(generated)
        ours = (*recipe.flags, *own_includes)
        adapting = (*self._vehicle, *own_includes)

        found = features(self._compile("asking", probe_units(recipe.probes, adapting), must=False))
        choice, compiled = self._compile_checkout()
        system = self._compile("compiling", [Unit(path, self._vehicle) for path in recipe.system])
        fixed = self._compile("compiling", [Unit(path, ours) for path in recipe.own])
        app_flags = (*self._vehicle, *recipe.app_flags)
        apps = self._compile("compiling", [Unit(path, app_flags, placed=True) for path in recipe.apps])
        for _ in range(_MAX_LINKS):
            known = [*feature_flags(found), *self._source_flags(choice), *self._level_flags()]
            adapter = self._compile("compiling", [Unit(path, (*adapting, *known)) for path in recipe.adapter])
            objects = [*fixed, *apps, *adapter, *compiled.values(), *system]
            with self.cache.workspace(self.cache.libraries) as folder:
                path = folder / f"{_safe(recipe.name)}.so"
                self._tell("linking", 0, 1)
                sources = {kept.path: kept.unit.source for kept in objects}
                undefined = linking.link(self.compiler, sources, path, words=recipe.linking)
                if not undefined:
                    return self._finish(path, found, choice, objects)
            compiled = self._retreat(undefined, choice, compiled)
        raise LinkError(linking.explain(undefined))

    def _compile_checkout(self) -> tuple[_Choice, dict[Path, Compiled]]:
        """Compile the sources of the checkout, each in the best way that works."""
        recipe = self.recipe
        paths = [*recipe.sources, *recipe.extras]
        choice = _Choice({path for path in paths if path in recipe.vehicle_mode}, set(recipe.extras))
        units = [Unit(path, self._vehicle if path in choice.vehicle_mode else self._host) for path in paths]
        compiled = dict(zip(paths, self._compile("compiling", units, must=False), strict=True))
        again = sorted(path for path in choice.vehicle_mode if not compiled[path].ok)
        plain = self._compile_plain(again)
        for path in again:
            choice.vehicle_mode.discard(path)
            if plain[path].ok:
                compiled[path] = plain[path]
                self.notes.append(f"{self._relative(path)} does not compile as for the vehicle, taken as for the host")
        demand_all([compiled[path] for path in recipe.sources])
        for path in recipe.extras:
            if not compiled[path].ok:
                choice.extras.discard(path)
                self.notes.append(f"{self._relative(path)} does not compile, left out")
                del compiled[path]
        return choice, compiled

    def _compile_plain(self, paths: Sequence[Path]) -> dict[Path, Compiled]:
        units = [Unit(path, self._host) for path in paths]
        return dict(zip(paths, self._compile("compiling", units, must=False), strict=True))

    def _retreat(
        self,
        undefined: Sequence[linking.Undefined],
        choice: _Choice,
        compiled: dict[Path, Compiled],
    ) -> dict[Path, Compiled]:
        """Give up what leaves symbols undefined and can be done without.

        Raises:
            LinkError: If a source that is needed leaves one undefined.
        """
        optional = choice.extras | choice.vehicle_mode
        lost = [symbol for symbol in undefined if not symbol.needed_by or set(symbol.needed_by) - optional]
        if lost:
            raise LinkError(linking.explain(lost))
        needs = linking.needs_of(undefined)
        plain = sorted(needs.keys() & choice.vehicle_mode)
        choice.vehicle_mode.difference_update(plain)
        for path in plain:
            missing = ", ".join(needs[path])
            self.notes.append(f"{self._relative(path)} taken as for the host, as for the vehicle it needs {missing}")
        again = self._compile_plain(plain)
        demand_all([again[path] for path in plain if path not in choice.extras])
        left_out = sorted((needs.keys() & choice.extras) - {path for path, one in again.items() if one.ok})
        choice.extras.difference_update(left_out)
        for path in left_out:
            self.notes.append(f"{self._relative(path)} left out, it needs {', '.join(needs[path])}")
        remaining = {path: one for path, one in compiled.items() if path not in needs} | again
        return {path: one for path, one in remaining.items() if path not in left_out}

    def _compile(self, what: str, units: Sequence[Unit], must: bool = True) -> list[Compiled]:
        done = 0
        self._tell(what, 0, len(units))

        def count(_: Compiled) -> None:
            nonlocal done
            with self._lock:
                done += 1
                self._tell(what, done, len(units))

        results = self.objects.compile_all(units, count)
        for result in results:
            self.inputs |= result.inputs
            if result.output and not result.unit.syntax_only:
                self.printed.append(result.output)
        if must:
            demand_all(results)
        return results

    def _tell(self, what: str, done: int, total: int) -> None:
        if self._progress is not None:
            self._progress(what, done, total)

    def _source_flags(self, choice: _Choice) -> list[str]:
        # what the checkout's own list has of extra_sources.txt counts as well
        present = [
            source_flag("CF_WITH", path) for path in sorted({*self.recipe.sources, *choice.extras, *self.recipe.system})
        ]
        return [*present, *(source_flag("CF_VEHICLE_MODE", path) for path in sorted(choice.vehicle_mode))]

    def _level_flags(self) -> list[str]:
        if not self.recipe.system:
            return []
        return ["-DCF_SYSTEM=1", f'-DCF_SYSTEM_MODULES="{", ".join(levels.modules_of(self.recipe.level))}"']

    def _relative(self, path: Path) -> str:
        checkout = self.recipe.checkout
        return str(path.relative_to(checkout.root) if checkout and path.is_relative_to(checkout.root) else path)

    def _finish(self, path: Path, found: dict[str, bool], choice: _Choice, objects: Iterable[Compiled]) -> Library:
        """Make the image map, and put library, manifest and build log in their place at once."""
        from crazychoir_fw.firmware.image import image_map

        self._tell("linking", 1, 1)
        apps = "".join(one.output for one in objects if one.unit.source in self.recipe.apps)
        identity = self._identity(found, choice, apps)
        ranges, pointers = image_map(path)
        library = Library(path, self.recipe.name, self.recipe.platform, ranges, pointers, identity)
        library.save()
        write_text(path.parent / BUILD_LOG, self._log(library))
        folder = self.cache.libraries / f"{_file_name(library)}-{identity['content'][:12]}-{secrets.token_hex(3)}"
        path.parent.replace(folder)
        return replace(library, path=folder / path.name)

    def _identity(self, found: dict[str, bool], choice: _Choice, warnings: str) -> dict[str, Any]:
        recipe = self.recipe
        sources = [*recipe.sources, *sorted(choice.extras), *recipe.system, *recipe.apps]
        return {
            "provider": recipe.name,
            "level": recipe.level,
            "modules": levels.modules_of(recipe.level) if recipe.system else [],
            **self._origin(),
            "platform": recipe.platform,
            "features": _words(found, there=True),
            "missing_features": _words(found, there=False),
            "extra_sources": [self._relative(path) for path in sorted(choice.extras)],
            "host_mode": [self._relative(path) for path in sources if self._is_only_host(path, choice)],
            "apps": [str(path) for path in recipe.apps],
            "compiler": self.compiler.version,
            "flags": shlex.join(vehicle_mode(recipe.flags) if recipe.checkout else recipe.flags),
            "sources": len(sources),
            "built_by": __version__,
            "notes": self.notes,
            "warnings": warnings,
        }

    def _origin(self) -> dict[str, Any]:
        """Return what the library is made of: checkout, version, content, and the configuration that counts in it."""
        recipe, checkout = self.recipe, self.recipe.checkout
        theirs: dict[str, str | None] = {}
        if checkout is not None:
            theirs = {path: key for path, key in self.inputs.items() if Path(path).is_relative_to(checkout.root)}
        taking_part = {self._relative(Path(path)): content for path, content in theirs.items()}
        content = digest_of(taking_part | {app.name: self.inputs[str(app)] for app in recipe.apps})
        mentioned = configuration.symbols_in(Path(path) for path in theirs)
        return {
            "version": __version__ if checkout is None else checkout.version() or content,
            "content": content,
            "checkout": None if checkout is None else str(checkout.root),
            "configuration": {name: recipe.settings.get(name) for name in sorted(mentioned | recipe.settings.keys())},
        }

    def _is_only_host(self, path: Path, choice: _Choice) -> bool:
        """Return whether a source of the firmware itself is compiled as for the host."""
        vendor = self.recipe.checkout is not None and path.is_relative_to(self.recipe.checkout.root / VENDOR)
        as_flown = {*choice.vehicle_mode, *self.recipe.apps, *self.recipe.system}
        return path not in as_flown and not vendor

    def _log(self, library: Library) -> str:
        """Return how the library was made, for people."""
        facts = [f"{key}: {value}" for key, value in library.identity.items() if key not in ("notes", "configuration")]
        used_values = [f"  {name} = {value}" for name, value in library.identity["configuration"].items()]
        notes = [f"  {note}" for note in self.notes]
        commands = ["commands:", *(f"  {line}" for line in self.objects.commands)]
        return "\n".join([*facts, "configuration:", *used_values, "notes:", *notes, *commands, *self.printed]) + "\n"


def _words(found: dict[str, bool], there: bool) -> list[str]:
    return sorted(name.removeprefix("HAVE_").lower() for name, is_there in found.items() if is_there is there)


def _file_name(library: Library) -> str:
    return _safe("-".join(filter(None, [library.name, library.platform])))


def _safe(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9_+.-]", "_", name)
