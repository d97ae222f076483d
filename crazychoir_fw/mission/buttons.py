"""The list `flight` of a mission with layers: who presses which button, and for how long nothing else happens."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, PrivateAttr, ValidationInfo, model_validator

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.mission.section import OneOf, Section
from crazychoir_fw.mission.values import beside, number, point, refusal

Duration = Annotated[float, number(0.0, 36000.0, "s")]
LARGEST_FILE = 1_000_000  # bytes
MAX_POINTS = 10_000


class Button(Section):
    """What all entries share."""

    drones: Annotated[list[str], Field(min_length=1)] | None = None
    """Ids of the drones whose button is pressed; all without it."""


class TakeoffButton(Button):
    """Climb from the floor."""

    duration: Duration = 5.0
    """Time until the next entry (s)."""


class StartButton(Button):
    """Let the guidance do what it is for."""

    duration: Duration
    """Time until the next entry (s)."""


class LandButton(Button):
    """Descend; motors stop on the floor."""

    duration: Duration = 5.0
    """Time until the next entry (s)."""


class HoverButton(Section):
    """Press nothing for a while."""

    duration: Duration
    """How long (s)."""


class StopButton(Button):
    """Motors off at once."""

    duration: Duration = 0.0
    """Time until the next entry (s)."""


class GoToButton(Button):
    """Hand one point to the trajectory handler."""

    position: Annotated[tuple[float, ...], point("x", "y", "z", floor=0.0)]
    """Where to (m, world)."""

    duration: Annotated[float, number(0.1, 3600.0, "s")]
    """Time to get there (s), and until the next entry."""


class TrajectoryButton(Button):
    """Hand a drawn curve to the trajectory handler."""

    file: str | None = None
    """CSV file with columns time (s), x, y, z (m), seen from the folder of the mission file."""

    points: list[Annotated[tuple[float, ...], point("time", "x", "y", "z")]] | None = None
    """The same, written into the mission file."""

    _rows: list[tuple[float, ...]] = PrivateAttr()

    @model_validator(mode="after")
    def _read(self, info: ValidationInfo) -> TrajectoryButton:
        if (self.file is None) == (self.points is None):
            raise refusal("a mapping with either file or points")
        if self.points is not None:
            where, rows = "points", list(self.points)
        else:
            where = str(beside(self.file, info))
            rows = read_points(Path(where))
        check_times(where, rows)
        self._rows = rows
        return self

    @property
    def rows(self) -> list[tuple[float, ...]]:
        """Time (s) and position (m, world) of the points, four numbers each."""
        return self._rows

    @property
    def duration(self) -> float:
        """Time until the next entry (s)."""
        return self._rows[-1][0]


class ButtonPhase(OneOf):
    """One entry of `flight`: exactly one of these keys."""

    takeoff: TakeoffButton | None = None
    start: StartButton | None = None
    hover: HoverButton | None = None
    go_to: GoToButton | None = None
    trajectory: TrajectoryButton | None = None
    land: LandButton | None = None
    stop: StopButton | None = None

    @property
    def name(self) -> str:
        """Name of the button, such as "takeoff"."""
        return next(iter(self.model_fields_set))

    @property
    def button(self) -> Any:
        """What is set under that name."""
        return getattr(self, self.name)


def read_points(path: Path) -> list[tuple[float, ...]]:
    """Read a CSV file with the columns time (s), x, y, z (m); a heading and lines with # are left out.

    Raises:
        MissionError: If the file is no such file; the text names file, line and what is wrong.
    """
    try:
        text = path.read_bytes()[:LARGEST_FILE].decode()
    except OSError as error:
        raise MissionError(f"{path} cannot be read: {error.strerror}") from None
    except ValueError:
        raise MissionError(f"{str(path)!r} is not a text file") from None
    rows = []
    for number_of_line, cells in enumerate(csv.reader(text.splitlines()), start=1):
        if not cells or cells[0].lstrip().startswith("#") or cells[0].strip().lower() in ("t", "time", "time_s"):
            continue
        try:
            row = tuple(float(cell) for cell in cells if cell.strip())
        except ValueError:
            row = ()
        if len(row) != 4 or not all(math.isfinite(value) and abs(value) <= 36000.0 for value in row):
            raise MissionError(f"{path}, line {number_of_line}: allowed: four numbers, time (s), x, y, z (m)")
        rows.append(row)
    return rows


def check_times(where: str, rows: list[tuple[float, ...]]) -> None:
    """Refuse points whose times do not increase from 0 on.

    Raises:
        MissionError: With the first wrong one.
    """
    if not 1 <= len(rows) <= MAX_POINTS:
        raise MissionError(f"{where} has {len(rows)} points, allowed: 1 to {MAX_POINTS}")
    before = -1.0
    for i, row in enumerate(rows):
        if not (row[0] > before and row[0] >= 0.0):
            raise MissionError(f"{where}: point {i} comes at {row[0]:g} s, allowed: times that increase from 0 on")
        before = row[0]
    if not rows[-1][0] > 0.0:
        raise MissionError(f"{where} ends at 0 s, allowed: a last point after it")
