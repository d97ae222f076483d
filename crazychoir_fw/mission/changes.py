"""Single values of a mission, changed from the command line: `--set layers.rate=50`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.mission.extending import EXTENDS, Step, depth, merged, steps_of
from crazychoir_fw.mission.reading import parse_text
from crazychoir_fw.mission.values import did_you_mean
from crazychoir_fw.mission.wording import show

OPTION = "--set"


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
    return Change(text, steps, parse_text(value, change.source))


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
        raise MissionError(f"{change.source}: {_text(taken) or 'a mission'} is {show(node)}, with {what}")
    taken.append(step)
    return {**node, step: _changed(node.get(step), rest, change, taken)}


def _entry(items: Sequence[Any], step: Step, change: Change, taken: Sequence[Step]) -> tuple[int, Any]:
    """Return number and content of the entry of a list that a step means."""
    where = _text(taken)
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


def _text(path: Sequence[Step]) -> str:
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    return text.removeprefix(".")
