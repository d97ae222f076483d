"""A user's own C: which files, what they bring, and the library that carries them."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from crazychoir_fw.common.errors import BuildError, RangeError
from crazychoir_fw.firmware.levels import ALGORITHMS, BITCRAZE, level_of

if TYPE_CHECKING:
    from crazychoir_fw.firmware.library import Library

OUT_OF_TREE = "out_of_tree"
"""The word for a controller or an estimator that an app brings."""

BUILTIN = "builtin"

HOOKS = {
    "controller": ("controllerOutOfTreeInit", "controllerOutOfTreeTest", "controllerOutOfTree"),
    "estimator": ("estimatorOutOfTreeInit", "estimatorOutOfTreeTest", "estimatorOutOfTree"),
}
"""The firmware's functions for code that is not in its tree: all three, or none."""


TASK = "appMain"
"""The function that runs as the app's own task, where a checkout's modules fly."""

_GROUP = re.compile(r"^[ \t]*(?:PARAM|LOG)_GROUP_START\s*\(\s*(\w+)", re.MULTILINE)


@dataclass(frozen=True)
class App:
    """Files that were built together, and what is in them."""

    files: tuple[Path, ...]
    library: Library
    """What carries them; `name` is the word of the provider."""
    hooks: tuple[str, ...]
    """What they bring: ``controller``, ``estimator`` or both."""
    state_bytes: int
    """Size of their variables, which every drone has of its own."""

    @property
    def groups(self) -> set[str]:
        """Groups of parameters and log variables that they open."""
        texts = (path.read_text(encoding="utf-8", errors="replace") for path in self.files)
        return {group for text in texts for group in _GROUP.findall(text)}

    @property
    def warnings(self) -> str:
        """What the compiler had to say about them."""
        return str(self.library.identity.get("warnings", ""))


def app_files(files: str | Path | Sequence[str | Path]) -> tuple[Path, ...]:
    """Return the files of an app as absolute paths.

    Raises:
        BuildError: If one is missing or is no C source.
    """
    paths = [files] if isinstance(files, str | Path) else list(files)
    found = []
    for path in (Path(path).expanduser() for path in paths):
        if path.suffix != ".c":
            raise BuildError(f"{path} is no C source: the name of an app ends with .c, headers beside it are found")
        if not path.is_file():
            raise BuildError(f"{path} does not exist")
        found.append(path.absolute())
    return tuple(dict.fromkeys(found))


