"""Which files of a checkout take part in a build: its own list, what a drone needs beyond, and folders of headers."""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from crazychoir_fw.common.errors import CheckoutError
from crazychoir_fw.firmware import levels
from crazychoir_fw.firmware.checkout import CMSIS, MODULES, SETUP, VENDOR
from crazychoir_fw.firmware.fallback_lists import GENERATED
from crazychoir_fw.firmware.own_sources import bindings_folder, read_list
from crazychoir_fw.firmware.setup_lists import SetupLists

ALSO = "CRAZYFLIE_FIRMWARE_ALSO"
"""Environment variable with folders outside of a checkout, from which its build may take sources and headers."""

# folders of headers of the vehicle's build that the list of the bindings lacks, or may lack
_MORE_INCLUDES = (
    "src/modules/interface",
    "src/modules/interface/estimator",
    "src/modules/interface/lighthouse",
    "src/deck/interface",
    "src/utils/interface/tdoa",
    "src/utils/interface/kve",
)


@dataclass(frozen=True)
class CheckoutFiles:
    """Files and folders of a checkout; see the members of `recipe.Recipe` with these names."""

    sources: tuple[Path, ...]
    extras: tuple[Path, ...]
    system: tuple[Path, ...]
    vehicle_mode: frozenset[Path]
    include_dirs: tuple[Path, ...]


def files_of(root: Path, lists: SetupLists, settings: Mapping[str, str], level: str, notes: list[str]) -> CheckoutFiles:
    """Return the files that take part at a level.

    Args:
        root: The checkout.
        lists: What its bindings/setup.py says.
        settings: Symbols of the configuration.
        level: One of `levels.LEVELS`.
        notes: What is left out is added here.

    Raises:
        CheckoutError: If a file that is needed is missing.
    """
    system = _system(root, level, settings)
    sources = [path for path in _sources(root, lists, notes) if path not in system]
    _refuse_outside(root, (*sources, *system))
    extras = _extras(root, bindings_folder() / "bitcraze" / "extra_sources.txt", settings)
    extras = [path for path in extras if path not in sources and path not in system and is_inside(root, path)]
    # the vendor's code knows neither mode; the vehicle's half of this one asks modules that are not compiled
    only_host = (root / VENDOR, root / MODULES / "collision_avoidance.c")
    listed = [name for name in lists.include_dirs if not _is_generated(name)]
    folders = [root / name for name in dict.fromkeys((*listed, *_MORE_INCLUDES))]
    return CheckoutFiles(
        sources=tuple(sources),
        extras=tuple(extras),
        system=tuple(system),
        vehicle_mode=frozenset(_without((*sources, *extras), only_host)),
        include_dirs=tuple(folder for folder in folders if folder.is_dir() and _may_include(root, folder, notes)),
    )


def _without(paths: Iterable[Path], folders: Sequence[Path]) -> Iterable[Path]:
    """Yield the paths that are in none of some folders, and none of them."""
    return (path for path in paths if not any(path.is_relative_to(one) for one in folders))


def _refuse_outside(root: Path, paths: Iterable[Path]) -> None:
    for path in paths:
        if not is_inside(root, path):
            raise CheckoutError(
                f"{os.path.relpath(path, root)} of {root} lies outside of this checkout, at {path.resolve()}: "
                f"take it out of {SETUP}, or name its folder with {ALSO} if you trust it"
            )


def is_inside(root: Path, path: Path) -> bool:
    """Tell whether a path lies in a checkout, or in a folder that the user trusts, links followed."""
    trusted = [Path(name).expanduser() for name in os.environ.get(ALSO, "").split(os.pathsep) if name]
    real = path.resolve()
    return any(real.is_relative_to(place.resolve()) for place in (root, *trusted))


def _may_include(root: Path, folder: Path, notes: list[str]) -> bool:
    if is_inside(root, folder):
        return True
    notes.append(f"headers in {folder.resolve()} left out, outside of the checkout ({ALSO} may name the folder)")
    return False


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


def _system(root: Path, level: str, settings: Mapping[str, str]) -> list[Path]:
    """Return the sources of the checkout that a level brings.

    Raises:
        CheckoutError: If the checkout lacks one.
    """
    wanted = levels.LEVELS[1 : levels.LEVELS.index(level) + 1]
    found, section = [], ""
    for line in read_list(bindings_folder() / "bitcraze" / "system_sources.txt"):
        name, question, _ = line.partition("?")
        path = root / name.strip()
        if line.startswith("["):
            section = line.strip("[]")
        elif section in wanted and path.is_file():
            found.append(path)
        elif section in wanted and not question:
            raise CheckoutError(f"{root} has no {name.strip()}, which level {level} needs")
    # the task of an app that has one
    handler = root / MODULES / "app_handler.c"
    if found and handler.is_file() and "CONFIG_APP_ENABLE" in settings:
        found.append(handler)
    return found


def _extras(root: Path, listing: Path, settings: Mapping[str, str]) -> list[Path]:
    """Return the files of a list that exist; ``NAME if CONFIG_SYMBOL`` counts where the symbol is set."""
    named = [line.partition(" if ") for line in read_list(listing)]
    wanted = [root / name.strip() for name, _, symbol in named if not symbol or symbol.strip() in settings]
    return [path for path in wanted if path.is_file()]


def _is_generated(name: str) -> bool:
    return os.path.normpath(name) == os.path.normpath(GENERATED)
