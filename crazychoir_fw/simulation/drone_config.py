"""What is chosen for one drone before a world is built."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.onboard import vehicles
from crazychoir_fw.simulation.motor_ctrl_words import class_name, properties_text, require_class

BODY_PARAMETERS = ("mass", "inertia", "products_of_inertia")
"""Parameters of a vehicle that MuJoCo's body has, not the engine plugin."""

DECKS = ("multiranger", "zranger")
"""Decks that a drone may carry beside the one that positions it."""


@dataclass
class DroneConfig:
    """One drone of a world. What is left at None follows the platform.

    The fields from `platform` on become attributes of the engine plugin, which checks them; `crazychoir info` and
    docs list names and ranges.
    """

    id: str
    """Name of the drone; also the name of its body in the model."""
    position: tuple[float, float] | tuple[float, float, float | None] = (0.0, 0.0, None)
    """Start position (m, world). Without a height the drone stands on the floor."""
    yaw_deg: float = 0.0
    """Start yaw (deg, counter-clockwise seen from above)."""
    color: tuple[float, float, float] | None = None
    """Color of the accents (red, green, blue in [0, 1]); by default each drone gets its own."""
    mass: float | None = None
    """Mass (kg); by default that of the vehicle model. The inertia scales along."""
    vehicle: vehicles.Overrides = field(default_factory=dict)
    """Parameters of the vehicle that differ from the platform's, by dotted name (``{"rotors.thrust_scale": 0.95}``), a
    YAML file with such, ``kit``, ``legacy`` or ``nanobench``, or a list of these. `crazychoir vehicle` lists them."""
    payload: Mapping[str, Any] | None = None
    """What it carries: ``{"mass": kg, "offset": (x, y, z) m, "detachable": bool}``, the offset in the body frame."""

    platform: str = "cf2"
    """Airframe: ``cf2`` (Crazyflie 2.1+) or ``cf21bl`` (2.1 Brushless)."""
    provider: str = "builtin"
    """Implementation of the onboard algorithms: ``builtin``, ``bitcraze`` for the checkout of the real firmware, or the
    name of a library that was loaded (`crazychoir_fw.onboard.core.load_library`)."""
    app: str | Path | Sequence[str | Path] = ()
    """C files with a controller or an estimator of the user's. The world compiles them."""
    controller: str | None = None
    """Controller at boot: ``pid``, ``mellinger``, ``indi``, ``brescianini``, ``lee`` or ``out_of_tree``, that of the
    app; by default that of the app, if it brings one, else ``pid``."""
    estimator: str | None = None
    """State estimator at boot: ``kalman``, ``complementary`` or ``out_of_tree``; by default that of the app, if it
    brings one, else what the positioning asks for."""
    positioning: str | None = None
    """``mocap`` (default), ``mocap_position``, ``lighthouse``, ``loco_twr``, ``loco_tdoa2``, ``loco_tdoa3``, ``flow``
    or ``none``."""
    mocap_quality: str | None = None
    """How good the motion capture is: ``good`` (default), ``typical`` or ``poor``; it chooses the defaults of the
    attributes ``mocap_…``."""
    decks: Sequence[str] = ()
    """Decks beside the one that positions the drone: ``multiranger``, ``zranger``."""
    battery: float | None = None
    """State of charge at the start, in [0, 1]."""
    noise: float | None = None
    """Factor on the noise of the inertial sensors; 0 is ideal."""
    parameters: Mapping[str, float | int] = field(default_factory=dict)
    """Onboard parameters that a client sets at the start, such as ``{"colAv.enable": 1}``; a reboot forgets them."""
    attributes: Mapping[str, str | float | int | Sequence[float]] = field(default_factory=dict)
    """Any further attribute of the engine plugin, such as ``mocap_noise`` (m) or ``anchor0`` (x, y, z in m)."""
    motor_ctrl: str | type | None = None
    """Python class that flies the drone: a subclass of `MotorCtrl`, or its name as ``MotorCtrlFPQR``,
    ``package.module:Class`` or ``path/to/file.py:Class``."""
    motor_ctrl_properties: Mapping[str, str | float | int] = field(default_factory=dict)
    """Properties that the class receives."""

    def plugin_attributes(self) -> dict[str, str]:
        """Return the attributes for the engine plugin as text.

        Mass and inertia are left out: they belong to the body.
        """
        chosen = {name: value for name, value in self.overrides().items() if name not in BODY_PARAMETERS}
        named = {
            "platform": self.platform,
            "vehicle": vehicles.as_text(chosen) or None,
            "provider": self.provider,
            "controller": self.controller,
            "estimator": self.estimator,
            "positioning": self.positioning,
            "mocap_quality": self.mocap_quality,
            "battery": self.battery,
            "noise": self.noise,
            **self._remarks(),
        }
        if isinstance(self.decks, str) or not isinstance(self.decks, Sequence):
            raise RangeError(f"{self.id}: decks is {self.decks!r}, allowed: a list of {', '.join(DECKS)}")
        for deck in self.decks:
            if deck not in DECKS:
                raise UnknownNameError(f"{self.id}: decks names '{deck}', allowed: {', '.join(DECKS)}")
        every = {**named, **dict.fromkeys(self.decks, "on"), **self.attributes}
        return {name: _text(value) for name, value in every.items() if value is not None}

    def overrides(self) -> dict[str, vehicles.Value]:
        """Return the parameters of the vehicle that differ from the platform's, checked.

        Raises:
            RangeError: If a value is outside its range.
            UnknownNameError: If there is no such parameter or file.
        """
        try:
            return vehicles.overrides(self.vehicle) if self.vehicle else {}
        except (RangeError, UnknownNameError) as error:
            raise type(error)(f"{self.id}: {str(error).removeprefix('vehicle: ')}") from None

    def _remarks(self) -> dict[str, str]:
        """Return what the model keeps for the world, and the engine plugin does not look at."""
        require_class(self.id, self.motor_ctrl, self.motor_ctrl_properties)
        if self.motor_ctrl is None:
            return {}
        if not isinstance(self.motor_ctrl, str | type):
            raise RangeError(f"{self.id}: motor_ctrl is {self.motor_ctrl!r}, allowed: a class or its name")
        name = self.motor_ctrl if isinstance(self.motor_ctrl, str) else class_name(self.motor_ctrl)
        return {"motor_ctrl": name, "motor_ctrl_properties": properties_text(self.motor_ctrl_properties)}


def _text(value: str | float | int | Sequence[float]) -> str:
    if isinstance(value, Iterable) and not isinstance(value, str):
        return " ".join(repr(float(number)) for number in value)
    return repr(float(value)) if isinstance(value, float) else str(value)
