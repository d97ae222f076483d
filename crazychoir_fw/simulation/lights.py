"""What clients have written for the LED ring of a drone, for drawing it (docs/reference/crtp-cflib.md#10.3)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi


class LightEntry(NamedTuple):
    """One step of a light show."""

    time: int
    """As the client wrote it, 0 to 255; its unit is not established."""
    color: tuple[float, float, float]
    """Red, green, blue in [0, 1]."""
    leds: int
    """Which LEDs, 0 to 15; 0 is all."""
    is_fading: bool
    """Fade to the color instead of a jump."""
    rotation: int
    """0 to 7."""


class Lights:
    """The LED ring: kept as written, and dark after a boot. What shines is chosen by ``ring.effect``."""

    def __init__(self, cf: Any) -> None:
        self._cf = cf

    @property
    def ring(self) -> NDArray[np.float64]:
        """Colors of the 12 LEDs (red, green, blue in [0, 1]), shape (12, 3)."""
        return _colors(np.frombuffer(ffi.buffer(self._cf.onboard.lights.ring), ">u2"))

    @property
    def show(self) -> list[LightEntry]:
        """The light show up to its end."""
        entries = np.frombuffer(ffi.buffer(self._cf.onboard.lights.timings), np.uint8).reshape(-1, 4)
        ends = np.flatnonzero(~entries.any(axis=1))
        entries = entries[: ends[0]] if len(ends) else entries
        colors = _colors(np.ascontiguousarray(entries[:, 1:3]).view(">u2").ravel())
        return [
            LightEntry(int(time), tuple(color.tolist()), int(extra & 0x0F), bool(extra & 0x10), int(extra >> 5))
            for (time, _, _, extra), color in zip(entries, colors, strict=True)
        ]


def _colors(rgb565: NDArray[np.uint16]) -> NDArray[np.float64]:
    """Unpack colors of 5, 6 and 5 bits."""
    return np.stack([(rgb565 >> 11) / 31.0, (rgb565 >> 5 & 0x3F) / 63.0, (rgb565 & 0x1F) / 31.0], axis=1)
