"""Drawings of trajectories: kept by the server, so that all browsers see the same ones, and a reload loses none."""

from __future__ import annotations

import io
import re
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError, StateError, UnknownNameError
from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.gui.requests import FARTHEST_M, MAX_DRAWINGS, MAX_POINTS
from crazychoir_fw.planning import read_drawn

EXAMPLES = Path(__file__).parent / "drawings"
"""Drawings that come with the package, a folder of CSV files each."""
_UNDOS = 100


@dataclass(frozen=True)
class Drawing:
    """A trajectory as it was drawn: x and y are those of the world."""

    key: str
    name: str
    points: NDArray[np.float64]
    """x, y, z (m, world), shape (m, 3)."""
    times: NDArray[np.float64]
    """When each was drawn (s), from 0, not decreasing, shape (m,)."""
    drone: str
    """Name of the drone that flies it."""

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {
            "key": self.key,
            "name": self.name,
            "drone": self.drone,
            "height": round(float(self.points[0, 2]), 3),
            "points": np.round(self.points[:, :2], 4).tolist(),
            "seconds": round(float(self.times[-1]), 2),
        }

    def csv(self) -> str:
        """Return it as the text of a file that `read_drawn` reads."""
        text = io.StringIO()
        text.write("t,x,y,z\n")
        for t, (x, y, z) in zip(self.times, self.points, strict=True):
            text.write(f"{t:.3f},{x:.4f},{y:.4f},{z:.4f}\n")
        return text.getvalue()


class Drawings:
    """All drawings, with undo. May be used from any thread."""

    def __init__(self, drones: Sequence[str], folder: Path) -> None:
        """Begin with none.

        Args:
            drones: Names of the drones that may fly.
            folder: Where drawings are saved, a folder of CSV files for each name.
        """
        self._drones = list(drones)
        self.folder = folder
        self._lock = threading.RLock()
        self._all: tuple[Drawing, ...] = ()
        self._past: list[tuple[Drawing, ...]] = []
        self._next = 1
        self.version = 0
        """Counts changes."""

    def __iter__(self) -> Iterator[Drawing]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)

    def about(self) -> dict[str, Any]:
        """Return all of them as plain data."""
        with self._lock:
            return {
                "version": self.version,
                "drawings": [drawing.as_dict() for drawing in self._all],
                "can_undo": bool(self._past),
                "saved": self.saved(),
            }

    def saved(self) -> list[str]:
        """Return the names under which drawings are saved."""
        return sorted(path.name for path in self.folder.glob("*") if path.is_dir()) if self.folder.is_dir() else []

    def find(self, key: str) -> Drawing:
        """Return a drawing.

        Raises:
            UnknownNameError: If there is none of that key.
        """
        for drawing in self._all:
            if drawing.key == key:
                return drawing
        raise UnknownNameError(f"there is no drawing '{key[:40]}' any more")

    # ---------------------------------------------------------------- changes

    def add(self, points: ArrayLike, times: ArrayLike, name: str | None = None, drone: str | None = None) -> Drawing:
        """Add a drawing; without a drone, it is for the first one that has none yet.

        Args:
            points: x, y, z (m, world), shape (m, 3).
            times: Seconds, not decreasing, shape (m,).
            name: Name of it.
            drone: Name of the drone that flies it.

        Raises:
            RangeError: If it is no curve, or there are too many.
        """
        with self._lock:
            drawing = self._made(points, times, name, drone, self._all)
            self._set((*self._all, drawing))
            return drawing

    def change(
        self, key: str, name: str | None = None, height: float | None = None, drone: str | None = None
    ) -> Drawing:
        """Change name, height (m), or drone of a drawing."""
        with self._lock:
            old = self.find(key)
            new = old
            if name is not None:
                new = replace(new, name=name)
            if height is not None:
                points = old.points.copy()
                points[:, 2] += height - points[0, 2]
                new = replace(new, points=points)
            if drone is not None:
                new = replace(new, drone=self._known(drone))
            self._set(tuple(new if drawing.key == key else drawing for drawing in self._all))
            return new

    def delete(self, key: str | None = None) -> None:
        """Delete a drawing, or all."""
        with self._lock:
            if key is not None:
                self.find(key)
            self._set(() if key is None else tuple(drawing for drawing in self._all if drawing.key != key))

    def undo(self) -> None:
        """Take back the last change.

        Raises:
            StateError: If there is none.
        """
        with self._lock:
            if not self._past:
                raise StateError("there is nothing to undo")
            self._all = self._past.pop()
            self.version += 1

    def _set(self, drawings: tuple[Drawing, ...]) -> None:
        self._past.append(self._all)
        del self._past[:-_UNDOS]
        self._all = drawings
        self.version += 1

    def _known(self, drone: str) -> str:
        if drone not in self._drones:
            raise UnknownNameError(f"there is no drone '{drone[:40]}', allowed: {', '.join(self._drones[:30])}")
        return drone

    def _made(
        self, points: ArrayLike, times: ArrayLike, name: str | None, drone: str | None, others: Sequence[Drawing]
    ) -> Drawing:
        path, clock = np.array(points, float), np.array(times, float)
        _check_curve(path, clock)
        if len(others) >= MAX_DRAWINGS:
            raise RangeError(f"there are {MAX_DRAWINGS} drawings already; delete some")
        if drone is None:
            taken = {drawing.drone for drawing in others}
            drone = next((name for name in self._drones if name not in taken), self._drones[0])
        key = f"d{self._next}"
        self._next += 1
        return Drawing(key, name or f"drawing {self._next - 1}", path, clock - clock[0], self._known(drone))

    # ---------------------------------------------------------------- files

    def save(self, name: str) -> Path:
        """Save all drawings under a name: a folder with a CSV file for each.

        Raises:
            StateError: If there is nothing to save.
        """
        with self._lock:
            if not self._all:
                raise StateError("there is nothing to save: draw something first")
            folder = self.folder / _file_name(name)
            folder.mkdir(parents=True, exist_ok=True)
            kept = set()
            for number, drawing in enumerate(self._all, start=1):
                path = folder / f"{number:02d} {_file_name(drawing.name)}.csv"
                with replacing(path) as temporary:
                    temporary.write_text(drawing.csv())
                kept.add(path)
            for path in set(folder.glob("[0-9][0-9] *.csv")) - kept:
                path.unlink()
            self.version += 1
            return folder

    def load(self, name: str, folder: Path | None = None) -> int:
        """Replace all drawings by those saved under a name; returns how many there are.

        Raises:
            UnknownNameError: If nothing is saved under it.
            RangeError: If a file is no drawing; the text names it, and line and reason.
        """
        place = (self.folder if folder is None else folder) / _file_name(name)
        files = sorted(place.glob("*.csv"))[:MAX_DRAWINGS] if place.is_dir() else []
        if not files:
            raise UnknownNameError(f"nothing is saved as '{name}', but: {', '.join(self.saved()) or 'nothing'}")
        with self._lock:
            found: list[Drawing] = []
            for path in files:
                title = re.sub(r"^\d\d ", "", path.stem)
                found.append(self._made(*_read(path), title, None, found))
            self._set(tuple(found))
            return len(found)

    def take_in(self, name: str, text: str) -> Drawing:
        """Add the drawing of the text of a CSV file.

        Raises:
            RangeError: If it is none; the text names line and reason.
        """
        import tempfile

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "drawing.csv"
            path.write_text(text)
            try:
                points, times = _read(path)
            except RangeError as error:
                raise RangeError(str(error).replace(str(path), name)) from None
        return self.add(points, times, name)


