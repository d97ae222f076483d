"""Missions as a stranger may write them: the examples, spoilt as data and as text."""

import copy
import random
from pathlib import Path
from typing import Any

import yaml

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.common.plain_yaml import read_yaml

ROOT = Path(__file__).resolve().parents[2]
DEVICES = ("/dev/zero", "/dev/stdin", "pipe.csv", "pipe.py:Law", "folder", "folder.csv", "../" * 40, "loop.yaml")

VALUES: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 2, 3.5, 1e308, -1e308, 1e-320, float("nan"), float("inf"), 2**31, 2**64, 2**70, 10**40,
    "", " ", "a", "0", "nan", "1e999", "a\nb", "a\0b", "\u202e\u2028", "\x1b[31m", "x" * 3000, "[red]", "~",
    [], {}, [[]], [{}], {"": ""}, {"a": {"b": {"c": []}}}, [None], [[[[[1]]]]], {None: None}, {1: 2}, {True: []},
    [0, 0], [0, 0, 0], [1e9, 0, 1], [0.0] * 100, ["a", "a"], [["a", "b"]], {"x": float("nan")}, b"\x00\xff",
    "os:system", "no.such:Law", "mission.yaml", "none.py:Law", "crazychoir_fw.guidance:CFGuidance", "builtin+x",
    {"bitcraze": {"modules": "all"}}, "radio://0/80/2M/E7E7E7E7FF", {"random": {}}, {"within_distance": 1.0},
    {"schedule": [{"at": 0, "graph": "ring"}]}, "complete", "grid", {"layout": "grid", "spacing": 1.0}, *DEVICES,
)  # fmt: skip

TOKENS = (
    "&a ", "*a", "<<: *a", "!!set ", "!!omap ", "!!binary ", "!!timestamp ", "!!float ", "!!int ", "!x ", "? ", ": ",
    "- ", "---\n", "...\n", "%YAML 1.1\n", "\t", "\0", "\x85", "\ufeff", "|\n", ">+9\n", "'", '"', '"\\x00"', "{", "}",
    "[", "]", "#", ",", "0x", "1:1:1:1", "0b2", "_", ".inf", "-.nan", "2020-13-45", "=", "[" * 70, "{a: " * 70,
)  # fmt: skip


def seeds() -> dict[str, Any]:
    """Return the missions of the examples by file, as data."""
    found = {}
    for path in sorted((ROOT / "examples").rglob("*.yaml")):
        try:
            data = read_yaml(path, CrazychoirError)
        except CrazychoirError:
            continue
        if isinstance(data, dict) and ("flight" in data or "extends" in data):
            found[str(path.relative_to(ROOT))] = data
    return found


class Mutator:
    """Makes mutants; the same for the same seed."""

    def __init__(self, missions: dict[str, Any], seed: int) -> None:
        self.random = random.Random(seed)
        self._missions = missions
        self._by_key: dict[Any, list[Any]] = {}
        for mission in missions.values():
            for container, key in _places(mission):
                if isinstance(container, dict):
                    self._by_key.setdefault(key, []).append(container[key])
        self._keys = list(self._by_key)

    def mutant(self) -> tuple[Path, bytes]:
        """Return the next one: the folder of the mission that it was made of, and the file."""
        name = self.random.choice([*self._missions])
        data = copy.deepcopy(self._missions[name])
        for _ in range(self.random.choice((1, 1, 1, 1, 1, 2, 3, 5))):
            self._spoil(data)
        text = yaml.dump(data, Dumper=getattr(yaml, "CSafeDumper", yaml.SafeDumper), allow_unicode=True)
        content = text.encode(errors="surrogatepass")
        for _ in range(self.random.choice((0, 0, 0, 0, 0, 1, 2))):
            content = self._spoil_text(content)
        return Path(name).parent, content

    def change(self) -> str:
        """Return a value for ``--set``."""
        path = ".".join(str(self.random.choice(self._keys)) for _ in range(self.random.randint(1, 3)))
        return f"{path}={self.random.choice(TOKENS)}" if self.random.random() < 0.5 else f"{path}=1"

    def _spoil(self, data: Any) -> None:
        """Change one place of a mission: its value, its key, or what is around it."""
        places = _places(data)
        if not places:
            return
        container, key = self.random.choice(places)
        how = self.random.randrange(7)
        if how <= 2:
            container[key] = copy.deepcopy(self.random.choice(VALUES))
        elif how == 3:
            container[key] = copy.deepcopy(self.random.choice(self._by_key[self.random.choice(self._keys)]))
        elif how == 4:
            del container[key]
        elif isinstance(container, dict):
            # a key of some mission with a value that it has there, or with any
            name = self.random.choice(self._keys)
            value = self.random.choice(self._by_key[name] if how == 5 else VALUES)
            container[name] = copy.deepcopy(value)
        elif container:
            container.insert(key, copy.deepcopy(self.random.choice((container[key], *VALUES[:20]))))

    def _spoil_text(self, content: bytes) -> bytes:
        """Change some bytes of a file."""
        where = self.random.randrange(len(content) + 1)
        how = self.random.randrange(5)
        if how == 0:
            return content[:where] + self.random.choice(TOKENS).encode() + content[where:]
        if how == 1:
            return content[:where] + bytes([self.random.randrange(256)]) + content[where + 1 :]
        if how == 2:
            end = where + self.random.randrange(1, 40)
            return content[:where] + content[end:]
        lines = content.splitlines(keepends=True) or [b"\n"]
        number = self.random.randrange(len(lines))
        if how == 3:
            return b"".join([*lines[: number + 1], *lines[number:]])
        return b"".join(
            [*lines[:number], b"  " * self.random.randrange(3) + lines[number].lstrip(), *lines[number + 1 :]]
        )


def _places(data: Any, depth: int = 0) -> list[tuple[Any, Any]]:
    """Return every place of a value in data: the container and the key or the number in it."""
    if depth > 12 or not isinstance(data, dict | list):
        return []
    keys = list(data) if isinstance(data, dict) else range(len(data))
    return [place for key in keys for place in [(data, key), *_places(data[key], depth + 1)]]
