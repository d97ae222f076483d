"""What explains a plot of a flight: phases and faults over time, and what stands in the scene."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D
from numpy.typing import NDArray

from crazychoir_fw.recording.storyboard import Note, Storyboard, words_of

Box = tuple[NDArray[np.float64], tuple[float, float, float]]
"""Corners (m), shape (8, 3), in the order of the bits x, y, z, and a color."""

_EDGES = [(k, k | bit) for k in range(8) for bit in (1, 2, 4) if not k & bit]
_MANY_BOXES = 200
"""More boxes than this are drawn from above only."""

_SHADE, _QUIET, _RED = "#EEF1F5", "#8A929B", "#C0392B"
_NARROW = 0.0105  # of the page's row per character: a phase whose name does not fit has none
_MOST_NOTES = 12
_ROOM = 0.14  # over the curves of the first row, for the names of phases
_LINE = 112  # characters under the rows
_NEAR_M = 0.6  # beyond what drones fly over, for what stands there
_LARGE_M = 1.5  # a wall is no reason to show all of it


def draw_story(rows: Sequence[Axes], story: Storyboard) -> None:
    """Shade every second phase in all rows and name the phases over the first one; red lines are where faults begin.

    Args:
        rows: Rows over the same time axis.
        story: What explains the flight.
    """
    begin, end = rows[0].get_xlim()
    if story.windows:
        low, high = rows[0].get_ylim()
        rows[0].set_ylim(low, high + _ROOM * (high - low))
    for k, window in enumerate(story.windows):
        low, high = max(window.begin, begin), min(window.end, end)
        if high <= low:
            continue
        for row in rows if k % 2 == 0 else ():
            row.axvspan(low, high, color=_SHADE, linewidth=0, zorder=0)
        name = words_of(window.name)
        if (high - low) / (end - begin) > _NARROW * len(name):
            rows[0].text(
                (low + high) / 2.0,
                0.985,
                name,
                transform=rows[0].get_xaxis_transform(),
                ha="center",
                va="top",
                fontsize=7.5,
                color=_QUIET,
                parse_math=False,
            )
    _draw_notes(rows, story.notes[:_MOST_NOTES], begin, end)


def _draw_notes(rows: Sequence[Axes], notes: Sequence[Note], begin: float, end: float) -> None:
    """Draw a line where each note begins, and number it; a text under them says what the numbers mean."""
    notes = [note for note in notes if begin <= note.begin <= end]
    if not notes:
        return
    seen: dict[float, int] = {}
    for number, note in enumerate(notes, 1):
        for row in rows:
            row.axvline(note.begin, color=_RED, linewidth=0.8, linestyle=(0, (2, 2)), alpha=0.8, zorder=1)
        level = seen.get(round(note.begin, 2), 0)
        seen[round(note.begin, 2)] = level + 1
        rows[1].text(
            note.begin,
            1.02,
            f" {number}" if not level else "   " * level + f",{number}",
            transform=rows[1].get_xaxis_transform(),
            fontsize=7.5,
            color=_RED,
            va="bottom",
        )
    words = [f"{k} {note.drone}: {note.text}" if note.drone else f"{k} {note.text}" for k, note in enumerate(notes, 1)]
    lines = textwrap.wrap("  ·  ".join(words), _LINE)
    # under the label of the axis; the layout makes room for it
    rows[-1].annotate(
        "\n".join(lines),
        (0.0, 0.0),
        xytext=(0.0, -36.0),
        xycoords="axes fraction",
        textcoords="offset points",
        va="top",
        fontsize=7.5,
        color=_RED,
        parse_math=False,
        annotation_clip=False,
    )


def draw_scenery(space: Axes3D, above: Axes, scenery: Sequence[Box]) -> None:
    """Draw what stands in the scene as far as the page shows it: edges of boxes in space, their outlines from above."""
    if not scenery:
        return
    outlines = [_outline(corners[:, :2]) for corners, _ in scenery]
    edges = [color for _, color in scenery]
    faces = [(*color, 0.45) for color in edges]
    above.add_collection(
        PolyCollection(outlines, facecolors=faces, edgecolors=edges, linewidths=0.8, zorder=2),
        autolim=False,
    )
    low, high = above.dataLim.get_points()
    for outline in outlines:
        is_near = (outline > low - _NEAR_M).all() and (outline < high + _NEAR_M).all()
        if is_near and np.ptp(outline, axis=0).max() < _LARGE_M:
            above.update_datalim(outline)
    limits = np.array([space.get_xlim3d(), space.get_ylim3d(), space.get_zlim3d()])
    lines, colors = [], []
    for corners, color in scenery[:_MANY_BOXES]:
        inside = (corners >= limits[:, 0] - _NEAR_M) & (corners <= limits[:, 1] + _NEAR_M)
        if inside.all():
            lines += [corners[list(edge)] for edge in _EDGES]
            colors += [(*color, 0.6)] * len(_EDGES)
    if lines:
        space.add_collection3d(Line3DCollection(lines, colors=colors, linewidths=0.7, zorder=2), autolim=False)


def _outline(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the convex outline of points in the plane, shape (any, 2), counter-clockwise."""
    order = sorted(map(tuple, np.round(points, 9)))

    def half(points: Sequence[tuple[float, ...]]) -> list[tuple[float, ...]]:
        hull: list[tuple[float, ...]] = []
        for point in points:
            while len(hull) > 1 and _turn(hull[-2], hull[-1], point) <= 0.0:
                hull.pop()
            hull.append(point)
        return hull[:-1]

    hull = [*half(order), *half(order[::-1])]
    return np.array(hull if len(hull) > 1 else order[:1] * 2)


def _turn(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
