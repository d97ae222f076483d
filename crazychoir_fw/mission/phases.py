"""The phases of a flight, as the list `flight` of a mission file names them.

Without layers, phases are maneuvers of the planners on board. With layers they are buttons: guidance climbs, flies and
lands as its class says, and a phase lasts until the next one.
"""

from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, PrivateAttr, StrictBool, ValidationInfo, model_validator

from crazychoir_fw.common.constraints import number, point, whole
from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.common.trajectory_files import MEMORY_PIECES, read_pieces, read_points
from crazychoir_fw.mission.section import OneOf, Section
from crazychoir_fw.mission.values import beside, refusal

MAX_POINTS = 10_000

Height = Annotated[float, number(0.05, 100.0, "m")]
Duration = Annotated[float, number(0.1, 3600.0, "s")]
Stagger = Annotated[float, number(-10.0, 10.0, "m")]
Angle = Annotated[float, number(-360.0, 360.0, "deg")]
Coefficients = Annotated[tuple[Annotated[float, number(-1e6, 1e6)], ...], Field(min_length=1, max_length=8)]


class Maneuver(Section):
    """What all phases share."""

    drones: Annotated[list[str], Field(min_length=1)] | None = None
    """Ids of the drones that do it; the others hold their place. Without it, all drones."""


class Takeoff(Maneuver):
    """Climb vertically from the floor."""

    height: Height = 0.5
    """Height to reach (m, world frame)."""

    duration: Duration = 2.0
    """Time to get there (s)."""

    stagger: Stagger = 0.0
    """Height added from one drone to the next (m)."""


class Hover(Maneuver):
    """Hold the place."""

    duration: Duration
    """How long (s)."""


class GoTo(Maneuver):
    """Move to one point, at rest at its end."""

    position: Annotated[tuple[float, ...], point("x", "y", "z", floor=0.0)] | None = None
    """Where to (m, world frame): for one drone."""

    offset: Annotated[tuple[float, ...], point("dx", "dy", "dz")] | None = None
    """How far from the present place (m, world frame)."""

    yaw_deg: Angle | None = None
    """Heading at the end; without it, the heading stays."""

    duration: Duration
    """Time to get there (s)."""

    linear: StrictBool = False
    """Constant speed instead of a smooth start and end."""

    @model_validator(mode="after")
    def _one_goal(self) -> "GoTo":
        if (self.position is None) == (self.offset is None):
            raise refusal("a mapping with either position or offset")
        return self


class Route(Maneuver):
    """Fly through a list of points, each drone around its own start."""

    points: Annotated[list[Annotated[tuple[float, ...], point("x", "y", "z", floor=0.0)]], Field(min_length=1)]
    """[x, y] from the start of the drone and height z above the floor (m)."""

    leg_duration: Duration
    """Time from one point to the next (s)."""

    stagger: Stagger = 0.0
    """Height added from one drone to the next (m)."""

    linear: StrictBool = False
    """Constant speed instead of a smooth start and end of each leg."""


class Piece(Section):
    """One polynomial piece, written into the mission file."""

    duration: Annotated[float, number(0.01, 1000.0, "s")]
    """Duration (s)."""

    x: Coefficients
    """Coefficients in ascending powers of time (m, m/s, …)."""

    y: Coefficients = (0.0,)
    """See x."""

    z: Coefficients = (0.0,)
    """See x."""

    yaw: Coefficients = (0.0,)
    """See x (rad, rad/s, …)."""

    def row(self) -> list[float]:
        """Return the 33 numbers of the piece in the layout of the trajectory memory."""
        axes = [axis + (0.0,) * (8 - len(axis)) for axis in (self.x, self.y, self.z, self.yaw)]
        return [*(value for axis in axes for value in axis), self.duration]


class Trajectory(Maneuver):
    """Upload piecewise polynomials and let the onboard planner fly them."""

    file: str | None = None
    """Trajectory file, seen from the folder of the mission file."""

    pieces: Annotated[list[Piece], Field(min_length=1, max_length=MEMORY_PIECES)] | None = None
    """The same, written into the mission file."""

    time_scale: Annotated[float, number(0.1, 100.0)] = 1.0
    """Factor on all durations: 2 is half as fast."""

    relative: StrictBool = True
    """Begin where the drone is; otherwise the polynomials are world coordinates."""

    reversed: StrictBool = False
    """Fly it backwards."""

    repeat: Annotated[int, whole(1, 1000)] = 1
    """How many times in a row."""

    _rows: NDArray[np.float32] = PrivateAttr()

    @model_validator(mode="after")
    def _read(self, info: ValidationInfo) -> "Trajectory":
        if (self.file is None) == (self.pieces is None):
            raise refusal("a mapping with either file or pieces")
        if self.pieces is not None:
            self._rows = np.array([piece.row() for piece in self.pieces], dtype=np.float32)
        else:
            self._rows = read_pieces(beside(self.file, info))
        return self

    @property
    def rows(self) -> NDArray[np.float32]:
        """The pieces in the layout of the trajectory memory, shape (n, 33)."""
        return self._rows


