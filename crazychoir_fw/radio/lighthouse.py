"""Handlers for drones that find their position by themselves, and tell it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from crazychoir_fw.radio.vel import RadioHandlerVel
from crazychoir_fw.radio.xyz import RadioHandlerXYZ

_SELF_POSITIONED = {"odometry_hz": 50.0, "forwards_poses": False}


class RadioHandlerXYZLightHouse(RadioHandlerXYZ):
    """`RadioHandlerXYZ` with odometry by the drones' own estimators, and without poses from outside."""

    defaults: ClassVar[Mapping[str, Any]] = {**RadioHandlerXYZ.defaults, **_SELF_POSITIONED}


class RadioHandlerVelLightHouse(RadioHandlerVel):
    """`RadioHandlerVel` with odometry by the drones' own estimators, and without poses from outside."""

    defaults: ClassVar[Mapping[str, Any]] = {**RadioHandlerVel.defaults, **_SELF_POSITIONED}
