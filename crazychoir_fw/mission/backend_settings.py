"""What the backends `integrator` and `hardware` are like."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field
from pydantic_core import core_schema as schemas

from crazychoir_fw.common.constraints import Constraint, choice, choices, listed, number, point
from crazychoir_fw.mission.layers.values import Options
from crazychoir_fw.mission.mixed import MocapSettings
from crazychoir_fw.mission.section import Section

_COEFFICIENT = schemas.float_schema(ge=0.0, le=10.0, strict=True)
DRAG = Constraint(
    schemas.nullable_schema(
        schemas.union_schema([schemas.literal_schema(["rotor"]), listed(schemas.tuple_schema([_COEFFICIENT] * 3))])
    ),
    "rotor, or three numbers in [0, 10] N s/m",
)


class Disturbance(Section):
    """A random force."""

    sigma: Annotated[float, number(0.0, 10.0, "N")]
    """Standard deviation per axis (N)."""

    time_constant: Annotated[float, number(0.0, 1000.0, "s")] = 1.0
    """Correlation time (s)."""


class IntegratorSettings(Section):
    """What the backend `integrator` is like."""

    drag: Annotated[Any, DRAG] = None
    """Rotor drag: `rotor`, three coefficients (N s/m) along body x, y, z, or none."""

    disturbance: Disturbance | None = None
    """Random force on each drone."""


class SafetyBox(Section):
    """The box that real drones are kept in."""

    low: Annotated[tuple[float, ...], point("x", "y", "z")]
    """Lowest corner (m, world)."""

    high: Annotated[tuple[float, ...], point("x", "y", "z")]
    """Highest corner (m, world)."""

    breach: Annotated[str, choice("land", "stop", "report")] = "land"
    """What happens to a drone that leaves it."""


class HardwareSettings(Section):
    """How the backend `hardware` flies."""

    odometry_hz: Annotated[float, number(10.0, 100.0, "Hz")] = 100.0
    """Rate at which drones log their poses (Hz)."""

    safety_area: SafetyBox | None = None
    """Box that drones are kept in."""

    start_tolerance_m: Annotated[float, number(0.01, 100.0, "m")] = 0.3
    """How far from its start in the mission a drone may stand before the flight (m), on the floor."""

    least_battery_v: Annotated[float, number(0.0, 5.0, "V")] = 3.5
    """Voltage that the battery of a drone must have before the flight (V)."""

    accept: Annotated[tuple[str, ...], choices("places", "names", "mixture")] = ()
    """What is not checked before the flight: `places`, drones take off where they stand; `names`, served simulations
    may have other drones; `mixture`, simulations may answer for some of the real drones."""

    radio: Options = Field(default_factory=dict)
    """Further options of the radio handler, see `crazychoir_fw.radio.Options`."""

    mocap: MocapSettings | None = None
    """Motion capture; drones with `mocap` receive their poses from it."""
