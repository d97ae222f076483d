"""YAML of a mission as plain data, or one sentence about why it cannot be read."""

from collections.abc import Hashable
from pathlib import Path
from typing import Any

import yaml

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.mission.wording import one_line, show

LARGEST_FILE = 4_000_000  # bytes


class _Loader(yaml.SafeLoader):
    """YAML without a mapping that names one key twice, where the last would win in silence."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        seen = set()
        for key_node, _ in node.value:
            if isinstance(key_node, yaml.ScalarNode) and key_node.tag != "tag:yaml.org,2002:merge":
                if key_node.value in seen:
                    raise yaml.constructor.ConstructorError(
                        None, None, f"the key {show(key_node.value)} stands here a second time", key_node.start_mark
                    )
                seen.add(key_node.value)
        return super().construct_mapping(node, deep)


def read_file(path: Path) -> Any:
    """Return the content of a YAML file.

    Raises:
        MissionError: If there is none, or it is not YAML.
    """
    data = parse_text(_text(path), str(path))
    if data is None:
        raise MissionError(f"{path} is empty, but must be a mapping such as name:, drones: and flight:")
    return data


def parse_text(text: str, source: str) -> Any:
    """Return what a YAML text says.

    Args:
        text: The text.
        source: Where it comes from, for messages.

    Raises:
        MissionError: If it is not YAML.
    """
    try:
        # a subclass of the safe loader: it builds plain data only
        return yaml.load(text, Loader=_Loader)
    except yaml.YAMLError as error:
        raise MissionError(f"{source}{_complaint(error, text)}") from None
    except RecursionError:
        raise MissionError(f"{source} is nested too deeply for a mission file") from None
    except (ValueError, OverflowError, TypeError, KeyError, IndexError, AttributeError) as error:
        # PyYAML meets some malformed scalars (dates, overlong or sexagesimal numbers, odd tags) with bare exceptions
        raise MissionError(f"{source} holds a value that YAML cannot read: {one_line(str(error))}") from None


def _text(path: Path) -> str:
    """Return the text of a file of reasonable size."""
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise MissionError(f"{path} cannot be read: {error.strerror}") from None
    except ValueError:
        raise MissionError(f"{show(str(path))} is no file name") from None
    if len(content) > LARGEST_FILE:
        raise MissionError(f"{path} is larger than {LARGEST_FILE} bytes, which no mission needs")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        raise MissionError(f"{path} is not a text file, but must be YAML in UTF-8") from None


def _complaint(error: yaml.YAMLError, text: str) -> str:
    """Return where and why a text is not YAML."""
    if isinstance(error, yaml.reader.ReaderError):
        line = text.count("\n", 0, error.position) + 1
        return f", line {line}: the character {error.character!r} cannot stand in YAML"
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    reason = getattr(error, "problem", None) or getattr(error, "reason", None) or str(error)
    where = f", line {mark.line + 1}, column {mark.column + 1}" if mark else ""
    return f"{where}: {one_line(str(reason))}"
