"""Which parts a recorded flight has: take-off, hover, trajectory, landing.

Only commands are looked at where they exist, so that a flight that went badly is cut like one that went well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.comparison.nanobench import PERIOD, RecordedFlight
from crazychoir_fw.comparison.signals import Array

_AIRBORNE = 0.05  # [m] above the place where it stood
_RUNNING = 5000.0  # [counts], mean of the motors
_LEAVES = 0.02  # [m], by which a setpoint must leave the hover to begin a trajectory
_RESTS = 0.5  # [s], for which a setpoint must rest after take-off
_APPROACH = 1.0  # [s] of the path before the trajectory that is compared


@dataclass(frozen=True)
class Phases:
    """Times (s) within a flight; each not after the next."""

    motors_on: float
    """First command to the motors; 0 when they run from the start."""
    airborne: float
    """It has left the floor."""
    rest: float
    """The setpoint of the take-off rests; the drone still comes up to it."""
    hover: float
    """The setpoint of the take-off rests and the drone has had time to follow."""
    trajectory: float
    """The setpoint leaves the hover; the end of the flight when it never does."""
    end: float
    """Of the trajectory: before landing, before a null setpoint, or where the recording ends."""
    starts_on_floor: bool
    """Whether the recording shows the take-off from its beginning."""
    null_setpoint: float | None
    """When a null setpoint came between trajectory and landing, or None."""

    @property
    def compared(self) -> tuple[float, float]:
        """Where paths are compared: from one second before the trajectory to its end."""
        return max(self.hover, self.trajectory - _APPROACH), self.end

    @property
    def hovering(self) -> tuple[float, float]:
        """Where it hovers: it has had half of the rest for getting there."""
        return self.hover, self.trajectory

    @property
    def resting(self) -> tuple[float, float]:
        """Where the setpoint rests: what may be taken from a flight is taken here."""
        return self.rest, self.trajectory


def find_phases(flight: RecordedFlight) -> Phases:
    """Cut a flight into its parts.

    Raises:
        RangeError: If it has no motors, or never leaves the floor.
    """
    if flight.motors is None:
        raise RangeError(f"{flight.name}: motors not recorded, so that nobody knows when it flew")
    time, height = flight.time, flight.position[:, 2]
    running = flight.motors.mean(axis=1) > _RUNNING
    if not running.any():
        raise RangeError(f"{flight.name}: the motors never run")
    on = int(np.argmax(running))
    off = len(running) - 1 - int(np.argmax(running[::-1]))
    floor = float(np.median(height[: max(on, 1)])) if on > 20 else float(height.min())
    above = height > floor + _AIRBORNE
    above[:on] = False
    if not above.any():
        raise RangeError(f"{flight.name}: it never leaves the floor")
    airborne = int(np.argmax(above))

    if flight.setpoint is None:
        rest = min(airborne + 200, off)
        return _phases(time, on, airborne, (rest, off), off, on > 20, None)
    rest, left = _rest(flight.setpoint, airborne, off)
    end, null = _end(flight.setpoint, left, off)
    return _phases(time, on, airborne, (rest, left), end, on > 20, null)


def _phases(
    time: Array, on: int, airborne: int, resting: tuple[int, int], end: int, on_floor: bool, null: int | None
) -> Phases:
    end = max(end, airborne + 1)
    left = min(max(resting[1], airborne), end)
    rest = min(max(resting[0], airborne), left)
    return Phases(
        motors_on=float(time[on]),
        airborne=float(time[airborne]),
        rest=float(time[rest]),
        # half of the time is left to the drone for getting there
        hover=float(time[(rest + left) // 2]),
        trajectory=float(time[left]),
        end=float(time[end]),
        starts_on_floor=on_floor,
        null_setpoint=None if null is None else float(time[null]),
    )


def _rest(setpoint: Array, airborne: int, off: int) -> tuple[int, int]:
    """Return where the setpoint begins to rest and where it leaves that place."""
    rows = round(_RESTS / PERIOD)
    for row in range(airborne, max(off - rows, airborne + 1)):
        window = setpoint[row : row + rows]
        if np.ptp(window, axis=0).max() < _LEAVES / 4 and window[0, 2] > 0.2:
            place = np.median(window, axis=0)
            away = np.linalg.norm(setpoint[row:off] - place, axis=1) > _LEAVES
            left = row + int(np.argmax(away)) if away.any() else off
            return row, left
    # the setpoint never rests
    return airborne, airborne


def _end(setpoint: Array, left: int, off: int) -> tuple[int, int | None]:
    """Return the row where a trajectory ends, and that of a null setpoint."""
    height = setpoint[:, 2]
    span: Array = height[left : off + 1]
    if len(span) < 3:
        return off, None
    # a null setpoint asks for (0, 0, 0) for a moment: a spike towards the floor, there and back
    drop = np.concatenate([[False], np.diff(span) < -0.1])
    null = None
    for row in np.flatnonzero(drop).tolist():
        back = span[row : row + 30]
        if len(back) and back.max() > span[row - 1] - 0.1 and span[row - 1] > 0.3:
            null = left + row
            break
    last = off if null is None else null
    # landing: the setpoint comes down to the floor without a rest; its beginning ends the trajectory
    row = last
    if null is None and height[off] < 0.25 * max(height[left], 0.3):
        while row > left and height[row] < 0.25 * height[left]:
            row -= 1
        while row > left and height[row - 1] > height[row] + 1e-5:
            row -= 1
    elif null is None:
        row = _interrupted_landing(setpoint, left, last)
    # a setpoint that rests before landing is no trajectory any more; half a second of it is kept
    place = setpoint[max(row - 2, left)]
    while row > left and np.linalg.norm(setpoint[max(row - 50, left)] - place) < _LEAVES:
        row -= 1
    return max(row, left), null


def _interrupted_landing(setpoint: Array, left: int, off: int) -> int:
    """Return where a straight descent begins in which a recording ends, or its last row when there is none."""
    row = off
    while row > left and setpoint[row - 1, 2] >= setpoint[row, 2] - 1e-6:
        if np.linalg.norm(setpoint[row - 1, :2] - setpoint[off, :2]) > _LEAVES / 4:
            break
        row -= 1
    is_landing = (off - row) * PERIOD > 0.3 and setpoint[row, 2] - setpoint[off, 2] > 0.15
    return row if is_landing else off