def build_app(
    files: str | Path | Sequence[str | Path],
    platform: str = "cf2",
    provider: str = "builtin",
    checkout: Path | str | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> App:
    """Compile C files into a library that drones can carry; from the cache when nothing changed.

    Args:
        files: One C file, or several that belong together.
        platform: Airframe, such as ``cf2``.
        provider: What is around them: ``builtin`` or ``bitcraze``, perhaps with a level.
        checkout: Folder of the firmware's checkout for ``bitcraze``; by default see `checkout.locate`.
        progress: Told what is at work, how many files are done, and of how many.

    Raises:
        BuildError: If files are missing or do not compile, functions are missing, or there is no compiler.
        CheckoutError: If there is no usable checkout.
        RangeError: If there is no such provider.
    """
    from crazychoir_fw.firmware.build import build_provider
    from crazychoir_fw.firmware.checkout import locate

    paths = app_files(files)
    if not paths:
        raise BuildError("an app has at least one C file")
    level = level_of(provider)
    if level is None and provider != BUILTIN:
        raise RangeError(f"provider is '{provider}', allowed around an app: {BUILTIN}, {BITCRAZE}")
    root = locate(checkout) if level is not None else None
    library = build_provider(root, platform, paths, level=level or ALGORITHMS, progress=progress)
    functions, state_bytes = _contents(library, paths)
    runs_tasks = bool(library.identity.get("modules"))
    return App(paths, library, _hooks(functions, paths, runs_tasks), state_bytes)


class Configured(Protocol):
    """What `carry` wants to know of a drone."""

    id: str
    platform: str
    provider: str
    controller: str | None
    estimator: str | None
    app: Any


Configuration = TypeVar("Configuration", bound=Configured)


def carry(drones: Sequence[Configuration]) -> list[Configuration]:
    """Build and load what drones carry, and return them with provider, controller and estimator decided.

    Raises:
        BuildError: If an app does not build.
        CheckoutError: If there is no usable checkout.
        RangeError: If a drone asks for what its app does not bring, or two apps have one name.
    """
    from crazychoir_fw.onboard import core

    apps: dict[tuple[tuple[Path, ...], str, str], App] = {}
    files_of: dict[str, tuple[Path, ...]] = {}
    carrying = []
    for drone in drones:
        files = app_files(drone.app)
        if not files:
            carrying.append(drone)
            continue
        key = (files, drone.provider, drone.platform)
        if key not in apps:
            apps[key] = build_app(files, drone.platform, drone.provider)
            core.load_library(apps[key].library)
        app = apps[key]
        name = app.library.name
        if files_of.setdefault(name, files) != files:
            raise RangeError(
                f"{drone.id}: {files[0]} and {files_of[name][0]} have one name, but reports must tell apps apart: "
                "rename one of them"
            )
        carrying.append(_with_app(drone, app))
    return carrying


def _with_app(drone: Configuration, app: App) -> Configuration:
    """Return a drone that carries an app, flown by what the app brings unless it says otherwise."""
    chosen = {"provider": app.library.name}
    for kind, (*_, function) in HOOKS.items():
        word = getattr(drone, kind)
        if word == OUT_OF_TREE and kind not in app.hooks:
            names = ", ".join(path.name for path in app.files)
            raise RangeError(f"{drone.id}: {kind} is '{OUT_OF_TREE}', but {names} has no {function}")
        if word is None and kind in app.hooks:
            chosen[kind] = OUT_OF_TREE
    return replace(drone, **chosen)


def _hooks(functions: set[str], files: Sequence[Path], runs_tasks: bool = False) -> tuple[str, ...]:
    """Return what the functions of an app make it.

    Args:
        functions: Names of all functions of its library.
        files: The files of the app.
        runs_tasks: Whether a task of the app runs (appMain), so that an app may bring nothing else.

    Raises:
        BuildError: If there is nothing that a drone would call, or a part of it is missing.
    """
    names = ", ".join(path.name for path in files)
    found = []
    for kind, expected in HOOKS.items():
        missing = [name for name in expected if name not in functions]
        if not missing:
            found.append(kind)
        elif len(missing) < len(expected):
            there = next(name for name in expected if name in functions)
            raise BuildError(f"{names} defines {there}, but not {' and '.join(missing)}: the firmware calls all three")
    if not found and not (runs_tasks and TASK in functions):
        lists = ", or ".join(f"{', '.join(expected)} (a {kind})" for kind, expected in HOOKS.items())
        raise BuildError(f"{names} has nothing that a drone would call: define {lists.replace('a e', 'an e')}")
    return tuple(found)


def _functions(elf: Any) -> set[str]:
    """Return the names of all functions in a library.

    They are those of the symbol table: of two functions with the same code the compiler keeps one, and says of the
    other in no other place that it is there.
    """
    table = elf.get_section_by_name(".symtab")
    symbols = table.iter_symbols() if table is not None else ()
    defined = (one for one in symbols if one["st_info"]["type"] == "STT_FUNC" and one["st_shndx"] != "SHN_UNDEF")
    return {symbol.name for symbol in defined}


def _contents(library: Library, files: Sequence[Path]) -> tuple[set[str], int]:
    """Return the functions of a library that files make, and the size of the files' variables (bytes)."""
    from elftools.elf.elffile import ELFFile

    from crazychoir_fw.firmware.image import address_of_variable, bytes_of_unit, size_of_variable

    variables = {}
    with library.path.open("rb") as file:
        elf = ELFFile(file)
        functions = _functions(elf)
        begin = min(segment["p_vaddr"] for segment in elf.iter_segments("PT_LOAD"))
        dwarf = elf.get_dwarf_info()
        names = _where_named(dwarf, files)
        for unit in dwarf.iter_CUs():
            # the first look is quick, and sorts out nearly all
            data = bytes_of_unit(dwarf, unit)
            if (names and not any(name in data for name in names)) or _source_of(unit) not in files:
                continue
            for die in unit.iter_DIEs():
                if die.tag == "DW_TAG_variable" and (address := address_of_variable(die)) is not None:
                    variables[address - begin] = size_of_variable(die)
    # constants lie elsewhere
    ranges = [(start, start + size) for start, size in library.ranges]
    own = [size for at, size in variables.items() if any(first <= at < last for first, last in ranges)]
    return functions, sum(own)


def _where_named(dwarf: Any, files: Sequence[Path]) -> list[bytes]:
    """Return how the debug information of a file mentions its name, among other things; empty if that is not known."""
    section = dwarf.debug_str_sec
    if section is None:
        return []
    section.stream.seek(0)
    strings = section.stream.read()
    found = [match.start() for path in files for match in re.finditer(re.escape(str(path).encode()) + b"\0", strings)]
    return [place.to_bytes(4, "little") for place in found] if len(found) >= len(files) else []


def _source_of(unit: Any) -> Path:
    """Return the file that was compiled to a unit of the debug information."""
    attributes = unit.get_top_DIE().attributes
    words = [attributes[key].value.decode() for key in ("DW_AT_comp_dir", "DW_AT_name") if key in attributes]
    return Path(*words)
