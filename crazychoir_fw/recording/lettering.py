"""Text in pictures: patches of letters, and places for labels where none covers another."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

Patch = NDArray[np.uint16]
"""Red, green, blue and opacity, each 0 to 255, shape (height, width, 4)."""
Color = tuple[int, int, int]

INK: Color = (26, 31, 38)
PAPER: Color = (255, 255, 255)

_STEPS = ((0.0, -1.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.8, -0.9), (-0.8, -0.9), (0.8, 0.9), (-0.8, 0.9))
"""Directions in which a label may stand from its point, the best first: right and down."""
_DISTANCES = (1.0, 1.9, 2.8)


@functools.cache
def _font(size: int, is_bold: bool) -> ImageFont.FreeTypeFont:
    import matplotlib

    name = "DejaVuSans-Bold.ttf" if is_bold else "DejaVuSans.ttf"
    return ImageFont.truetype(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name, size)


@functools.lru_cache(maxsize=512)
def text(words: str, size: int, color: Color = INK, halo: Color | None = PAPER, is_bold: bool = False) -> Patch:
    """Return words as a patch.

    Args:
        words: One line.
        size: Of the letters (pixels).
        color: Of the letters.
        halo: Color around them, which keeps them legible on any ground; None for none.
        is_bold: Whether they are bold.
    """
    font, stroke = _font(size, is_bold), 0 if halo is None else max(1, round(size / 8))
    left, _, right, _ = font.getbbox(words or " ", stroke_width=stroke)
    ascent, descent = font.getmetrics()
    image = Image.new("RGBA", (int(right - left) + 2, ascent + descent + 2 * stroke), (*(halo or color), 0))
    place = (1 - left, stroke)
    ImageDraw.Draw(image).text(place, words, color, font, stroke_width=stroke, stroke_fill=halo)
    return np.asarray(image).astype(np.uint16)


def pill(words: str, size: int, color: Color = PAPER, ground: Color = INK, opacity: int = 190) -> Patch:
    """Return words on a plate with round corners."""
    letters = text(words, size, color, None, True)
    height, width = letters.shape[0] + size // 2, letters.shape[1] + size
    image = Image.new("RGBA", (width, height), (*ground, 0))
    ImageDraw.Draw(image).rounded_rectangle((0, 0, width - 1, height - 1), size // 2, (*ground, opacity))
    over = Image.fromarray(letters.astype(np.uint8))
    image.alpha_composite(over, (size // 2, size // 4))
    return np.asarray(image).astype(np.uint16)


def blend(picture: NDArray[np.uint8], patch: Patch, x: int, y: int) -> None:
    """Lay a patch over a picture, its upper left corner at (x, y); what is outside is cut off."""
    height, width = picture.shape[:2]
    left, top = max(0, -x), max(0, -y)
    patch = patch[top : height - y, left : width - x] if x < width and y < height else patch[:0]
    if not patch.size:
        return
    ground = picture[y + top :, x + left :][: patch.shape[0], : patch.shape[1]]
    opacity = patch[..., 3:]
    ground[:] = (ground * (255 - opacity) + patch[..., :3] * opacity + 127) // 255


class Labels:
    """Finds places for labels, and keeps them from one picture to the next where it can.

    Args:
        width: Width of the pictures (pixels).
        height: Height of the pictures (pixels).
        taken: Boxes that labels must not cover: left, top, right, bottom (pixels).
    """

    def __init__(self, width: int, height: int, taken: Sequence[tuple[float, float, float, float]] = ()) -> None:
        self._size = width, height
        self._taken = list(taken)
        self._last: dict[str, int] = {}

    def place(
        self, points: Sequence[tuple[float, float]], sizes: Sequence[tuple[int, int]], clear: float, keys: Sequence[str]
    ) -> list[tuple[int, int] | None]:
        """Return the upper left corner of each label, None for those for which there is no room.

        Args:
            points: What the labels belong to (pixels from the upper left corner); NaN for what is out of sight.
            sizes: Width and height of each label (pixels).
            clear: Radius around each of the points that no label covers (pixels).
            keys: What each label is called from picture to picture.
        """
        boxes = [*self._taken]
        boxes += [(x - clear, y - clear, x + clear, y + clear) for x, y in points if np.isfinite(x + y)]
        found: list[tuple[int, int] | None] = [None] * len(points)
        for k in sorted(range(len(points)), key=lambda k: keys[k]):
            if not np.isfinite(points[k]).all():
                continue
            order = list(range(len(_STEPS) * len(_DISTANCES)))
            if (last := self._last.get(keys[k])) is not None:
                order = [last, *order]
            for choice in order:
                box = _box(points[k], sizes[k], clear, choice)
                if self._is_inside(box) and not any(_overlap(box, other) for other in boxes):
                    boxes.append(box)
                    found[k] = (round(box[0]), round(box[1]))
                    self._last[keys[k]] = choice
                    break
        return found

    def _is_inside(self, box: tuple[float, float, float, float]) -> bool:
        return box[0] >= 0 and box[1] >= 0 and box[2] <= self._size[0] and box[3] <= self._size[1]


def _box(
    point: tuple[float, float], size: tuple[int, int], clear: float, choice: int
) -> tuple[float, float, float, float]:
    """Return the box of a label in one of its possible places."""
    right, down = _STEPS[choice % len(_STEPS)]
    distance = _DISTANCES[choice // len(_STEPS)]
    x = point[0] + right * (clear * distance + size[0] / 2.0 + 1.0)
    y = point[1] + down * (clear * distance + size[1] / 2.0 + 1.0)
    return x - size[0] / 2.0, y - size[1] / 2.0, x + size[0] / 2.0, y + size[1] / 2.0


def _overlap(one: tuple[float, float, float, float], other: tuple[float, float, float, float]) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]
