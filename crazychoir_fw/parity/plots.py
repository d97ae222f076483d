"""Small pictures of two signals and their deviation, as SVG that takes its colors from the page around it."""

from __future__ import annotations

import io
import re

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from crazychoir_fw.parity.deviation import Trace
from crazychoir_fw.parity.tolerances import Tolerance

# stand-ins while drawing; in the page they are variables, so that the picture follows light and dark
_INK, _SOFT, _REFERENCE, _CANDIDATE = "#010203", "#040506", "#070809", "#0a0b0c"
_VARIABLES = {
    _INK: "var(--ink)",
    _SOFT: "var(--line)",
    _REFERENCE: "var(--reference)",
    _CANDIDATE: "var(--candidate)",
}


def plot_svg(trace: Trace, tolerance: Tolerance, is_by_number: bool, title: str) -> str:
    """Return an ``<svg>`` element: both signals above, their distance below with a logarithmic scale.

    Args:
        trace: The signals.
        tolerance: Its absolute bound is drawn, if it has one.
        is_by_number: Whether ticks are numbers of samples; otherwise milliseconds, drawn as seconds.
        title: Says which signal of what; read out to those who cannot see the picture.
    """
    # a salt of its own keeps the names inside from meeting those of other pictures of the page
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": title, "font.size": 8, "font.family": "sans-serif"}):
        figure = Figure(figsize=(5.6, 2.5))
        figure.subplots_adjust(left=0.12, right=0.985, top=0.9, bottom=0.16, hspace=0.14)
        canvas = FigureCanvasSVG(figure)
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(1.5, 1.0))
        t = trace.ticks if is_by_number else trace.ticks / 1000.0
        above.plot(t, _finite(trace.reference), color=_REFERENCE, linewidth=1.4, label="reference")
        above.plot(
            t, _finite(trace.candidate), color=_CANDIDATE, linewidth=1.0, linestyle=(0, (3, 2)), label="candidate"
        )
        _draw_deviation(below, t, trace, tolerance)
        below.set_xlabel("sample" if is_by_number else "time (s)", color=_INK)
        above.legend(
            loc="lower right",
            bbox_to_anchor=(1.0, 0.98),
            frameon=False,
            labelcolor=_INK,
            ncols=2,
            fontsize=7,
            borderpad=0,
        )
        for axes in (above, below):
            _color(axes)
        file = io.StringIO()
        canvas.print_svg(file, metadata={"Date": None, "Creator": None})
    return _inline(file.getvalue(), title)


def _finite(values: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(values), values, np.nan)


def _draw_deviation(axes: Axes, t: np.ndarray, trace: Trace, tolerance: Tolerance) -> None:
    shown = np.where((trace.deviation > 0) & np.isfinite(trace.deviation), trace.deviation, np.nan)
    if np.isfinite(shown).any():
        axes.semilogy(t, shown, color=_CANDIDATE, linewidth=0.9, marker=".", markersize=2)
    unmatched = np.isinf(trace.deviation)
    if unmatched.any():
        axes.plot(
            t[unmatched], np.full(unmatched.sum(), 0.5), "x", color=_CANDIDATE, transform=axes.get_xaxis_transform()
        )
    if tolerance.absolute and np.isfinite(shown).any():
        axes.axhline(tolerance.absolute, color=_INK, linewidth=0.7, linestyle=(0, (1, 2)))
    axes.set_ylabel("distance", color=_INK)


def _color(axes: Axes) -> None:
    axes.set_facecolor("none")
    axes.tick_params(colors=_INK, which="both", labelsize=7)
    axes.grid(color=_SOFT, linewidth=0.5)
    for spine in axes.spines.values():
        spine.set_color(_SOFT)


def _inline(document: str, title: str) -> str:
    """Return the element alone, with variables for colors and without a background."""
    element = document[document.index("<svg") :]
    element = re.sub(r'<g id="patch_1">.*?</g>', "", element, count=1, flags=re.DOTALL)
    for stand_in, variable in _VARIABLES.items():
        element = element.replace(stand_in, variable)
    element = re.sub(r'\swidth="[^"]*"', "", element, count=1)
    element = re.sub(r'\sheight="[^"]*"', "", element, count=1)
    escaped = title.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    return element.replace("<svg", f'<svg role="img" aria-label="{escaped}"', 1)
