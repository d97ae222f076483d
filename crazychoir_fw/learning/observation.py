"""What a policy sees: named blocks, side by side in one vector.

A policy that is to fly on a drone sees what the drone knows; a critic may see the truth.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.learning.reading import Floats, Motion, Reading

Compute = Callable[[Reading, Motion], Floats]


@dataclass(frozen=True)
class Block:
    """A part of an observation."""

    size: int
    """How many numbers."""
    meaning: str
    """What they are, with unit and frame."""
    compute: Compute
    """From a reading, and the motion that is believed or true, to an array of shape (N, size)."""
    is_on_board: bool = True
    """Whether a firmware app can compute it, see `crazychoir_fw.learning.policy`."""


def _ranges(reading: Reading, motion: Motion) -> Floats:
    del motion
    if reading.ranges is None:
        raise RangeError("observation names 'ranges', but the drones of the task have no multiranger in their decks")
    return reading.ranges


BLOCKS: dict[str, Block] = {
    "position_error": Block(3, "reference minus position (m, world)", lambda r, m: r.reference.position - m.position),
    "velocity_error": Block(3, "reference minus velocity (m/s, world)", lambda r, m: r.reference.velocity - m.velocity),
    "reference_acceleration": Block(3, "of the reference (m/s^2, world)", lambda r, m: r.reference.acceleration),
    "position": Block(3, "position (m, world)", lambda r, m: m.position),
    "velocity": Block(3, "velocity (m/s, world)", lambda r, m: m.velocity),
    "rotation": Block(9, "rotation matrix, body to world, row by row", lambda r, m: m.rotation),
    "rates": Block(3, "angular velocity (rad/s, body), of the gyroscope", lambda r, m: m.rates),
    "specific_force": Block(3, "of the accelerometer (m/s^2, body)", lambda r, m: r.specific_force),
    "action": Block(4, "the latest action, in [-1, 1]", lambda r, m: r.action),
    "battery": Block(1, "voltage of the battery (V)", lambda r, m: r.battery_voltage[:, None], is_on_board=False),
    "ranges": Block(5, "multi-ranger: front, back, up, left, right (m, at most 4)", _ranges, is_on_board=False),
}
"""The blocks by name. A project adds its own here before it makes environments."""

SOURCES = ("estimate", "truth")


@dataclass(frozen=True)
class Observation:
    """Which blocks, in which order, and whether of what drones believe or of the truth."""

    blocks: tuple[str, ...] = ("position_error", "velocity_error", "rotation", "rates", "action")
    """Names in `BLOCKS`."""
    source: str = "estimate"
    """``estimate``: what the drone knows; ``truth``: what only the simulator knows."""

    def __post_init__(self) -> None:
        if self.source not in SOURCES:
            raise UnknownNameError(f"observation: source is {self.source!r}, allowed: {', '.join(SOURCES)}")
        if isinstance(self.blocks, str) or not isinstance(self.blocks, Sequence) or not self.blocks:
            raise RangeError(f"observation: blocks is {self.blocks!r}, allowed: a list of {', '.join(BLOCKS)}")
        for name in self.blocks:
            if name not in BLOCKS:
                near = get_close_matches(str(name), BLOCKS, 1)
                hint = f", did you mean '{near[0]}'?" if near else ""
                raise UnknownNameError(f"observation: no block '{name}'{hint} Allowed: {', '.join(BLOCKS)}")

    @property
    def size(self) -> int:
        """How many numbers."""
        return sum(BLOCKS[name].size for name in self.blocks)

    def of(self, reading: Reading) -> Floats:
        """Return the observations of all flights, shape (N, size)."""
        motion = reading.estimate if self.source == "estimate" else reading.truth
        return np.concatenate([BLOCKS[name].compute(reading, motion) for name in self.blocks], axis=1, dtype=np.float32)


RADIANS = np.float32(math.pi / 180.0)
"""Radians in a degree, as the exported C has it."""
