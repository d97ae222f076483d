"""Everything that a build depends on, as plain data: which files, which flags, which generated headers.

A recipe is made by looking, before anything is compiled. Equal recipes and equal files give equal libraries.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from crazychoir_fw.common.errors import UnknownNameError
from crazychoir_fw.firmware import configuration, levels
from crazychoir_fw.firmware.checkout import SETUP, Checkout
from crazychoir_fw.firmware.checkout_files import files_of, is_inside
from crazychoir_fw.firmware.own_sources import bindings_folder, deciding_flags, read_list
from crazychoir_fw.firmware.setup_lists import SetupLists, read_setup_lists

VEHICLE_MODE = "-DCRAZYFLIE_FW"
HOST_MODE = "-DUNIT_TEST_MODE"
FORCED = "forced.h"
BUILTIN_ADAPTER = Path("library", "builtin_adapter.c")
# our sources of a library that are compiled with the headers that declare what they define
_WITH_THEIR_HEADERS = ("variables_of_drone.c",)
_FACTS = ("platform.c", "status.c")  # what our own provider needs from outside of builtin/
APP_WARNINGS = ("-Wall", "-Wextra", "-Wformat")

# the debug information tells which words are pointers; every variable must be in a section of its own object, and
# nothing but the entry is seen from outside
_LIBRARY_FLAGS = (
    "-std=gnu11",
    "-g",
    "-gdwarf-4",
    "-fPIC",
    "-fno-common",
    "-fvisibility=hidden",
    "-fno-stack-protector",
)

# what is right for the vehicle, where uint32_t is a long, and for its compiler: no warnings about these
_QUIET = ("-Wno-unknown-warning-option", "-Wno-format", "-Wno-c2x-extensions")

# flags of a checkout that say how C is compiled; others could make the compiler write files or run programs
_HARMLESS = re.compile(
    r"-([DU][A-Za-z_].*|O[0-3sgz]?|std=[a-z0-9:]+|f[a-z0-9-]+|f(fp-contract|excess-precision)=[a-z]+"
    r"|m(?!llvm)[a-z0-9=.,+-]+|W[a-z0-9=-]*)",
    re.DOTALL,
)
_HARMFUL = re.compile(r"-f(no-)?.*(plugin|profile|dump|coverage|lto|save|usage|info|trace|record|syntax|modules)")

_BUILTIN_PLATFORMS = ("cf2", "cf21bl")

# functions of the firmware whose callers come to ours first: everything that their loop decides passes by there
# (system/loop.c), and what is taken from the estimator's queue (system/sweeps.c)
_WATCHED = ("controller", "supervisorStateUpdate", "estimatorDequeue")

# word in an app's source that shows that it brings a part of the firmware, and the symbol that says so
_OUT_OF_TREE = {
    "CONFIG_CONTROLLER_OOT": re.compile(r"\bcontrollerOutOfTree\s*\("),
    "CONFIG_ESTIMATOR_OOT": re.compile(r"\bestimatorOutOfTree\s*\("),
}


# an app with a task of its own
_APP_MAIN = re.compile(r"\bappMain\s*\(")
_APP_TASK = {"CONFIG_APP_ENABLE": "1", "CONFIG_APP_STACKSIZE": "300", "CONFIG_APP_PRIORITY": "0"}


@dataclass(frozen=True)
class Recipe:
    """What is compiled, and how."""

    name: str
    platform: str | None
    """None: every one."""
    checkout: Checkout | None
    sources: tuple[Path, ...]
    """Sources that must compile."""
    extras: tuple[Path, ...]
    """Sources of the checkout beyond its own list, left out if they do not compile."""
    vehicle_mode: frozenset[Path]
    """Sources and extras that are first tried as they are compiled for the vehicle, see `vehicle_flags`."""
    adapter: tuple[Path, ...]
    """Our sources that see the checkout's headers, and what the probes found."""
    own: tuple[Path, ...]
    """Our sources that do not."""
    apps: tuple[Path, ...]
    probes: tuple[Path, ...]
    first_include_dirs: tuple[Path, ...]
    """Our folders of headers that come before those of the checkout, without the generated one."""
    include_dirs: tuple[Path, ...]
    """Folders of headers for `sources`, `extras`, `adapter`, `apps` and `probes`."""
    flags: tuple[str, ...]
    """Flags for everything."""
    app_flags: tuple[str, ...]
    own_include_dirs: tuple[Path, ...]
    generated: Mapping[str, str]
    """Headers that are made for this build: name to text."""
    settings: Mapping[str, str]
    """Symbols of the configuration header."""
    notes: tuple[str, ...]
    level: str = levels.ALGORITHMS
    """How much of a checkout flies, see levels.py."""
    system: tuple[Path, ...] = ()
    """Sources of the checkout that the level brings. They must compile as for the vehicle."""
    linking: tuple[str, ...] = ()
    """Words for the linker."""

    def key(self) -> dict[str, object]:
        """Return the recipe as plain data, for the name under which the library is kept."""
        plain = {name: value for name, value in vars(self).items() if name not in ("checkout", "notes")}
        plain["vehicle_mode"] = sorted(self.vehicle_mode)
        plain["scenery"] = self.header_names()
        return plain

    def header_names(self) -> list[str]:
        """Return the names of all headers that may be included: a new one may take the place of another."""
        return header_names([*self.first_include_dirs, *self.include_dirs, *self.own_include_dirs])

    def host_flags(self, generated: Path) -> tuple[str, ...]:
        """Return the flags for sources of the checkout as its own bindings compile them, with folders of headers.

        Warnings that headers of the checkout cause are left out: editing one file shall not show those of all others.

        Args:
            generated: Folder of the headers that were made for this build.
        """
        ours = (*self.first_include_dirs, generated)
        folders = [*(f"-I{path}" for path in ours), *(f"-isystem{path}" for path in self.include_dirs)]
        return (*self.flags, *folders, "-include", str(generated / FORCED))

    def vehicle_flags(self, generated: Path) -> tuple[str, ...]:
        """Return the flags for sources of the checkout as they are compiled for the vehicle."""
        return vehicle_mode(self.host_flags(generated))