class Land(Maneuver):
    """Descend vertically, then switch the motors off."""

    height: Annotated[float, number(0.0, 100.0, "m")] = 0.0
    """Height above the start at which the motors stop (m)."""

    duration: Duration = 2.0
    """Time to get there (s)."""


class Phase(OneOf):
    """One entry of `flight`: a name, and what is set under it."""

    @property
    def maneuver(self) -> Any:
        """What is set under the name of the phase."""
        return getattr(self, self.name)

    @property
    def orders(self) -> list[Any]:
        """What is given at its beginning: itself, or what it holds together."""
        together = getattr(self, "together", None)
        return [self] if together is None else [order for child in together for order in child.orders]


class PhaseEntry(Phase):
    """One entry of `flight` of a mission without layers: exactly one of these keys."""

    takeoff: Takeoff | None = None
    hover: Hover | None = None
    go_to: GoTo | None = None
    route: Route | None = None
    trajectory: Trajectory | None = None
    land: Land | None = None
    together: Annotated[list["PhaseEntry"], Field(min_length=1)] | None = None
    """Phases of different drones that begin at the same time; it ends with the longest."""


# -------------------------------------------------------------------------------- with layers

Wait = Annotated[float, number(0.0, 36000.0, "s")]


class TakeoffButton(Maneuver):
    """Climb from the floor."""

    duration: Wait = 5.0
    """Time until the next entry (s)."""


class StartButton(Maneuver):
    """Let the guidance do what it is for."""

    duration: Wait
    """Time until the next entry (s)."""


class LandButton(Maneuver):
    """Descend; motors stop on the floor."""

    duration: Wait = 5.0
    """Time until the next entry (s)."""


class HoverButton(Section):
    """Press nothing for a while."""

    duration: Wait
    """How long (s)."""


class StopButton(Maneuver):
    """Motors off at once."""

    duration: Wait = 0.0
    """Time until the next entry (s)."""


class GoToButton(Maneuver):
    """Hand one point to the trajectory handler."""

    position: Annotated[tuple[float, ...], point("x", "y", "z", floor=0.0)]
    """Where to (m, world)."""

    duration: Duration
    """Time to get there (s), and until the next entry."""


class GoToStartButton(Maneuver):
    """Hover above the starts of the mission, for drones that took off elsewhere.

    Drones that follow their guidance, and no trajectory handler, stay where they are.
    """

    duration: Wait = 5.0
    """Time until the next entry (s), or as long as the slowest needs."""


class TrajectoryButton(Maneuver):
    """Hand a drawn curve to the trajectory handler."""

    file: str | None = None
    """CSV file with columns time (s), x, y, z (m), seen from the folder of the mission file."""

    points: list[Annotated[tuple[float, ...], point("time", "x", "y", "z")]] | None = None
    """The same, written into the mission file."""

    _rows: list[tuple[float, ...]] = PrivateAttr()

    @model_validator(mode="after")
    def _read(self, info: ValidationInfo) -> "TrajectoryButton":
        if (self.file is None) == (self.points is None):
            raise refusal("a mapping with either file or points")
        if self.points is not None:
            where, rows = "points", list(self.points)
        else:
            where = str(beside(self.file, info))
            rows = read_points(Path(where))
        _check_times(where, rows)
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


class LayeredPhase(Phase):
    """One entry of `flight` of a mission with layers: exactly one of these keys."""

    takeoff: TakeoffButton | None = None
    start: StartButton | None = None
    hover: HoverButton | None = None
    go_to: GoToButton | None = None
    go_to_start: GoToStartButton | None = None
    trajectory: TrajectoryButton | None = None
    land: LandButton | None = None
    stop: StopButton | None = None
    together: Annotated[list["LayeredPhase"], Field(min_length=1)] | None = None
    """Buttons for different drones that are pressed at the same time; it ends with the longest."""

    @property
    def duration(self) -> float:
        """Time until the next entry (s)."""
        return max(float(order.maneuver.duration) for order in self.orders)


def _check_times(where: str, rows: list[tuple[float, ...]]) -> None:
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
