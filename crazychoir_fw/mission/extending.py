"""Missions that extend other missions: which files there are, what they say together, and who said what."""

from __future__ import annotations

import re
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.mission.reading import read_file
from crazychoir_fw.mission.values import did_you_mean
from crazychoir_fw.mission.wording import show

EXTENDS = "extends"
LONGEST_CHAIN = 16  # files

Step = str | int
"""A key of a mapping, or a number in a list."""


@dataclass(frozen=True)
class Document:
    """What one file says."""

    source: str
    """Its name, for messages."""
    folder: Path
    """Where files that it names are seen from."""
    data: Mapping[Hashable, Any]
    """Its content, without `extends`."""


def chain_of(data: Mapping[Hashable, Any], source: str, folder: Path) -> list[Document]:
    """Return a mission and all that it extends, the strongest first.

    Args:
        data: What the mission itself says.
        source: Where that comes from, for messages.
        folder: Folder that its relative paths start from.

    Raises:
        MissionError: If a file cannot be read, is no mapping, or extends itself.
    """
    documents: list[Document] = []
    seen = [_resolved(Path(source))]
    while True:
        own = {key: value for key, value in data.items() if key != EXTENDS}
        documents.append(Document(source, folder, own))
        base = data.get(EXTENDS)
        if base is None:
            return documents
        if not isinstance(base, str) or not base.strip():
            raise MissionError(f"{source}: extends is {show(base)}, but must be a mission file such as goto.yaml")
        path = folder / base
        if _resolved(path) in seen:
            raise MissionError(f"{source}: extends is {show(base)}, but that file extends this one")
        if len(seen) == LONGEST_CHAIN:
            raise MissionError(f"{source}: extends is {show(base)}, but must end a chain of at most {LONGEST_CHAIN}")
        data = _read_base(path, source, base)
        seen.append(_resolved(path))
        source, folder = str(path), path.parent


def files_of(path: Path) -> list[Path]:
    """Return a mission file and all that it extends, as far as they can be read."""
    try:
        data = read_file(path)
        documents = chain_of(data, str(path), path.parent) if isinstance(data, Mapping) else []
    except MissionError:
        return [path]
    return [path, *(Path(document.source) for document in documents[1:])]


def _read_base(path: Path, source: str, base: str) -> Mapping[Hashable, Any]:
    try:
        is_file = path.is_file()
    except (OSError, ValueError):  # a name that no file can have
        is_file = False
    if not is_file:
        others = [file.name for file in path.parent.glob("*.yaml")] if path.parent.is_dir() else []
        hint = did_you_mean(path.name, others)
        raise MissionError(f"{source}: extends is {show(base)}, but must be an existing mission file{hint}")
    data = read_file(path)
    if not isinstance(data, Mapping):
        raise MissionError(f"{path} is {show(data)}, but must be a mapping such as name:, drones: and flight:")
    return data


def _resolved(path: Path) -> str:
    try:
        return str(path.resolve())
    except (OSError, ValueError, RuntimeError):
        return str(path)


# -------------------------------------------------------------------------------- together


def together(documents: Sequence[Document]) -> dict[Hashable, Any]:
    """Return what files say together, the strongest first: mappings are merged, everything else is replaced.

    A name is not inherited: two missions of one name would write into one folder.
    """
    whole: dict[Hashable, Any] = {}
    for document in reversed(documents):
        whole.pop("name", None)
        try:
            whole = merged(whole, document.data)
        except RecursionError:  # two files with mappings that contain themselves
            raise MissionError(f"{document.source} is nested too deeply for a mission file") from None
    return whole


def merged(below: Any, above: Any) -> Any:
    """Return a value that another one is laid over."""
    if not (isinstance(below, Mapping) and isinstance(above, Mapping)):
        return above
    # only what both have is walked through, so that data that contains itself ends
    both = dict(below)
    for key, value in above.items():
        both[key] = merged(below[key], value) if key in below else value
    return both


# -------------------------------------------------------------------------------- who said it


def path_in(sentence: str) -> tuple[Step, ...]:
    """Return the key path that a complaint begins with, such as ("flight", 1, "takeoff")."""
    begin = re.match(r"[^\W\d]\w*(?:\.\w+|\[\d+\])*", sentence)
    path = steps_of(begin[0]) if begin else ()
    if unknown := re.match(r"(\S+|a mission) has no key '?([\w.-]+)'?", sentence):
        path = (*(() if unknown[1] == "a mission" else path), unknown[2])
    return path


def steps_of(text: str) -> tuple[Step, ...]:
    """Return a key path as steps: "drones[0].position" has the steps "drones", 0, "position"."""
    return tuple(int(match[1]) if match[1] else match[0] for match in re.finditer(r"\[(\d{1,9})\]|[^.\[\]]+", text))


def depth(data: Any, path: Sequence[Step]) -> int:
    """Return how many steps of a path lead to something."""
    for count, step in enumerate(path):
        if isinstance(step, int):
            if not isinstance(data, Sequence) or isinstance(data, str | bytes) or step >= len(data):
                return count
        elif not isinstance(data, Mapping) or step not in data:
            return count
        data = data[step]
    return len(path)


def origin(documents: Sequence[Document], path: Sequence[Step]) -> Document:
    """Return in which file a key stands, or would stand: the one that knows most of its path."""
    return max(documents, key=lambda document: depth(document.data, path))