def vehicle_mode(flags: Sequence[str]) -> tuple[str, ...]:
    """Return flags of a host build as those of the vehicle."""
    return (*(flag for flag in flags if flag != HOST_MODE), VEHICLE_MODE)


def bitcraze_recipe(
    checkout: Checkout,
    platform: str,
    apps: Sequence[Path] = (),
    configured: Path | None = None,
    level: str = levels.ALGORITHMS,
) -> Recipe:
    """Return how a checkout, and perhaps apps, become a library.

    Args:
        checkout: The checkout.
        platform: One of `configuration.PLATFORMS`.
        apps: C files of the user.
        configured: Configuration header to use instead of ours.
        level: One of `levels.LEVELS`.

    Raises:
        CheckoutError: If files are missing.
        UnknownNameError: If there is no such platform or app.
    """
    root, bindings = checkout.root, bindings_folder()
    apps = _existing_apps(apps)
    lists = read_setup_lists(root / SETUP)
    notes = list(lists.notes)
    switched_on = [symbol for symbol, pattern in _OUT_OF_TREE.items() if _mention(pattern, apps)]
    if configured is None:
        settings = configuration.settings(root, platform, switched_on)
    else:
        settings = configuration.read_header(configured, platform, switched_on)
        notes.append(f"configuration header {configured} is used")
    settings.pop("CONFIG_APP_ENABLE", None)
    if level != levels.ALGORITHMS and _mention(_APP_MAIN, apps):
        settings |= _APP_TASK
    folder = bindings / "bitcraze"
    files = files_of(root, lists, settings, level, notes)
    return Recipe(
        name=_library_name(levels.word_of(level), apps),
        platform=platform,
        checkout=checkout,
        sources=files.sources,
        extras=files.extras,
        vehicle_mode=files.vehicle_mode,
        adapter=(
            *_ours(folder / "adapter_sources.txt"),
            *(_ours(folder / "system" / "adapter_sources.txt") if files.system else ()),
            *_library_sources(with_their_headers=True),
        ),
        own=(*_ours(folder / "own_sources.txt"), *_library_sources()),
        apps=apps,
        probes=(
            *sorted((folder / "probes").glob("HAVE_*.c")),
            *(sorted((folder / "system" / "probes").glob("HAVE_*.c")) if files.system else ()),
        ),
        level=level,
        system=files.system,
        linking=tuple(f"-Wl,--wrap={function}" for function in _WATCHED) if files.system else (),
        first_include_dirs=(bindings / "library" / "include", folder / "shadow", folder / "freertos"),
        include_dirs=files.include_dirs,
        flags=tuple(_flags(lists, root, notes)),
        app_flags=APP_WARNINGS,
        own_include_dirs=(bindings,),
        generated={
            configuration.FILE_NAME: configuration.header_text(settings),
            FORCED: FORCED_HEADER,
        },
        settings=settings,
        notes=tuple(notes),
    )


