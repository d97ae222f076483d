"""What keeps drones apart."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from crazychoir_fw.common.constraints import choice, number
from crazychoir_fw.control.safety import BarrierFilter
from crazychoir_fw.mission.factory import class_of
from crazychoir_fw.mission.layers.values import Options, Rate, class_word
from crazychoir_fw.mission.section import Section


class SafetyLayer(Section):
    """What keeps drones apart, whatever guidance and planning want; see docs/optimization.md."""

    filter: Annotated[str, class_word("safety")]
    """`DoubleIntegratorCBF` filters accelerations within a `HierarchicalController`, `SingleIntegratorCBF` velocities
    behind a `VelocityController`; or a class of yours."""

    distance: Annotated[float, number(0.01, 10.0, "m")] = 0.4
    """Least distance of two drones, horizontally (m)."""

    margin: Annotated[float, number(0.0, 5.0, "m")] = 0.0
    """Added to the distance for the filter (m): what real drones fall short of the filter's ideal ones."""

    gamma: Annotated[float, number(1e-6, 1e6)] | None = None
    """How fast a barrier may fall: higher brakes later; None is that of the class."""

    kappa: Annotated[float, number(1e-3, 2.0)] | None = None
    """Of accelerations: share of both drones' braking that is counted on."""

    max_acceleration: Annotated[float, number(1e-3, 10.0, "m/s^2")] | None = None
    """Of accelerations: largest one, along x and along y (m/s^2)."""

    max_braking_acceleration: Annotated[float, number(1e-3, 10.0, "m/s^2")] | None = None
    """Of accelerations: deceleration of a drone that must brake (m/s^2)."""

    max_velocity: Annotated[float, number(1e-3, 10.0, "m/s")] | None = None
    """Of velocities: largest one, along x and along y (m/s)."""

    max_braking_velocity: Annotated[float, number(1e-3, 10.0, "m/s")] | None = None
    """Of velocities: speed at which a drone that is too near backs off (m/s)."""

    keep_right: Annotated[float, number(0.0, 10.0)] = 1.0
    """Which part of what the filter takes away goes to the right: drones that block each other turn about each other.
    0 is the filter alone, behind which they may wait forever."""

    options: Options = Field(default_factory=dict)
    """Further keyword arguments of the class."""

    rate: Rate | None = None
    """Of velocities: how often the latest one is filtered (Hz), a divisor of the rate of the layers; None is that."""

    sensing_distance: Annotated[float, number(0.05, 100.0, "m")] = 3.0
    """How far a drone sees others, horizontally (m)."""

    sensing_rate: Rate | None = None
    """How often it looks (Hz), a divisor of the rate of the layers; None is that rate."""

    sees: Annotated[str, choice("odometry", "truth")] = "odometry"
    """Whether drones see others where these believe to be, or where they are."""

    @property
    def of_filter(self) -> dict[str, Any]:
        """Arguments that the mission gives the filter, beside distances, by name."""
        names = (
            "gamma",
            "kappa",
            "max_acceleration",
            "max_braking_acceleration",
            "max_velocity",
            "max_braking_velocity",
        )
        return {name: getattr(self, name) for name in names if getattr(self, name) is not None} | dict(self.options)

    def law(self) -> type[BarrierFilter]:
        """Return the class of the filter."""
        return class_of(self, "safety", "layers.safety.filter", self.filter, BarrierFilter)
