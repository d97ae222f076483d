"""What an MJCF of others may ask for, counted before MuJoCo builds it: elements, copies, pictures, memory."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.parsers import expat

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.reading import read_text

LARGEST_FILE = 20_000_000  # bytes
MOST_ELEMENTS = 200_000
"""Elements with all copies that `replicate`, `composite`, `flexcomp` and `attach` make."""
LARGEST_GRID = 16_000_000
"""Cells of a texture or a height field."""
LARGEST_SIZE = 10_000_000
"""Numbers of the element `size`, such as `nconmax`."""
LARGEST_MEMORY = 4 * 2**30  # bytes, of the attribute `memory` of `size`
MOST_FILES = 100

_COPIERS = ("replicate", "composite", "flexcomp")
_UNITS = {"k": 2**10, "m": 2**20, "g": 2**30, "t": 2**40, "p": 2**50, "e": 2**60}


def check_scene(path: Path) -> None:
    """Refuse a scene that asks for more than a machine has, with all files that it includes.

    Raises:
        RangeError: If a limit is exceeded, or a file is no XML; the text names the file.
    """
    _Count(path.parent, [0]).of(path, ())


class _Count:
    """Counts elements; the copies of what stands in a `replicate` count each."""

    def __init__(self, folder: Path, files: list[int]) -> None:
        self._folder, self._files = folder, files  # files read so far, of all counts
        self._attached = 0  # elements `attach`, with copies
        self._largest_model = 0

    def of(self, path: Path, above: tuple[Path, ...]) -> int:
        """Return the number of elements of a file and of those that it includes.

        Args:
            path: The file.
            above: Files that include it.
        """
        self._files[0] += 1
        if self._files[0] > MOST_FILES:
            raise RangeError(f"scene {path}: more than {MOST_FILES} files are included, allowed: at most {MOST_FILES}")
        if path in above:
            raise RangeError(f"scene {path}: includes itself")
        total = 0
        copies = [1]

        def start(tag: str, attributes: dict[str, str]) -> None:
            nonlocal total
            _check_numbers(path, tag, attributes)
            count = _copies_of(attributes) if tag in _COPIERS else 1
            total += copies[-1] * (count if tag != "replicate" else 1)
            copies.append(copies[-1] * count)
            if tag == "include" and (file := self._folder / attributes.get("file", "")).is_file():
                total += copies[-1] * self.of(file, (*above, path))
            elif tag == "model" and (file := self._folder / attributes.get("file", "")).is_file():
                model = _Count(file.parent, self._files).of(file, (*above, path))
                self._largest_model = max(self._largest_model, model)
            elif tag == "attach":
                self._attached += copies[-1]
            if total + self._attached * self._largest_model > MOST_ELEMENTS:
                raise RangeError(f"scene {path}: more than {MOST_ELEMENTS} elements, copies counted, are not allowed")

        _parse(path, start, lambda _: copies.pop())
        return total + self._attached * self._largest_model


def _parse(path: Path, start: Callable[[str, dict[str, str]], Any], end: Callable[[str], Any]) -> None:
    text = read_text(path, LARGEST_FILE, RangeError)
    if re.search(r"""=\s*(?:"[^"<>]*|'[^'<>]*)<""", text):
        raise RangeError(f"scene {path}: the value of an attribute holds '<', which XML writes as &lt;")
    # MuJoCo's parser allows two dashes in a comment, expat does not
    text = re.sub(r"<!--.*?-->", lambda comment: "\n" * comment[0].count("\n"), text, flags=re.DOTALL)
    if "<!ENTITY" in text:
        raise RangeError(f"scene {path}: entities are not allowed")
    parser = expat.ParserCreate()
    parser.StartElementHandler = start
    parser.EndElementHandler = end
    try:
        parser.Parse(text.encode(), True)
    except expat.ExpatError as error:
        raise RangeError(f"scene {path}, line {error.lineno}: {expat.ErrorString(error.code)}") from None
    except (LookupError, ValueError) as error:  # an encoding that is none
        raise RangeError(f"scene {path}: {error}") from None


def _copies_of(attributes: dict[str, str]) -> int:
    counts = [_number(word) for word in attributes.get("count", "1").split()]
    return round(max(1.0, min(math.prod(max(count, 1.0) for count in counts), 1e12)))


def _check_numbers(path: Path, tag: str, attributes: dict[str, str]) -> None:
    """Refuse large pictures, grids and buffers."""
    if tag in ("texture", "hfield"):
        names = ("width", "height") if tag == "texture" else ("nrow", "ncol")
        cells = math.prod(max(_number(attributes.get(name, "1")), 1.0) for name in names)
        if cells > LARGEST_GRID:
            raise RangeError(f"scene {path}: a {tag} of {cells:g} cells, allowed: at most {LARGEST_GRID}")
    if tag == "size":
        for name, text in attributes.items():
            largest = LARGEST_MEMORY if name == "memory" else LARGEST_SIZE
            if _number(text) > largest:
                raise RangeError(f"scene {path}: size {name} is {text[:40]!r}, allowed: at most {largest}")


def _number(text: str) -> float:
    """Return a number such as 3, 1e3 or 5M; 0 for what is none, which MuJoCo refuses."""
    words = text.strip().lower()
    unit = _UNITS.get(words[-1:], 1)
    try:
        value = float(words[:-1] if unit > 1 else words)
    except ValueError:
        return 0.0
    return value * unit if math.isfinite(value) else math.inf
