"""Read YAML of others as plain data, within limits that are checked before anything is built.

One pass over the events of the parser (libyaml where it is installed) counts nodes, depth and the length of texts. An
alias counts as often as what it stands for, and one that stands for something around it is refused. So the data that
comes out is a finite tree of at most `MOST_NODES` nodes, and recursion over it ends.
"""

from __future__ import annotations

import re
from collections.abc import Hashable
from copy import deepcopy
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.common.reading import read_text

LARGEST_FILE = 4_000_000  # bytes
MOST_NODES = 300_000
"""Keys, values and containers together; a list of 10,000 drones has 150,000."""
DEEPEST = 64
LONGEST_SCALAR = 20_000  # characters

_NUMBER = r"-?(?:0|[1-9][0-9]{0,20})\.[0-9]{1,20}(?:e[+-][0-9]{1,3})?"
_NUMBERS = re.compile(rf"{_NUMBER}|\[{_NUMBER}(?:, {_NUMBER})*\]")
_KEPT_CHARACTERS = 50_000

_FASTEST: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class _Loader(_FASTEST):  # type: ignore[misc]
    """YAML without a mapping that names one key twice, where the last would win in silence."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        seen = set()
        for key_node, _ in node.value:
            if isinstance(key_node, yaml.ScalarNode) and key_node.tag != "tag:yaml.org,2002:merge":
                if key_node.value in seen:
                    name = repr(key_node.value[:40])
                    raise _Refusal(f"the key {name} stands here a second time", key_node.start_mark)
                seen.add(key_node.value)
        mapping: dict[Hashable, Any] = super().construct_mapping(node, deep)
        return mapping


class _Refusal(yaml.MarkedYAMLError):
    """Something that YAML allows, and this reader does not."""

    def __init__(self, problem: str, mark: Any) -> None:
        super().__init__(problem=problem, problem_mark=mark)


def read_yaml(path: Path, error: type[CrazychoirError]) -> Any:
    """Return the content of a YAML file of others.

    Raises:
        error: If it cannot be read, is no YAML or exceeds a limit; the text is one sentence with file and line.
    """
    return parse_yaml(read_text(path, LARGEST_FILE, error), str(path), error)


def parse_yaml(text: str, source: str, error: type[CrazychoirError]) -> Any:
    """Return what a YAML text says.

    Args:
        text: The text.
        source: Where it comes from, for messages.
        error: Raised if it is no YAML or exceeds a limit.
    """
    if _NUMBERS.fullmatch(text) and len(text) < LONGEST_SCALAR:  # one value of a flight of a campaign
        return [float(number) for number in text[1:-1].split(", ")] if text[0] == "[" else float(text)
    if len(text) <= _KEPT_CHARACTERS:  # flights of a campaign read one file a thousand times
        return deepcopy(_parse_known(text, source, error))  # type: ignore[arg-type]
    return _parse(text, source, error)


def _parse(text: str, source: str, error: type[CrazychoirError]) -> Any:
    try:
        _check_limits(text)
        # a subclass of the safe loader: it builds plain data only
        return yaml.load(text, Loader=_Loader)
    except yaml.YAMLError as problem:
        raise error(f"{source}{_complaint(problem, text)}") from None
    except (ValueError, OverflowError, TypeError, KeyError, IndexError, AttributeError) as problem:
        # PyYAML meets some malformed scalars (dates, overlong or sexagesimal numbers, odd tags) with bare exceptions
        raise error(f"{source} holds a value that YAML cannot read: {_one_line(str(problem))}") from None


_parse_known = lru_cache(maxsize=16)(_parse)


def _check_limits(text: str) -> None:
    """Refuse a text that would become too much, or contains itself."""
    sizes: dict[str, int] = {}  # of what anchors name, aliases counted as what they stand for
    depths: dict[str, int] = {}
    open_nodes: list[list[Any]] = [[None, 0, 0]]  # anchor, size and depth of what is inside; the document is the first
    for event in yaml.parse(text, Loader=_FASTEST):
        if isinstance(event, yaml.AliasEvent):
            name = event.anchor or ""
            if any(node[0] == name for node in open_nodes):
                raise _Refusal(f"the alias *{name[:40]} stands inside of what it stands for", event.start_mark)
            # an alias of nothing is refused by the parser
            size, depth = sizes.get(name, 1), depths.get(name, 0)
        elif isinstance(event, yaml.ScalarEvent):
            if len(event.value) > LONGEST_SCALAR:
                raise _Refusal(
                    f"a text of {len(event.value)} characters, allowed: at most {LONGEST_SCALAR}", event.start_mark
                )
            size, depth = 1, 0
            if event.anchor:
                sizes[event.anchor], depths[event.anchor] = 1, 0
        elif isinstance(event, yaml.CollectionStartEvent):
            open_nodes.append([event.anchor, 1, 1])
            size = depth = 0
        elif isinstance(event, yaml.CollectionEndEvent):
            anchor, size, depth = open_nodes.pop()
            if anchor:
                sizes[anchor], depths[anchor] = size, depth
        else:
            continue
        around = open_nodes[-1]
        around[1] += size
        around[2] = max(around[2], depth + 1)
        if around[1] > MOST_NODES:
            raise _Refusal(f"more than {MOST_NODES} keys and values, aliases counted in full", event.start_mark)
        if len(open_nodes) + around[2] - 2 > DEEPEST:
            raise _Refusal(f"nested deeper than {DEEPEST} levels", event.start_mark)


def _complaint(error: yaml.YAMLError, text: str) -> str:
    """Return where and why a text is not YAML."""
    if isinstance(error, yaml.reader.ReaderError):
        # libyaml counts bytes and gives a number, the other parser counts characters and gives the character
        code = error.character
        if isinstance(code, int):
            line, code = text.encode(errors="replace").count(b"\n", 0, error.position) + 1, chr(code)
        else:
            line = text.count("\n", 0, error.position) + 1
        return f", line {line}: the character {code!r} cannot stand in YAML"
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    reason = getattr(error, "problem", None) or getattr(error, "reason", None) or str(error)
    if "nesting depth" in reason:  # of libyaml, which looks ahead of its events
        reason = f"nested deeper than {DEEPEST} levels"
    where = f", line {mark.line + 1}, column {mark.column + 1}" if mark else ""
    last = text.rstrip("\n").count("\n")
    if mark and mark.line > last:  # behind the end
        where = f", line {last + 1}"
    return f"{where}: {_one_line(str(reason))}"


def _one_line(text: str) -> str:
    return " ".join(text.split())[:160]
