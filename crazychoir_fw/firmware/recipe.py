"""Everything that a build depends on, as plain data: which files, which flags, which generated headers.

A recipe is made by looking, before anything is compiled. Equal recipes and equal files give equal libraries.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from crazychoir_fw.errors import CheckoutError, UnknownNameError
from crazychoir_fw.firmware import configuration
from crazychoir_fw.firmware.checkout import CMSIS, SETUP, Checkout
from crazychoir_fw.firmware.fallback_lists import GENERATED
from crazychoir_fw.firmware.own_sources import bindings_folder, deciding_flags, read_list
from crazychoir_fw.firmware.setup_lists import SetupLists, read_setup_lists

FIRMWARE_MODE = "-DCRAZYFLIE_FW"
FORCED = "forced.h"
BUILTIN_ADAPTER = Path("library", "builtin_adapter.c")
_FACTS = ("platform.c", "status.c")  # what our own provider needs from outside of builtin/
APP_WARNINGS = ("-Wall", "-Wextra")

# the debug information tells which words are pointers; every variable must be in a section of its own object, and
# nothing but the entry is seen from outside
_LIBRARY_FLAGS = ("-std=gnu11", "-g", "-gdwarf-4", "-fPIC", "-fno-common", "-fvisibility=hidden")

# flags of a checkout that say how C is compiled; others could make the compiler write files or run programs
_HARMLESS = re.compile(
    r"-([DU][A-Za-z_].*|O[0-3sgz]?|std=[a-z0-9:]+|f[a-z0-9-]+|f(fp-contract|excess-precision)=[a-z]+"
    r"|m(?!llvm)[a-z0-9=.,+-]+|W[a-z0-9=-]*)",
    re.DOTALL,
)
_HARMFUL = re.compile(r"-f(no-)?.*(plugin|profile|dump|coverage|lto|save|usage|info|trace|record|syntax|modules)")

_BUILTIN_PLATFORMS = ("cf2", "cf21bl")

# folders of headers that the vehicle's build gives to apps, and the list of the bindings does not have
_APP_INCLUDES = ("src/modules/interface/estimator",)

# word in an app's source that shows that it brings a part of the firmware, and the symbol that says so
_OUT_OF_TREE = {
    "CONFIG_CONTROLLER_OOT": re.compile(r"\bcontrollerOutOfTree\s*\("),
    "CONFIG_ESTIMATOR_OOT": re.compile(r"\bestimatorOutOfTree\s*\("),
}


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
    firmware_mode: frozenset[Path]
    """Sources and extras that are first tried as they are compiled for the vehicle."""
    adapter: tuple[Path, ...]
    """Our sources that see the checkout's headers, and what the probes found."""
    own: tuple[Path, ...]
    """Our sources that do not."""
    apps: tuple[Path, ...]
    probes: tuple[Path, ...]
    include_dirs: tuple[Path, ...]
    """Folders of headers for `sources`, `extras`, `adapter`, `apps` and `probes`, without the generated one."""
    flags: tuple[str, ...]
    """Flags for everything."""
    app_flags: tuple[str, ...]
    own_include_dirs: tuple[Path, ...]
    generated: Mapping[str, str]
    """Headers that are made for this build: name to text."""
    settings: Mapping[str, str]
    """Symbols of the configuration header."""
    notes: tuple[str, ...]

    def key(self) -> dict[str, object]:
        """Return the recipe as plain data, for the name under which the library is kept."""
        plain = {name: value for name, value in vars(self).items() if name not in ("checkout", "notes")}
        plain["firmware_mode"] = sorted(self.firmware_mode)
        plain["scenery"] = header_names([*self.include_dirs, *self.own_include_dirs])
        return plain


