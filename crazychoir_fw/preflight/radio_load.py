"""Whether Crazyradios carry what a flight of the mission sends: the estimate of `crazychoir radio-budget`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

from crazychoir_fw.crtp.link_model import RadioConfig
from crazychoir_fw.crtp.link_model.airtime import BITS_PER_SECOND
from crazychoir_fw.crtp.link_model.budget import LogBlock, budget
from crazychoir_fw.preflight.check import Check, check

if TYPE_CHECKING:
    from crazychoir_fw.mission.schema import LayeredMission
    from crazychoir_fw.radio import RadioHandler

_URI = re.compile(r"radio://(?P<dongle>[^/]+)/\d+/(?P<rate>[^/]+)/")
_STATE_HZ = 11.0
"""Packets of the supervisor and of the battery."""


def radio_load(mission: LayeredMission, handlers: Mapping[str, RadioHandler]) -> Check:
    """Return whether each Crazyradio serves its drones.

    Args:
        mission: The mission.
        handlers: By drone, the handler that flies it.
    """
    dongles: dict[tuple[str, str], list[str]] = {}
    for name, handler in handlers.items():
        found = _URI.match(handler[name].uri)
        if found is not None and found["rate"] in BITS_PER_SECOND:
            dongles.setdefault((found["dongle"], found["rate"]), []).append(name)
    problems, good = [], []
    for (dongle, rate), names in dongles.items():
        options = handlers[names[0]].options
        is_told = any(drone.id in names and drone.mocap is not None for drone in mission.fleet)
        setpoints = max(options.keep_alive_hz, min(float(mission.layers.rate), options.max_rate_hz))
        load = budget(
            RadioConfig(drones=names, data_rate=rate),
            len(names),
            setpoints,
            logs=[LogBlock(options.odometry_hz), LogBlock(_STATE_HZ, 16)],
            poses_hz=options.pose_hz if is_told else 0.0,
        )
        text = f"radio {dongle}: {len(names)} drones use {100 * load.utilization:.0f} % of their turns"
        if load.verdict == "too much":
            problems.append(
                f"{text}; use more radios, or fewer poses (hardware.odometry_hz) or setpoints (layers.rate)"
            )
        else:
            good.append(text if load.verdict == "fits" else f"{text}, which is tight")
    return check("radio budget", problems, "; ".join(good) or "no drone is on a Crazyradio")
