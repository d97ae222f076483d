"""The drones that are flown for a comparison, and the world that they fly in.

Together they meet every kind of set-point and every type of measurement. They fly in one world, a meter apart.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from crazychoir_fw.common.errors import CrazychoirError, UnknownNameError
from crazychoir_fw.parity.manoeuvres import (
    COMMANDED,
    ESTIMATED_AGAIN,
    EVERY_SETPOINT,
    FORGOTTEN,
    HEIGHT_ALONE,
    NO_SPIRAL,
    PACKETS,
    PERIOD,
    PLANS,
    POSITIONS_ONLY,
    SIMPLE,
    STANDING,
    STOPPED,
    SWITCHED,
    TESTED,
    Leg,
    Pilot,
    trade_places,
)
from crazychoir_fw.simulation import DroneConfig, World

_SPACING = 0.9  # [m]
_COLUMNS = 5
_BOOT_LIMIT = 4000  # [ms]


@dataclass(frozen=True)
class Member:
    """One drone of the fleet."""

    name: str
    legs: Sequence[Leg]
    controller: str = "pid"
    positioning: str = "mocap"
    estimator: str | None = None
    parameters: Mapping[str, float | int] = field(default_factory=dict)
    attributes: Mapping[str, Any] = field(default_factory=dict)
    place: tuple[float, float] | None = None
    """Where it stands (m); by default in a grid with the others."""
    shows: str = ""
    """What this drone is there for, in a few words."""
    settles_s: float = 0.0
    """After the begin, while estimates jump at a step that differs between loops (s)."""
    modules: tuple[str, ...] = ()
    """Modules around the algorithms that decide this flight, as `firmware.levels` names them."""


# far from all others: some of them fall
_FAR = 16.0

MODULE_FLIGHTS: tuple[Member, ...] = (
    Member(
        "commander",
        COMMANDED,
        place=(_FAR, 0.0),
        shows="priorities, setpoints that grow old, relaxing",
        modules=("commander", "supervisor", "stabilizer"),
    ),
    Member(
        "packets",
        PACKETS,
        place=(_FAR + 2.0, 0.0),
        shows="setpoints as packets",
        modules=("crtp_commander", "commander", "stabilizer"),
    ),
    Member(
        "plans",
        PLANS,
        place=(_FAR + 4.0, 0.0),
        shows="high-level commands, taken and refused",
        modules=("high_level", "stabilizer"),
    ),
    Member(
        "stopped",
        STOPPED,
        place=(_FAR + 6.0, 0.0),
        shows="an emergency stop, and a take-off behind it",
        modules=("supervisor", "stabilizer"),
    ),
    Member(
        "forgotten",
        FORGOTTEN,
        place=(_FAR + 8.0, 0.0),
        shows="setpoints that cease for good",
        modules=("supervisor", "stabilizer"),
    ),
    Member(
        "switched",
        SWITCHED,
        place=(_FAR, 4.0),
        shows="controllers switched in flight",
        modules=("controller_table", "stabilizer"),
    ),
    Member(
        "estimated_anew",
        ESTIMATED_AGAIN,
        place=(_FAR + 2.0, 4.0),
        shows="estimators switched, the filter restarted",
        settles_s=1.3,
        modules=("estimator_task", "stabilizer"),
    ),
    Member(
        "tested", TESTED, place=(_FAR + 4.0, 4.0), shows="the test of the propellers", modules=("health", "stabilizer")
    ),
)
"""Flights in which the modules around the algorithms decide."""

FLEET: tuple[Member, ...] = (
    Member("pid", EVERY_SETPOINT, shows="PID with every kind of set-point; poses", modules=("commander", "high_level")),
    Member("mellinger", POSITIONS_ONLY, "mellinger", shows="Mellinger with positions, full states and plans"),
    Member("indi", NO_SPIRAL, "indi", shows="INDI with every kind of set-point"),
    Member("brescianini", POSITIONS_ONLY, "brescianini", shows="Brescianini with positions, full states and plans"),
    Member("lee", POSITIONS_ONLY, "lee", shows="Lee with positions, full states and plans"),
    Member("position", SIMPLE, positioning="mocap_position", shows="positions without attitudes"),
    Member("sweeps", SIMPLE, positioning="lighthouse", shows="sweep angles and yaw errors"),
    Member(
        "beams",
        SIMPLE,
        positioning="lighthouse",
        parameters={"lighthouse.method": 0},
        shows="crossed beams: positions of a lighthouse",
    ),
    Member("twr", SIMPLE, positioning="loco_twr", shows="distances"),
    Member(
        "twr_robust",
        SIMPLE,
        positioning="loco_twr",
        parameters={"kalman.robustTwr": 1},
        shows="distances, robust model",
    ),
    Member("tdoa2", SIMPLE, positioning="loco_tdoa2", shows="differences of distances"),
    Member(
        "tdoa3_robust",
        SIMPLE,
        positioning="loco_tdoa3",
        parameters={"kalman.robustTdoa": 1},
        shows="differences of distances, robust model",
    ),
    Member(
        "planar",
        STANDING,
        positioning="loco_twr",
        attributes={"loco_2d": "on", "loco_height": 0.02},
        shows="distances and a known height, standing",
    ),
    Member("flow", SIMPLE, positioning="flow", shows="optical flow and range"),
    Member(
        "complementary",
        HEIGHT_ALONE,
        positioning="flow",
        estimator="complementary",
        shows="complementary estimator with range and barometer",
    ),
    # far from the others, whose ways are none of their business
    Member(
        "avoids_right",
        trade_places(_SPACING),
        parameters={"colAv.enable": 1},
        place=(8.0, 0.0),
        shows="collision avoidance",
        modules=("collision_avoidance", "peer_localization"),
    ),
    Member(
        "avoids_left",
        trade_places(-_SPACING),
        parameters={"colAv.enable": 1},
        place=(8.0 + _SPACING, 0.0),
        shows="collision avoidance",
        modules=("collision_avoidance", "peer_localization"),
    ),
    *MODULE_FLIGHTS,
)
"""All drones."""

DURATION = max(sum(leg.seconds for leg in member.legs) for member in FLEET)
"""What the longest flight takes (s), without boot."""


class Formation:
    """The fleet in a world, booted and ready, with a pilot for each drone."""

    def __init__(
        self,
        fleet: Sequence[Member],
        provider: str = "builtin",
        platform: str = "cf2",
        seed: int = 1,
        parameters: Mapping[str, float] | None = None,
    ) -> None:
        """Build the world.

        Args:
            fleet: The drones.
            provider: Name of the provider that flies them.
            platform: Airframe of all drones.
            seed: Seed of all noise.
            parameters: Parameters that every drone gets; a drone of the fleet may have others.
        """
        configs = [
            DroneConfig(
                member.name,
                member.place or _place(i),
                platform=platform,
                provider=provider,
                controller=member.controller,
                estimator=member.estimator,
                positioning=member.positioning,
                parameters={**(parameters or {}), **member.parameters},
                attributes=member.attributes,
            )
            for i, member in enumerate(fleet)
        ]
        self._provider = provider
        self.fleet = tuple(fleet)
        self.world = World(configs, seed=seed, visuals=False)
        self.pilots = [Pilot(drone, member.legs) for drone, member in zip(self.world.drones, fleet, strict=True)]
        self._start: int | None = None
        self.tick = 0

    def check_provider(self, number: int) -> None:
        """Make sure that the provider that was asked for by name is the one with this number.

        Raises:
            UnknownNameError: If it is another one, for instance of a later build.
        """
        found = int(self.world.drones[0].struct.config.provider)
        if found != number:
            raise UnknownNameError(f"provider '{self._provider}' has the number {found}, expected {number}")

    @property
    def seconds(self) -> float:
        """What the longest flight of this fleet takes (s)."""
        return max(pilot.ticks for pilot in self.pilots) / 1000

    @property
    def ticks_under_way(self) -> int:
        """Ticks since the last drone began (ms), or gave up: one that is stopped, or is not ready in time, stays."""
        return 0 if self._start is None else self.tick - self._start

    def view(self, offset: int, size: int) -> NDArray[np.uint8]:
        """Return the same bytes of every drone as a live view, shape (N, size)."""
        memories = [drone.memory for drone in self.world.drones]
        starts = {later.ctypes.data - first.ctypes.data for first, later in itertools.pairwise(memories)} or {
            memories[0].nbytes
        }
        if len(starts) != 1:
            raise CrazychoirError("the drones do not stand one after the other in memory")
        first = memories[0][offset : offset + size]
        return as_strided(first, (len(memories), size), (starts.pop(), 1))

    def step(self) -> None:
        """Advance by one tick (1 ms); the pilots speak before it."""
        if self._start is None and self.tick % PERIOD == 0:
            self._get_ready()
        for pilot in self.pilots:
            if pilot.start is not None:
                pilot.act(self.tick - pilot.start)
        self.world.step(1)
        self.tick += 1

    def _get_ready(self) -> None:
        # each drone for itself, so that one that fails changes nothing for the others
        waiting = [pilot for pilot in self.pilots if pilot.is_waiting]
        for pilot in waiting:
            if pilot.drone.can_fly:
                pilot.start = self.tick
            elif pilot.drone.can_arm:
                pilot.drone.arm()
        if not any(pilot.is_waiting for pilot in waiting) or self.tick >= _BOOT_LIMIT:
            self._start = self.tick


def _place(index: int) -> tuple[float, float]:
    row, column = divmod(index, _COLUMNS)
    return _SPACING * (column - (_COLUMNS - 1) / 2), _SPACING * (row - 1.5)
