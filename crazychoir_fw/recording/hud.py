"""What lies over the pictures of a film: title, clock and speed, a bar with the phases, and what went wrong."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.recording.lettering import INK, PAPER, Color, Patch, blend, pill, text
from crazychoir_fw.recording.storyboard import Note, Window, words_of

RED: Color = (190, 36, 24)
_DONE, _NEXT = np.array([0, 91, 142], np.uint8), np.array([46, 52, 60], np.uint8)
_LINE = (255, 255, 255)
_MOST_NOTES = 5
_LONGEST = 70  # characters of a title or a note


class Hud:
    """Draws over pictures of one size.

    Args:
        width: Width of the pictures (pixels).
        height: Height of the pictures (pixels).
        span: First and last instant of the flight (s).
        speed: Seconds of flight per second of film.
        title: Shown all the time; empty for none.
        windows: Phases of the flight.
        notes: What went wrong, and when.
    """

    def __init__(
        self,
        width: int,
        height: int,
        span: tuple[float, float],
        speed: float = 1.0,
        title: str = "",
        windows: Sequence[Window] = (),
        notes: Sequence[Note] = (),
    ) -> None:
        self._size, self._span, self._speed = (width, height), span, speed
        self.letters = max(9, round(height / 34))
        self._gap = self.letters // 2
        self._notes = notes
        self._title = _fitting(title, self.letters, width * 0.7) if title else None
        self._bar = _bar(width, self.letters, span, windows, notes)
        self._at: dict[str, Patch] = {}

    @property
    def boxes(self) -> list[tuple[float, float, float, float]]:
        """Boxes that are covered all the time: left, top, right, bottom (pixels)."""
        (width, height), band = self._size, 2.2 * self.letters
        boxes = [
            (0.0, height - len(self._bar), float(width), float(height)),
            (width - 9.0 * self.letters, 0.0, float(width), band),
        ]
        if self._title is not None:
            boxes.append((0.0, 0.0, self._title.shape[1] + 2.0 * self._gap, band))
        return boxes

    def draw(self, picture: NDArray[np.uint8], now: float) -> None:
        """Draw over a picture of an instant (s), shape (height, width, 3)."""
        width = self._size[0]
        if self._title is not None:
            blend(picture, self._title, self._gap, self._gap)
        speed = "" if self._speed == 1.0 else f"   {self._speed:g}×"
        clock = self._patch(f"{now:.1f} s{speed}", INK)
        blend(picture, clock, width - clock.shape[1] - self._gap, self._gap)
        y = self._gap + clock.shape[0] + self._gap // 2
        for note in [note for note in self._notes if note.begin <= now < note.end][-_MOST_NOTES:]:
            words = f"{note.drone}: {note.text}" if note.drone else note.text
            patch = self._patch(words[:_LONGEST], RED)
            blend(picture, patch, width - patch.shape[1] - self._gap, y)
            y += patch.shape[0] + 2
        self._draw_bar(picture, now)

    def _draw_bar(self, picture: NDArray[np.uint8], now: float) -> None:
        width, height = self._size
        share = (now - self._span[0]) / max(1e-9, self._span[1] - self._span[0])
        done = int(np.clip(share, 0.0, 1.0) * width)
        strip = picture[height - len(self._bar) :]
        strip[:, :done] = strip[:, :done] // 5 + _DONE
        strip[:, done:] = strip[:, done:] // 5 + _NEXT
        blend(picture, self._bar, 0, height - len(self._bar))
        strip[:, max(0, done - 2) : done + 1] = _LINE

    def _patch(self, words: str, ground: Color) -> Patch:
        if words not in self._at:
            if len(self._at) > 64:
                self._at.clear()
            self._at[words] = pill(words, self.letters, PAPER, ground)
        return self._at[words]


def _fitting(words: str, letters: int, width: float) -> Patch:
    """Return a title as a plate that is not wider than this (pixels)."""
    shown = words[:_LONGEST] + ("…" if len(words) > _LONGEST else "")
    patch = pill(shown, letters)
    while patch.shape[1] > width and len(shown) > 4:
        shown = shown[:-4].rstrip() + "…"
        patch = pill(shown, letters)
    return patch


def _bar(
    width: int, letters: int, span: tuple[float, float], windows: Sequence[Window], notes: Sequence[Note]
) -> Patch:
    """Return the bar: names of phases where they fit, lines between them, red where something went wrong."""
    height = round(1.7 * letters)
    bar = np.zeros((height, width, 4), np.uint16)

    def column(time: float) -> int:
        share = (time - span[0]) / max(1e-9, span[1] - span[0])
        return int(np.clip(share * width, 0, width - 1))

    for note in notes:
        begin = column(note.begin)
        bar[: max(2, height // 7), begin : max(begin + 3, column(note.end))] = (*RED, 255)
    for window in windows:
        begin, end = column(window.begin), column(window.end)
        if begin > 0:
            bar[:, begin] = (255, 255, 255, 130)
        name = text(words_of(window.name), letters - 1, PAPER, None)
        if name.shape[1] + 6 <= end - begin:
            x, y = begin + (end - begin - name.shape[1]) // 2, (height - name.shape[0]) // 2 + 1
            under = bar[y : y + name.shape[0], x : x + name.shape[1]]
            letters_only = name[: under.shape[0]]
            under[:] = np.where(letters_only[..., 3:] > 0, letters_only, under)
    return bar
