"""The columns of a long journal, collected in files instead of memory."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

_PIECE_BYTES = 1 << 20
_PER_REQUEST = {"ticks": np.int64, "drones": np.int32, "kinds": np.int32}

Member = tuple[str, tuple[int, ...], np.dtype, Iterator[bytes]]
"""Name, shape, type and bytes of an array."""


class JournalColumns:
    """The requests of many journals one after the other, as `Journal.to_arrays` has them."""

    def __init__(self, recipe: Mapping[str, Any], scratch: Callable[[], IO[bytes]]) -> None:
        """Begin without a request.

        Args:
            recipe: How to build the world.
            scratch: Makes an empty file to write and read.
        """
        self.count = 0
        """How many requests there are."""
        self._recipe, self._scratch = dict(recipe), scratch
        self._gap: str | None = None
        self._columns = {name: scratch() for name in _PER_REQUEST}
        # of each verb and signature: its number, and its numbers and bytes
        self._kinds: dict[tuple[str, str], tuple[int, IO[bytes], IO[bytes]]] = {}

    def extend(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Append the requests of a journal, which came later, and take over its gap.

        Args:
            arrays: What `Journal.to_arrays` returns.
        """
        about, numbers, blob = json.loads(str(arrays["about"])), arrays["numbers"], arrays["blob"]
        own = np.zeros(len(about["kinds"]), np.int32)
        kinds = zip(about["kinds"], about["numbers"], about["bytes"], strict=True)
        for k, ((verb, signature), n_numbers, n_bytes) in enumerate(kinds):
            key = str(verb), str(signature)
            if key not in self._kinds:
                self._kinds[key] = len(self._kinds), self._scratch(), self._scratch()
            own[k], values, raw = self._kinds[key]
            values.write(numbers[:n_numbers].tobytes())
            raw.write(blob[:n_bytes].tobytes())
            numbers, blob = numbers[n_numbers:], blob[n_bytes:]
        numbers_of_kinds = arrays["kinds"]
        self._columns["ticks"].write(arrays["ticks"].tobytes())
        self._columns["drones"].write(arrays["drones"].tobytes())
        self._columns["kinds"].write(own[numbers_of_kinds].tobytes())
        self.count += len(numbers_of_kinds)
        self._gap = self._gap or about["gap"]

    def members(self) -> Iterator[Member]:
        """Give what `Journal.to_arrays` returns, but for ``samples``."""
        values = [kind[1] for kind in self._kinds.values()]
        raw = [kind[2] for kind in self._kinds.values()]
        about = {
            "recipe": self._recipe,
            "gap": self._gap,
            "kinds": [list(key) for key in self._kinds],
            "numbers": [file.tell() // 8 for file in values],
            "bytes": [file.tell() for file in raw],
        }
        text = np.array(json.dumps(about))
        yield "about", (), text.dtype, iter([text.tobytes()])
        for name, kind in _PER_REQUEST.items():
            yield _member(name, np.dtype(kind), [self._columns[name]])
        yield _member("numbers", np.dtype(np.float64), values)
        yield _member("blob", np.dtype(np.uint8), raw)


def _member(name: str, dtype: np.dtype, files: Sequence[IO[bytes]]) -> Member:
    size = sum(file.tell() for file in files)
    return name, (size // dtype.itemsize,), dtype, _content(files)


def _content(files: Sequence[IO[bytes]]) -> Iterator[bytes]:
    for file in files:
        file.seek(0)
        while piece := file.read(_PIECE_BYTES):
            yield piece
