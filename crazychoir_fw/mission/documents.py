"""The plain data of a mission: YAML, the files that it extends, values changed by `--set`, and their sources."""

from __future__ import annotations

import re
from collections.abc import Hashable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.common.plain_yaml import parse_yaml, read_yaml
from crazychoir_fw.common.reading import printable
from crazychoir_fw.mission.values import did_you_mean
from crazychoir_fw.mission.wording import show

EXTENDS = "extends"
OPTION = "--set"
LONGEST_CHAIN = 16  # files
LONGEST_SENTENCE = 800

Step = str | int
"""A key of a mapping, or a number in a list."""


def read_file(path: Path) -> Any:
    """Return the content of a YAML file.

    Raises:
        MissionError: If there is none, or it is not YAML.
    """
    data = read_yaml(path, MissionError)
    if data is None:
        raise MissionError(f"{path} is empty, but must be a mapping such as name:, drones: and flight:")
    return data


@dataclass(frozen=True)
class Told:
    """The merged data of a mission, and the source of each value."""

    data: dict[Hashable, Any]
    _documents: Sequence[Document]
    _changes: Sequence[Change]
    _before: Mapping[Hashable, Any]

    @property
    def folders(self) -> tuple[Path, ...]:
        """Where files that it names are seen from."""
        return tuple(dict.fromkeys(document.folder for document in self._documents))

    def blame(self, sentence: str) -> str:
        """Return a complaint with the file, or the change, that it is about."""
        path = path_in(sentence)
        sentence = printable(sentence, LONGEST_SENTENCE)
        change = change_at(self._changes, path, self._before)
        if change is not None:
            return f"{change.source}: {sentence}"
        source = origin(self._documents, path).source
        first = self._documents[0].source
        return f"{source}{'' if source == first else f' (extended by {first})'}: {sentence}"


def read_all(data: Any, source: str, folder: Path, changes: Sequence[str] = ()) -> Told:
    """Return what a mission, the missions that it extends, and changes such as "layers.rate=50" say together.

    Args:
        data: What the mission itself says.
        source: Where that comes from, for messages.
        folder: Folder that its relative paths start from.
        changes: See `read_change`.

    Raises:
        MissionError: If it is no mapping, a file cannot be read, or there is no place for a change.
    """
    if not isinstance(data, Mapping):
        raise MissionError(f"{source} is {show(data)}, but must be a mapping such as name:, drones: and flight:")
    documents = chain_of(data, source, folder)
    before = together(documents)
    changed, made = apply(before, [read_change(text) for text in changes])
    return Told(changed, documents, made, before)


# -------------------------------------------------------------------------------- files that extend each other


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
        others = [file.name for file in path.parent.glob("*.yaml") if file.is_file()] if path.parent.is_dir() else []
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


# -------------------------------------------------------------------------------- sources of values


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


# -------------------------------------------------------------------------------- values that are changed


@dataclass(frozen=True)
class Change:
    """One value at one place."""

    text: str
    """As it was given, for messages."""
    steps: tuple[Step, ...]
    value: Any

    @property
    def source(self) -> str:
        """Where complaints about the value come from."""
        return f"{OPTION} {show(self.text)[1:-1]}"


def read_change(text: str) -> Change:
    """Return the change that a text such as "drones.count=6" asks for; the value is YAML.

    Keys follow each other with dots. In a list, a number or what its entry is called: drones[0], drones.0,
    drones.agent_0; flight.start for the one phase `start`.

    Raises:
        MissionError: If the text is no such thing.
    """
    change = _read_once(text)
    is_plain = change.value is None or isinstance(change.value, str | float | int)
    return change if is_plain else replace(change, value=deepcopy(change.value))


