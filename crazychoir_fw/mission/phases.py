"""The phases of a flight, as the list `flight` of a mission file names them."""

from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, PrivateAttr, StrictBool, ValidationInfo, model_validator

from crazychoir_fw.common.trajectory_files import MEMORY_PIECES, read_pieces
from crazychoir_fw.mission.section import OneOf, Section
from crazychoir_fw.mission.values import beside, number, point, refusal, whole

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


class PhaseEntry(OneOf):
    """One entry of `flight`: exactly one of these keys."""

    takeoff: Takeoff | None = None
    hover: Hover | None = None
    go_to: GoTo | None = None
    route: Route | None = None
    trajectory: Trajectory | None = None
    land: Land | None = None
    together: Annotated[list["PhaseEntry"], Field(min_length=1)] | None = None
    """Phases of different drones that begin at the same time; it ends with the longest."""

    @property
    def name(self) -> str:
        """Name of the phase, such as "takeoff"."""
        return next(iter(self.model_fields_set))

    @property
    def maneuver(self) -> "Maneuver | list[PhaseEntry]":
        """What is set under that name."""
        return getattr(self, self.name)
