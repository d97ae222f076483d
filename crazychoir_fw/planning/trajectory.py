"""A curve with a heading: all that a drone shall follow."""

from __future__ import annotations

import numpy as np

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Reference
from crazychoir_fw.planning.curves import Polynomial
from crazychoir_fw.planning.headings import FixedHeading, Heading


class Trajectory:
    """What to follow over the time since the begin; a value, never changed."""

    def __init__(self, curve: Polynomial, heading: Heading | None = None) -> None:
        if curve.axes != 3:
            raise RangeError(f"Trajectory: the curve has {curve.axes} axes, allowed: x, y and z")
        self.curve = curve
        self.heading = heading or FixedHeading()
        self.duration = curve.duration
        end, zero = np.array(curve.end()), np.zeros(3)
        end.flags.writeable = zero.flags.writeable = False
        self._held = Reference(end, zero, zero, zero, self.heading.at(curve.duration)[0], 0.0)

    def reference(self, time: float) -> Reference:
        """Return the full reference at *time* (s); after the end, hovering there."""
        if time > self.duration:
            return self._held
        position, velocity, acceleration, jerk = self.curve.flat(time)
        yaw, yaw_rate = self.heading.at(time)
        return Reference(position, velocity, acceleration, jerk, yaw, yaw_rate)
