"""From the control layer of a mission to its control laws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from crazychoir_fw import control
from crazychoir_fw.flight.mixed_reference_ctrl import MixedReferenceCtrl
from crazychoir_fw.flight.safe_group import SafeBothFlatnessLaws
from crazychoir_fw.flight.safety_filters import make_safety_filter
from crazychoir_fw.mission.factory import build, changed_gains, class_of

if TYPE_CHECKING:
    from crazychoir_fw.mission.layers import ControlLayer
    from crazychoir_fw.mission.schema import LayeredMission

GRAVITY = 9.81
"""Acceleration of gravity of both simulations (m/s^2)."""

_CONTROL_GAINS = {
    "position": (control.POSITION_GAINS, control.PositionGains),
    "attitude": (control.ATTITUDE_GAINS, control.AttitudeGains),
    "velocity": (control.VELOCITY_GAINS, control.VelocityGains),
}


class LawMaker:
    """Makes the control laws of one control layer, for a drone or for several at once."""

    def __init__(self, mission: LayeredMission, layer: ControlLayer, where: str, mass: Any) -> None:
        """Take over what all laws are made from.

        Args:
            mission: The mission.
            layer: Its control layer.
            where: Where that stands in the file.
            mass: Of the drone, or of each of several, (N,); kg.
        """
        self.safe = make_safety_filter(mission)
        """What keeps positions apart, or None."""
        self._layer, self._where = layer, where
        self._known = {
            "update_frequency": float(layer.rate or mission.layers.rate),
            "mass": mass,
            "gravity": GRAVITY,
            "safety_filter": self.safe,
        }

    def velocity(self) -> Any:
        """Return what turns poses into velocities."""
        return self._made("velocity", self._layer.velocity, "velocity", None)

    def position(self, follows: str) -> Any:
        """Return what turns references of a kind into thrust and attitude."""
        role = "acceleration" if follows == "acceleration" else "position"
        return self._made(role, getattr(self._layer, role), "position", control.PositionCtrlStrategy)

    def both_positions(self, i: Sequence[int], accelerated: Sequence[int]) -> Any:
        """Return the flatness laws of drones of which some follow accelerations, as one law.

        Args:
            i: Numbers of the drones.
            accelerated: Which of them follow accelerations; the others follow full states.
        """
        position = self.position("fullstate")
        who = np.isin(i, accelerated)
        arguments = {name: value for name, value in self._known.items() if name != "safety_filter"}
        arguments |= {"gains": position.gains, "mass": position.mass}
        if self.safe is None:
            return MixedReferenceCtrl(who, **arguments)
        return SafeBothFlatnessLaws(who, self.safe, **arguments)

    def attitude(self) -> Any:
        """Return what turns attitudes into body rates, or None where the drones do it themselves."""
        if self._layer.command != "fpqr":
            return None
        return self._made("attitude", self._layer.attitude, "attitude", control.AttitudeCtrlStrategy)

    def _made(self, role: str, word: str, gains: str, base: Any) -> Any:
        key = f"{self._where}.{role}"
        cls: Any = class_of(self._layer, role, key, word, base)
        if self.safe is not None and hasattr(cls, "with_filter"):
            cls = cls.with_filter()
        sets, kind = _CONTROL_GAINS[gains]
        given = self._layer.gains
        chosen = given if isinstance(given, str) else given.get(gains, "webots")
        if isinstance(chosen, Mapping):
            chosen = changed_gains(f"{self._where}.gains.{gains}", chosen, sets, kind, "webots")
        return build(cls, key, {**self._known, "gains": chosen}, {})
