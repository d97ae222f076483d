"""What a client has a drone keep for its next boot: persistent parameters.

Without a folder it is kept in memory, as long as the drone itself; with one, in a JSON file per drone, which the next
world with a drone of this name reads.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote
from weakref import WeakKeyDictionary

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.replacing import replacing

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone

PREFIX = "prm/"
"""Stands in front of the names, as in the firmware's storage."""

_in_memory: WeakKeyDictionary[Drone, ParameterStorage] = WeakKeyDictionary()


class ParameterStorage:
    """Stored values of one drone, by the complete names of parameters."""

    def __init__(self, file: Path | None = None) -> None:
        """Read what is stored.

        Args:
            file: Where it is kept; None keeps it in memory.

        Raises:
            RangeError: If the file cannot be read, or holds something else.
        """
        self._file = file
        self._values: dict[str, float | int] = {} if file is None or not file.exists() else _read(file)

    def __iter__(self) -> Iterator[tuple[str, float | int]]:
        return iter(list(self._values.items()))

    def get(self, name: str) -> float | int | None:
        """Return the stored value of a parameter, or None."""
        return self._values.get(name)

    def store(self, name: str, value: float | int) -> bool:
        """Store the value of a parameter; False when the file cannot be written."""
        return self._replace({**self._values, name: value})

    def clear(self, name: str) -> bool:
        """Forget the stored value of a parameter; False when there is none, or the file cannot be written."""
        if name not in self._values:
            return False
        return self._replace({known: value for known, value in self._values.items() if known != name})

    def _replace(self, values: dict[str, float | int]) -> bool:
        if self._file is not None:
            content = json.dumps({PREFIX + name: value for name, value in sorted(values.items())}, indent=1)
            try:
                with replacing(self._file) as temporary:
                    temporary.write_text(content + "\n")
            except OSError:
                return False
        self._values = values
        return True


def storage_of(drone: Drone, folder: str | Path | None) -> ParameterStorage:
    """Return the storage of a drone: a file in a folder, or its own in memory.

    Raises:
        RangeError: If its file cannot be read, or holds something else.
    """
    if folder is not None:
        return ParameterStorage(Path(folder) / f"{quote(drone.id, safe='')}.json")
    return _in_memory.setdefault(drone, ParameterStorage())


def _read(file: Path) -> dict[str, float | int]:
    try:
        content = json.loads(file.read_text())
    except (OSError, ValueError) as error:
        raise RangeError(f"{file}: cannot be read as stored parameters: {error}") from error
    if not isinstance(content, dict):
        raise RangeError(f"{file}: is no table of stored parameters")
    for key, value in content.items():
        is_number = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
        if not key.startswith(PREFIX) or not is_number:
            raise RangeError(f"{file}: {key!r}: {value!r}; allowed: '{PREFIX}group.name' with a finite number")
    return {key.removeprefix(PREFIX): value for key, value in content.items()}
