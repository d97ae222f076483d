"""What plans and what controls."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field

from crazychoir_fw.common.constraints import choice, number
from crazychoir_fw.control import CrazyflieController, FPQRSender, FRPYSender, VelSender
from crazychoir_fw.mission.factory import class_of
from crazychoir_fw.mission.layers.values import Options, Rate, class_word, law_gains
from crazychoir_fw.mission.section import Section

SENDERS = {sender.__name__: sender.kind for sender in (FPQRSender, FRPYSender, VelSender)}
"""What each sender sends."""


class PlanningLayer(Section):
    """What makes references out of points."""

    kind: Annotated[str, class_word("planning")] = Field(alias="class")
    """`Spline`, `SplinePosition`, `Polynomial7th`, `MinimumSnap`, or a class of yours."""

    options: Options = Field(default_factory=dict)
    """Further keyword arguments of the class."""


class ControlLayer(Section):
    """What turns references into commands."""

    kind: Annotated[str, class_word("control")] = Field("HierarchicalController", alias="class")
    """`HierarchicalController` or `VelocityController`."""

    position: Annotated[str, class_word("position")] = "FlatnessPositionCtrl"
    """Law of drones that follow a trajectory."""

    acceleration: Annotated[str, class_word("acceleration")] = "FlatnessAccelerationCtrl"
    """Law of drones whose guidance asks for accelerations."""

    attitude: Annotated[str, class_word("attitude")] = "GeometryAttitudeCtrl"
    """Law from attitude to body rates."""

    velocity: Annotated[str, class_word("velocity")] = "VelocityCtrlStrategy"
    """Law of a `VelocityController`."""

    sender: Annotated[str, choice(*SENDERS)] | None = None
    """`FPQRSender`, `FRPYSender`, `VelSender`; None is that of the class."""

    gains: Annotated[str | Mapping[str, Any], law_gains()] = "webots"
    """Set of gains of all laws, or {position: ..., attitude: ..., velocity: ...}."""

    mass: Annotated[float, number(0.005, 1.0, "kg")] | None = None
    """Mass that the laws believe in (kg); None is that of the vehicle."""

    rate: Rate | None = None
    """Commands per second (Hz), a divisor of the rate of the layers; None is that rate."""

    @property
    def command(self) -> str:
        """What is sent: fpqr, frpy or vel."""
        if self.sender is not None:
            return SENDERS[self.sender]
        return self.law().commands[0]

    def law(self, key: str = "layers.control.class") -> type[CrazyflieController]:
        """Return the class of the controller, named in the file at a key."""
        return class_of(self, "control", key, self.kind, CrazyflieController)
