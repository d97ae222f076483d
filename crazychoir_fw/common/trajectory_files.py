"""Trajectory files: pieces for the planner on board, and points for trajectory handlers.

Pieces are polynomials of degree 7 of x, y, z and yaw. Their file has one line per piece: its duration, then the
coefficients in ascending powers of time, axis after axis, `duration, x^0 … x^7, y^0 … y^7, z^0 … z^7, yaw^0 … yaw^7`
(33 columns, after a heading). A piece in the trajectory memory of a Crazyflie holds the same numbers with the duration
last (docs/reference/planner-commander.md#4.1).
"""

import csv
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.common.reading import read_text

MEMORY_PIECES = 31
"""Pieces that the trajectory memory of a Crazyflie holds: 4096 bytes, 132 per piece."""

COLUMNS = ["duration", *(f"{axis}^{power}" for axis in ("x", "y", "z", "yaw") for power in range(8))]
LARGEST_FILE = 1_000_000  # bytes


def read_pieces(path: Path) -> NDArray[np.float32]:
    """Read a trajectory file.

    Returns:
        Pieces in the layout of the trajectory memory, shape (n, 33): coefficients, then duration (s).

    Raises:
        MissionError: If the file is no trajectory; the text names file, line and what is wrong.
    """
    pieces = []
    for number, line in enumerate(read_text(path, LARGEST_FILE, MissionError).splitlines(), start=1):
        if line.strip() and not line.lower().startswith(("#", "duration")):
            pieces.append(_piece(line, f"{path}, line {number}"))
    if not 1 <= len(pieces) <= MEMORY_PIECES:
        raise MissionError(f"{path} has {len(pieces)} pieces, but a Crazyflie remembers 1 to {MEMORY_PIECES}")
    return np.array(pieces, dtype=np.float32)


def read_points(path: Path) -> list[tuple[float, ...]]:
    """Read a CSV file with the columns time (s), x, y, z (m); a heading and lines with # are left out.

    Raises:
        MissionError: If the file is no such file; the text names file, line and what is wrong.
    """
    text = read_text(path, LARGEST_FILE, MissionError)
    rows: list[tuple[float, ...]] = []
    for number_of_line, line in enumerate(text.splitlines(), start=1):
        try:
            cells = next(csv.reader([line]), [])
            if not cells or cells[0].lstrip().startswith("#") or cells[0].strip().lower() in ("t", "time", "time_s"):
                continue
            row: tuple[float, ...] = tuple(float(cell) for cell in cells if cell.strip())
        except (ValueError, csv.Error):
            row = ()
        if len(row) != 4 or not all(math.isfinite(value) and abs(value) <= 36000.0 for value in row):
            raise MissionError(f"{path}, line {number_of_line}: allowed: four numbers, time (s), x, y, z (m)")
        rows.append(row)
    return rows


def write_pieces(path: Path, pieces: NDArray[np.float32]) -> None:
    """Write *pieces*, shape (n, 33) in the layout of the trajectory memory, as a trajectory file."""
    rows = np.roll(pieces, 1, axis=1)
    lines = [",".join(COLUMNS), *(",".join(f"{value:.7g}" for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n")


def total_duration(pieces: NDArray[np.float32]) -> float:
    """Return the duration (s) of *pieces*, shape (n, 33)."""
    return float(pieces[:, 32].sum(dtype=np.float64))


def end_points(pieces: NDArray[np.float32]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return [x, y, z, yaw] (m, rad) at the beginning and at the end of *pieces*, shape (n, 33)."""
    exact = pieces.astype(np.float64)
    first, last = exact[0, :32].reshape(4, 8), exact[-1, :32].reshape(4, 8)
    return first[:, 0], last @ exact[-1, 32] ** np.arange(8)


def _piece(line: str, where: str) -> list[float]:
    """Return one line in the layout of the trajectory memory."""
    cells = line.rstrip().rstrip(",").split(",")
    if len(cells) != len(COLUMNS):
        raise MissionError(
            f"{where} has {len(cells)} columns, but must have {len(COLUMNS)}: duration, x^0 to x^7, y, z, yaw"
        )
    values = []
    for name, cell in zip(COLUMNS, cells, strict=True):
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        low = 0.01 if name == "duration" else -1e6
        high = 1000.0 if name == "duration" else 1e6
        if not low <= value <= high:
            raise MissionError(f"{where}: {name} is {cell.strip()[:40]!r}, but must be a number in [{low:g}, {high:g}]")
        values.append(value)
    return values[1:] + values[:1]