def builtin_recipe(platform: str, apps: Sequence[Path]) -> Recipe:
    """Return how our own provider and a user's apps become a library.

    Our provider flies every airframe, but for apps mass and thrust of their airframe are constants of the compiler, as
    in the firmware.

    Raises:
        UnknownNameError: If there is no such platform, or a file of the apps is missing.
    """
    if platform not in _BUILTIN_PLATFORMS:
        raise UnknownNameError(f"no platform named {platform!r}, allowed: {', '.join(_BUILTIN_PLATFORMS)}")
    bindings = bindings_folder()
    apps = _existing_apps(apps)
    settings = {symbol: "1" for symbol, pattern in _OUT_OF_TREE.items() if _mention(pattern, apps)}
    settings[configuration.PLATFORM_PREFIX + platform.upper()] = "1"
    listed = [name.removeprefix("bindings/") for name in read_list(bindings / "sources.txt")]
    builtin = [bindings / name for name in listed if name.startswith("builtin/") or name in _FACTS]
    return Recipe(
        name=_library_name("builtin", apps),
        platform=platform,
        checkout=None,
        sources=(),
        extras=(),
        vehicle_mode=frozenset(),
        adapter=_library_sources(with_their_headers=True),
        own=(*builtin, *sorted((bindings / "app").glob("*.c")), bindings / BUILTIN_ADAPTER, *_library_sources()),
        apps=apps,
        probes=(),
        first_include_dirs=(bindings / "library" / "include",),
        include_dirs=(bindings / "app" / "include", bindings),
        flags=(*deciding_flags(), *_LIBRARY_FLAGS),
        app_flags=APP_WARNINGS,
        own_include_dirs=(bindings,),
        generated={
            configuration.FILE_NAME: configuration.header_text(settings),
            FORCED: FORCED_HEADER,
        },
        settings=settings,
        notes=(),
    )


def header_names(folders: Iterable[Path]) -> list[str]:
    """Return the names of all headers in and below folders: a new one may take the place of another."""
    names: list[str] = []
    for folder in sorted(set(folders)):
        for place, _, files in os.walk(folder):
            names.extend(f"{place}/{name}" for name in files if name.endswith(".h"))
    return sorted(set(names))


def _flags(lists: SetupLists, root: Path, notes: list[str]) -> list[str]:
    """Return the flags of the checkout, with ours where they decide the bits or the form of the library.

    The checkout chooses how much is optimized. Contraction, and what the compiler may fold, are chosen as for our own
    provider, so that the two can be compared bit by bit.
    """
    theirs = []
    for flag in lists.flags:
        if flag.startswith("-I") and len(flag) > 2 and is_inside(root, root / flag[2:]):
            theirs.append(f"-I{root / flag[2:]}")
        elif _HARMLESS.fullmatch(flag) and not _HARMFUL.match(flag):
            theirs.append(flag)
        else:
            notes.append(f"flag {flag} left out")
    ours = deciding_flags()
    optimization = [flag for flag in ours if flag.startswith("-O")]
    return [*optimization, *theirs, *(flag for flag in ours if flag not in optimization), *_LIBRARY_FLAGS, *_QUIET]


_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)

# The headers that declare parameters and log variables are the checkout's own, found by their names, in the form that
# they have on the vehicle; afterwards only the macros that make rows of tables are exchanged (tables.h). So neither the
# order of includes, nor the form of a guard, nor a type or prototype of a release can be in the way.
FORCED_HEADER = """\
// Comes before every source; made by crazychoir, changes are lost.
#include "prologue.h"
#include "autoconf.h"
#pragma push_macro("UNIT_TEST_MODE")
#undef UNIT_TEST_MODE
#include "log.h"
#include "param.h"
#pragma pop_macro("UNIT_TEST_MODE")
#include "tables.h"
"""


def _code(path: Path) -> str:
    """Return a source without its comments."""
    return _COMMENT.sub(" ", path.read_text(encoding="utf-8", errors="replace"))


def _library_sources(with_their_headers: bool = False) -> tuple[Path, ...]:
    """Return our sources that every library has: its entry, the image, the guard, the captured variables."""
    sources = sorted((bindings_folder() / "library").glob("*.c"))
    every = [path for path in sources if path.name != BUILTIN_ADAPTER.name]
    return tuple(path for path in every if (path.name in _WITH_THEIR_HEADERS) == with_their_headers)


def _ours(listing: Path) -> tuple[Path, ...]:
    """Return the files of a list of ours; they count from bindings/."""
    return tuple(bindings_folder() / name.removeprefix("bindings/") for name in read_list(listing))


def _existing_apps(apps: Sequence[Path]) -> tuple[Path, ...]:
    absolute = tuple(Path(path).expanduser().absolute() for path in apps)
    for path in absolute:
        if not path.is_file():
            raise UnknownNameError(f"there is no app file {path}")
    return absolute


def _mention(pattern: re.Pattern[str], paths: Iterable[Path]) -> bool:
    return any(pattern.search(_code(path)) for path in paths)


def _library_name(provider: str, apps: Sequence[Path]) -> str:
    return "+".join([provider, *(re.sub(r"\W", "_", path.stem) for path in apps)])