def bitcraze_recipe(
    checkout: Checkout, platform: str, apps: Sequence[Path] = (), configured: Path | None = None
) -> Recipe:
    """Return how a checkout, and perhaps apps, become a library.

    Args:
        checkout: The checkout.
        platform: One of `configuration.PLATFORMS`.
        apps: C files of the user.
        configured: Configuration header to use instead of ours.

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
    folder = bindings / "bitcraze"
    sources = _sources(root, lists, notes)
    extras = [root / name for name in read_list(folder / "extra_sources.txt")]
    extras = [path for path in extras if path.is_file() and path not in sources]
    include_dirs = [
        bindings / "library" / "include",
        *(root / name for name in lists.include_dirs if not _is_generated(name)),
        *(path for path in [folder / "include"] if path.is_dir()),
    ]
    return Recipe(
        name=_library_name("bitcraze", apps),
        platform=platform,
        checkout=checkout,
        sources=tuple(sources),
        extras=tuple(extras),
        firmware_mode=frozenset(root / name for name in read_list(folder / "firmware_mode.txt")),
        adapter=_ours(folder / "adapter_sources.txt"),
        own=(*_ours(folder / "own_sources.txt"), *_library_sources()),
        apps=apps,
        probes=tuple(sorted((folder / "probes").glob("HAVE_*.c"))),
        include_dirs=tuple(include_dirs),
        flags=tuple(_flags(lists, root, notes)),
        app_flags=(*APP_WARNINGS, *(f"-I{root / name}" for name in _APP_INCLUDES if (root / name).is_dir())),
        own_include_dirs=(bindings,),
        generated={
            configuration.FILE_NAME: configuration.header_text(settings),
            FORCED: _forced_header(include_dirs[1:]),
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
        firmware_mode=frozenset(),
        adapter=(),
        own=(*builtin, *sorted((bindings / "app").glob("*.c")), bindings / BUILTIN_ADAPTER, *_library_sources()),
        apps=apps,
        probes=(),
        include_dirs=(bindings / "library" / "include", bindings / "app" / "include", bindings),
        flags=(*deciding_flags(), *_LIBRARY_FLAGS),
        app_flags=APP_WARNINGS,
        own_include_dirs=(bindings,),
        generated={
            configuration.FILE_NAME: configuration.header_text(settings),
            FORCED: _forced_header([]),
        },
        settings=settings,
        notes=(),
    )


def header_names(folders: Iterable[Path]) -> list[str]:
    """Return the names of all headers in and below folders: a new one may take the place of another."""
    names = []
    for folder in sorted(set(folders)):
        for place, _, files in os.walk(folder):
            names.extend(f"{place}/{name}" for name in files if name.endswith(".h"))
    return sorted(set(names))


def _sources(root: Path, lists: SetupLists, notes: list[str]) -> list[Path]:
    """Return the sources that the lists name, all of which exist."""
    listed = list(dict.fromkeys(root / name for name in lists.sources))
    missing = [path for path in listed if not path.is_file()]
    if not missing:
        return listed
    if len(lists.notes) == 1 and "newest known release" in lists.notes[0]:
        notes.append(f"left out, because this checkout has them not: {', '.join(path.name for path in missing)}")
        return [path for path in listed if path.is_file()]
    first, quoted = os.path.relpath(missing[0], root), shlex.quote(str(root))
    more = f" and {len(missing) - 1} more" if len(missing) > 1 else ""
    if all(path.is_relative_to(root / CMSIS) for path in missing):
        raise CheckoutError(
            f"{first}{more} is missing in {root}: run `git -C {quoted} submodule update --init --force {CMSIS}`"
        )
    raise CheckoutError(f"{SETUP} of {root} names {first}{more}, which is missing: run `git -C {quoted} status`")


def _is_generated(name: str) -> bool:
    return os.path.normpath(name) == os.path.normpath(GENERATED)


def _flags(lists: SetupLists, root: Path, notes: list[str]) -> list[str]:
    """Return the flags of the checkout, with ours where they decide the bits or the form of the library.

    The checkout chooses how much is optimized. Contraction, and what the compiler may fold, are chosen as for our own
    provider, so that the two can be compared bit by bit.
    """
    theirs = []
    for flag in lists.flags:
        if flag.startswith("-I") and len(flag) > 2:
            theirs.append(f"-I{root / flag[2:]}")
        elif _HARMLESS.fullmatch(flag) and not _HARMFUL.match(flag):
            theirs.append(flag)
        else:
            notes.append(f"flag {flag} left out")
    ours = deciding_flags()
    optimization = [flag for flag in ours if flag.startswith("-O")]
    return [*optimization, *theirs, *(flag for flag in ours if flag not in optimization), *_LIBRARY_FLAGS]


_GUARD = re.compile(r"^[ \t]*#[ \t]*ifndef[ \t]+(\w+)[^\n]*\n\s*#[ \t]*define[ \t]+\1\b", re.MULTILINE)
_ONCE = re.compile(r"^[ \t]*#[ \t]*pragma[ \t]+once\b", re.MULTILINE)
_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
_MACRO = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(\w+)", re.MULTILINE)
_NAME = re.compile(r"\b(?:log|param)[A-Z]\w*")


def _forced_header(include_dirs: Sequence[Path]) -> str:
    """Return the header that comes before every source: our PARAM_* and LOG_*, and the checkout's kept out.

    A header beside log.h finds the checkout's own, whatever the order of folders. Its guard makes it empty.
    """
    before, after = [], []
    for path in (folder / name for name in ("log.h", "param.h") for folder in include_dirs):
        if guard := include_guard(path):
            after += [f"#ifndef {guard}", f"#define {guard}", "#endif"]
        elif path.is_file() and _ONCE.search(_code(path)):
            before += _read_once(path)
    ours = ['#include "prologue.h"', '#include "log.h"', '#include "param.h"']
    return "\n".join(
        ["// Comes before every source; made by crazychoir, changes are lost.", *before, *ours, *after, ""]
    )


def _read_once(path: Path) -> list[str]:
    """Return lines that read a header without a guard under other names, after which it is never read again."""
    folder = bindings_folder() / "library" / "include"
    names = sorted(set(_NAME.findall(_code(folder / "log.h") + _code(folder / "param.h"))))
    forgotten = [*names, *sorted(set(_MACRO.findall(_code(path))))]
    return [
        *(f"#define {name} cf_their_{name}" for name in names),
        f'#include "{path}"',
        *(f"#undef {name}" for name in forgotten),
    ]


def _code(path: Path) -> str:
    """Return a source without its comments."""
    return _COMMENT.sub(" ", path.read_text(encoding="utf-8", errors="replace"))


def include_guard(path: Path) -> str | None:
    """Return the macro that keeps a header from being read twice; None without header or macro."""
    if not path.is_file():
        return None
    found = _GUARD.search(_code(path))
    return found[1] if found else None


def _library_sources() -> tuple[Path, ...]:
    """Return our sources that every library has: its entry, the image, the guard, the captured variables."""
    folder = bindings_folder() / "library"
    return tuple(path for path in sorted(folder.glob("*.c")) if path.name != BUILTIN_ADAPTER.name)


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