@lru_cache(maxsize=4096)  # missions of a campaign differ in a few of hundreds of changes
def _read_once(text: str) -> Change:
    path, equals, value = text.partition("=")
    if not equals or not path.strip():
        raise MissionError(f"{OPTION} is {show(text)}, but must be a key and a value, such as layers.rate=50")
    change = Change(text, (), None)
    if path.count("[") != path.count("]") or not (steps := steps_of(path.strip())):
        raise MissionError(f"{change.source}: {show(path)} is no key, such as layers.rate or drones[0].position")
    if steps[0] == EXTENDS:
        raise MissionError(f"{change.source}: what a mission extends stands in its file only")
    if "parameters" in steps[:-1]:
        # names of onboard parameters have dots of their own
        cut = steps.index("parameters") + 1
        steps = (*steps[:cut], ".".join(map(str, steps[cut:])))
    return Change(text, steps, parse_yaml(value, change.source, MissionError))


def apply(data: Any, changes: Sequence[Change]) -> tuple[Any, list[Change]]:
    """Return changed data, and the changes with their places as the data has them: numbers instead of names.

    Raises:
        MissionError: If there is no such place.
    """
    resolved = []
    for change in changes:
        taken: list[Step] = []
        data = _changed(data, change.steps, change, taken)
        resolved.append(Change(change.text, tuple(taken), change.value))
    return data, resolved


def change_at(changes: Sequence[Change], path: Sequence[Step], before: Any) -> Change | None:
    """Return the change that made what stands at a path, if one did.

    Args:
        changes: As `apply` returns them.
        path: Key path of a complaint.
        before: The data without them.
    """
    for change in reversed(changes):
        shared = min(len(path), len(change.steps))
        is_below = len(change.steps) <= len(path)
        if path and change.steps[:shared] == tuple(path[:shared]) and (is_below or depth(before, path) < len(path)):
            return change
    return None


def _changed(node: Any, steps: tuple[Step, ...], change: Change, taken: list[Step]) -> Any:
    """Return a node with the value at the end of the steps; what lies on the way is copied, for it may be shared."""
    if not steps:
        return merged(node, change.value)
    step, rest = steps[0], steps[1:]
    if isinstance(node, Sequence) and not isinstance(node, str | bytes):
        number, item = _entry(node, step, change, taken)
        taken.append(number)
        # by the name of a phase one goes into it
        inner = (step, *rest) if isinstance(item, Mapping) and step in item and "id" not in item else rest
        items = list(node)
        items[number] = _changed(item, inner, change, taken)
        return items
    if node is None:
        node = {}
    if not isinstance(node, Mapping) or isinstance(step, int):
        what = f"no entry {step}" if isinstance(step, int) else f"no keys such as {step[:40]}"
        raise MissionError(f"{change.source}: {_joined(taken) or 'a mission'} is {show(node)}, with {what}")
    taken.append(step)
    return {**node, step: _changed(node.get(step), rest, change, taken)}


def _entry(items: Sequence[Any], step: Step, change: Change, taken: Sequence[Step]) -> tuple[int, Any]:
    """Return number and content of the entry of a list that a step means."""
    where = _joined(taken)
    if isinstance(step, int) or step.isdecimal():
        if int(step) >= len(items):
            raise MissionError(f"{change.source}: {where} has no entry {step}, but {len(items)}, from 0 on")
        return int(step), items[int(step)]
    names = [_name(item) for item in items]
    found = [number for number, name in enumerate(names) if name == step]
    if len(found) > 1:
        several = ", ".join(f"{where}[{number}]" for number in found[:3])
        raise MissionError(f"{change.source}: {where} has {len(found)} entries '{step}', name one: {several}")
    if not found:
        hint = did_you_mean(step, [name for name in names if name is not None])
        raise MissionError(f"{change.source}: {where} has no entry '{step[:40]}'{hint}")
    item = items[found[0]]
    return found[0], {item: {}} if isinstance(item, str) else item


def _name(item: Any) -> str | None:
    """Return what people call an entry: its id, or the word of a phase."""
    if isinstance(item, str):
        return item
    if not isinstance(item, Mapping):
        return None
    word = item.get("id") if "id" in item else next(iter(item), None)
    return word if isinstance(word, str) else None


def _joined(path: Sequence[Step]) -> str:
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    return text.removeprefix(".")