def _check_curve(path: NDArray[np.float64], clock: NDArray[np.float64]) -> None:
    """Check points (m, world), shape (m, 3), and times (s), shape (m,), of a drawing.

    Raises:
        RangeError: If they are no curve.
    """
    if path.ndim != 2 or path.shape[1:] != (3,) or not 2 <= len(path) <= MAX_POINTS or clock.shape != path.shape[:1]:
        raise RangeError(f"a drawing has shape {path.shape}, allowed: 2 to {MAX_POINTS} points x, y, z")
    if not (np.isfinite(path).all() and np.isfinite(clock).all()) or np.abs(path).max() > FARTHEST_M:
        raise RangeError(f"a drawing leaves the area: allowed: finite numbers within {FARTHEST_M:g} m")
    if (np.diff(clock) < 0.0).any():
        raise RangeError("the times of a drawing must not decrease")
    if np.linalg.norm(np.diff(path, axis=0), axis=1).sum() < 0.05:
        raise RangeError("a drawing must be at least 5 cm long")


def _read(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    drawn = read_drawn(path)
    if drawn.times is not None:
        return drawn.points, drawn.times
    # as if drawn by a steady hand
    steps = np.linalg.norm(np.diff(drawn.points, axis=0), axis=1)
    return drawn.points, np.concatenate([[0.0], np.cumsum(steps)])


def _file_name(name: str) -> str:
    """Return a name that stays within its folder."""
    return re.sub(r"[^\w .+-]", "_", name).strip(". ")[:64] or "drawing"
