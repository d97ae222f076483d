"""What decides the flights of a campaign, as one digest: files, settings, firmware, and the build of the package."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from crazychoir_fw.campaign.bundle import SUFFIXES
from crazychoir_fw.campaign.campaign import Campaign
from crazychoir_fw.firmware.build import build_provider
from crazychoir_fw.firmware.checkout import locate
from crazychoir_fw.firmware.levels import level_of
from crazychoir_fw.mission.documents import files_of, read_all, read_file
from crazychoir_fw.onboard.core import identity

_CODE = {".py": ("*.py",), ".c": ("*.c", "*.h")}
"""Files beside one of the user's that it may use."""


def identity_of(campaign: Campaign) -> str:
    """Return a digest of all that decides what is flown; more flights of the same campaign have the same.

    Raises:
        CrazychoirError: If a mission cannot be read, or the firmware not be built.
        OSError: If a file cannot be read.
    """
    digest = hashlib.sha256()
    for path in sorted(_files(campaign)):
        digest.update(path.read_bytes())
    settings = campaign.settings.model_dump(mode="json", exclude={"flights"})  # more flights go on
    digest.update(
        json.dumps(
            [
                settings,
                campaign.base,
                campaign.checkout,
                campaign.variant.model_dump(mode="json"),
                identity(),
                _firmware(campaign),
            ]
        ).encode()
    )
    return digest.hexdigest()


def _files(campaign: Campaign) -> set[Path]:
    beside = campaign.file.parent
    missions = {campaign.mission_file}
    if campaign.variant.mission is not None:
        missions.add(beside / campaign.variant.mission)
    files = {campaign.file}
    for mission in missions:
        files |= {*files_of(mission), *named_files(mission, [*campaign.settings.set, *campaign.base])}
    for file in campaign.variant.app or ():
        files |= {beside / file, *_with_neighbors(beside / file)}
    return {file.resolve() for file in files}


def named_files(mission: Path, changes: Sequence[str]) -> set[Path]:
    """Return the files that a mission names: laws, apps, trajectories, scenes; and code beside code.

    Args:
        mission: The mission file.
        changes: Its changes, as `--set` takes them.

    Raises:
        MissionError: If it cannot be read.
    """
    told = read_all(read_file(mission), str(mission), mission.parent, changes)
    found: set[Path] = set()
    for text in _texts(told.data):
        name = text.partition(":")[0]  # of file.py:Class
        if Path(name).suffix not in SUFFIXES or len(name) > 255:
            continue
        for folder in told.folders:
            if (folder / name).is_file():
                found |= {folder / name, *_with_neighbors(folder / name)}
    return found


def _texts(data: Any) -> Iterator[str]:
    if isinstance(data, str):
        yield data
    elif isinstance(data, Mapping):
        for value in data.values():
            yield from _texts(value)
    elif isinstance(data, Sequence):
        for value in data:
            yield from _texts(value)


def _with_neighbors(file: Path) -> Iterator[Path]:
    for pattern in _CODE.get(file.suffix, ()):
        yield from file.parent.glob(pattern)


def _firmware(campaign: Campaign) -> dict[str, str]:
    """Return the content of the checkout that flies, by provider and platform; nothing for the built-in one."""
    found = {}
    for drone in campaign.mission.fleet:
        word = campaign.variant.provider or drone.provider
        level, key = level_of(word), f"{word} {drone.platform}"
        if level is not None and key not in found:
            library = build_provider(locate(campaign.checkout), drone.platform, level=level)
            found[key] = str(library.identity["content"])
    return found
