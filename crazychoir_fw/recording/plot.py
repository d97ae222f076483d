"""One page about a flight: paths in space and from above, position against reference over time, motor commands."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.axes3d import Axes3D
from numpy.typing import NDArray

from crazychoir_fw.common.motor_logs import FULL_DUTY, MOTORS
from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.recording.colors import FEW, palette
from crazychoir_fw.recording.error_curve import ErrorCurve
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.marks import COLORS, SHAPES, Mark, TaskTimeline
from crazychoir_fw.recording.plot_story import Box, draw_scenery, draw_story
from crazychoir_fw.recording.storyboard import Storyboard

_MAX_SAMPLES = 2000  # per line: more than the page has pixels
_INK, _SOFT = "#22262B", "#8A929B"
_DASHES = (0, (4, 2))
_MIN_SPAN_M = 0.1  # of an axis over time: noise of a hovering drone shall not fill it


def plot_flight(
    log: FlightLog,
    path: Path,
    title: str,
    curve: ErrorCurve | None = None,
    timeline: TaskTimeline | None = None,
    scenery: Sequence[Box] = (),
) -> None:
    """Draw the page and write it; the format follows the suffix of *path*.

    Positions are `sim.x, y, z`, or `stateEstimate.x, y, z` if the truth was not recorded.
    The reference is what layers asked for, `layers.x, y, z`, or `ctrltarget.x, y, z`; where all three are exactly zero
    there was none yet, and none is drawn.
    Motor commands are `motor.m1` to `motor.m4`: each motor for a single drone, mean and range of the four for several.

    Args:
        log: The flight.
        path: File to write, usually `flight.png`; replaced in one step.
        title: Headline.
        curve: An error over time, shown in place of the motors.
        timeline: Points beside the drones, and the tasks of each drone over time, shown in place of the motors as well.
        scenery: What stands in the scene, such as gates: the corners of a box (m), shape (8, 3), and its color.
    """
    figure = Figure(figsize=(14.0, 9.0), dpi=110, layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    layout = figure.get_layout_engine()
    assert layout is not None
    layout.set(w_pad=0.08, h_pad=0.06, wspace=0.02)
    left, right = figure.add_gridspec(1, 2, width_ratios=[1.0, 1.1])
    upper, lower = left.subgridspec(2, 1, height_ratios=[1.25, 1.0])
    rows = right.subgridspec(4, 1, height_ratios=[1.0, 1.0, 1.0, 1.15])
    space = figure.add_subplot(upper, projection="3d")
    above = figure.add_subplot(lower)
    axes = [figure.add_subplot(rows[0])]
    axes += [figure.add_subplot(rows[k], sharex=axes[0]) for k in range(1, 4)]

    stride = _stride(log)
    log = _thinned(log)
    colors = palette(len(log.drone_ids))
    truth = log.stack("sim.x", "sim.y", "sim.z")
    if truth is None:
        truth = log.stack("stateEstimate.x", "stateEstimate.y", "stateEstimate.z")
    reference = log.reference()

    _draw_paths(space, truth, reference, colors)
    _draw_from_above(above, truth, reference, colors)
    _draw_positions(axes[:3], log.time, truth, reference, colors)
    draw_scenery(space, above, scenery)
    draw_story(axes, Storyboard.of(log))
    marks = [mark for explained in (timeline, curve) if explained is not None for mark in explained.marks]
    _draw_marks(above, marks, colors)
    if curve is None and timeline is not None:
        _draw_intervals(axes[3], timeline, colors)
    elif curve is None:
        _draw_motors(axes[3], log, colors)
    else:
        _draw_error(axes[3], log.time, curve, stride)
        _draw_formation(above, curve)
    _leave_room(above)
    figure.align_ylabels(axes)
    _explain_lines(space, reference is not None)
    _name_drones(figure, above, log.drone_ids, colors)
    figure.suptitle(title, fontsize=15, fontweight="bold", color=_INK, parse_math=False)
    axes[0].set_title(_facts(log), fontsize=8, color=_SOFT, loc="right", parse_math=False)

    # savefig would draw the whole page once for the layout alone
    layout.execute(figure)
    figure.set_layout_engine(None)
    with replacing(path) as temporary:
        figure.savefig(temporary)


def _stride(log: FlightLog) -> int:
    """Return how many samples apart those are that are drawn."""
    return -(-len(log.time) // _MAX_SAMPLES) or 1


def _thinned(log: FlightLog) -> FlightLog:
    """Return the log with at most `_MAX_SAMPLES` instants."""
    stride = _stride(log)
    signals = {name: samples[::stride] for name, samples in log.signals.items()}
    return FlightLog(log.time[::stride], log.drone_ids, signals, log.metadata, log.events)


def _width(drones: int) -> float:
    """Return the width of a line (points) for a page with that many."""
    return float(np.clip(2.0 - 0.05 * drones, 0.7, 1.8))


def _draw_paths(
    axes: Axes3D, truth: NDArray[np.float64] | None, reference: NDArray[np.float64] | None, colors: Sequence[str]
) -> None:
    """Draw the paths in space with their shadow on the floor, start (ring) and end (dot)."""
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    axes.set_zlabel("z (m)", labelpad=3.0)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color((0.96, 0.97, 0.98, 1.0))
        axis._axinfo["grid"].update(color="#DDE1E6", linewidth=0.6)
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]))
    axes.tick_params(labelsize=8, colors=_INK)
    axes.view_init(elev=24.0, azim=-58.0)
    if truth is None:
        return
    finite = truth[np.isfinite(truth).all(axis=-1)]
    low, high = (finite.min(axis=0), finite.max(axis=0)) if len(finite) else (np.zeros(3), np.ones(3))
    low[2] = min(low[2], 0.0)
    # one meter is one meter in every direction, until the swarm is so wide that its heights would vanish
    center, size = (low + high) / 2.0, np.maximum((high - low) * 1.08, 0.6)
    size[:2] = np.maximum(size[:2], 0.5 * size.max())
    floor = low[2]
    axes.set(xlim=center[0] + size[0] * np.array([-0.5, 0.5]), ylim=center[1] + size[1] * np.array([-0.5, 0.5]))
    axes.set_zlim(floor, floor + size[2])
    axes.set_box_aspect((size[0], size[1], max(size[2], 0.35 * size.max())), zoom=1.12)

    # a zoomed box reaches over the edge of its axes; the layout would take such lines for wide margins
    whole = {"clip_on": False, "in_layout": False}
    width = _width(len(colors))
    for drone, color in enumerate(colors):
        x, y, z = truth[:, drone].T
        axes.plot(x, y, np.full_like(z, floor), color="#B9C0C8", linewidth=0.6 * width, zorder=1, **whole)
        axes.plot(x, y, z, color=color, linewidth=width, zorder=3, **whole)
        if reference is not None:
            x, y, z = reference[:, drone].T
            axes.plot(x, y, z, color=color, linewidth=0.7 * width, linestyle=_DASHES, zorder=2, **whole)
        known = np.flatnonzero(np.isfinite(truth[:, drone]).all(axis=-1))
        if len(known):
            area = 10.0 if len(colors) > len(FEW) else 22.0
            start, end = truth[known[0], drone], truth[known[-1], drone]
            # the ring is wider than the dot: many flights end where they began
            axes.scatter(*start, s=4.0 * area, facecolors="white", edgecolors=color, depthshade=False, zorder=4)
            axes.scatter(*end, s=area, color=color, depthshade=False, zorder=5)


def _draw_from_above(
    axes: Axes, truth: NDArray[np.float64] | None, reference: NDArray[np.float64] | None, colors: Sequence[str]
) -> None:
    """Draw the paths in the plane of the floor."""
    _tidy(axes, "y (m)")
    axes.set_xlabel("x (m)", color=_INK)
    width = _width(len(colors))
    for drone, color in enumerate(colors):
        if reference is not None:
            x, y, _ = reference[:, drone].T
            axes.plot(x, y, color=color, linewidth=0.75 * width, linestyle=_DASHES, alpha=0.8)
        if truth is not None:
            x, y, _ = truth[:, drone].T
            axes.plot(x, y, color=color, linewidth=width)


def _leave_room(axes: Axes) -> None:
    """Make one meter one meter in both directions, with some room around all that was drawn."""
    low, high = axes.dataLim.get_points()
    if np.isfinite([low, high]).all():
        # with equal scales matplotlib looks at the data and knows no margins; and a hover is not a cloud of noise
        half = np.maximum((high - low) / 2.0 + 0.04 * (high - low).max(), 0.2)
        axes.update_datalim([(low + high) / 2.0 - half, (low + high) / 2.0 + half])
        axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")


def _draw_positions(
    rows: Sequence[Axes],
    time: NDArray[np.float64],
    truth: NDArray[np.float64] | None,
    reference: NDArray[np.float64] | None,
    colors: Sequence[str],
) -> None:
    """Draw x, y and z over time, true solid and reference dashed."""
    width = _width(len(colors))
    for k, (axes, name) in enumerate(zip(rows, "xyz", strict=True)):
        _tidy(axes, f"{name} (m)")
        axes.tick_params(labelbottom=False)
        for drone, color in enumerate(colors):
            if reference is not None:
                axes.plot(
                    time, reference[:, drone, k], color=color, linewidth=0.75 * width, linestyle=_DASHES, alpha=0.8
                )
            if truth is not None:
                axes.plot(time, truth[:, drone, k], color=color, linewidth=width)
        low, high = axes.get_ylim()
        if high - low < _MIN_SPAN_M:
            middle = (low + high) / 2.0
            axes.set_ylim(middle - _MIN_SPAN_M / 2.0, middle + _MIN_SPAN_M / 2.0)


def _draw_motors(axes: Axes, log: FlightLog, colors: Sequence[str]) -> None:
    """Draw motor commands in percent of full: four lines for one drone, mean and range for several."""
    _tidy(axes, "motors (%)")
    axes.set_xlabel("time (s)")
    axes.set_ylim(0.0, 100.0)
    motors = log.stack(*MOTORS)
    if motors is None:
        axes.text(0.5, 0.5, "not recorded", transform=axes.transAxes, ha="center", va="center", color=_SOFT)
        return
    percent = motors * (100.0 / FULL_DUTY)
    if len(colors) == 1:
        for k, color in enumerate(FEW[:4]):
            axes.plot(log.time, percent[:, 0, k], color=color, linewidth=0.9, label=f"M{k + 1}")
        axes.legend(loc="lower center", ncols=4, fontsize=8, frameon=False)
        return
    few = len(colors) <= len(FEW)
    for drone, color in enumerate(colors):
        if few:
            low, high = percent[:, drone].min(axis=-1), percent[:, drone].max(axis=-1)
            axes.fill_between(log.time, low, high, color=color, alpha=0.18, linewidth=0)
        axes.plot(log.time, percent[:, drone].mean(axis=-1), color=color, linewidth=0.6 * _width(len(colors)))
    note = "mean of four, range shaded" if few else "mean of four"
    _note(axes, note)


def _draw_formation(axes: Axes, curve: ErrorCurve) -> None:
    """Draw the pairs of drones whose bearings count at the end of the flight, and crosses at their targets."""
    if curve.ends is not None:
        # many pairs are a web that shall not hide the paths
        width = float(np.clip(10.0 / max(1, len(curve.pairs)), 0.25, 0.7))
        for pair in curve.pairs:
            x, y, _ = curve.ends[list(pair)].T
            axes.plot(x, y, color="#9AA3AD", linewidth=width, zorder=0.5)
    if curve.places is not None and np.isfinite(curve.places).any():
        x, y, _ = curve.places.T
        axes.scatter(x, y, marker="x", s=36.0, color=_INK, linewidths=1.0, zorder=6)


def _draw_error(axes: Axes, time: NDArray[np.float64], curve: ErrorCurve, stride: int) -> None:
    """Draw an error: its mean, up to its largest, and what is allowed."""
    _tidy(axes, curve.label)
    axes.set_xlabel("time (s)")
    mean, largest = curve.mean[::stride], curve.largest[::stride]
    least = 0.0
    if curve.is_logarithmic:
        axes.set_yscale("log")
        least = 1e-3
    axes.fill_between(time, np.maximum(mean, least), np.maximum(largest, least), color=FEW[0], alpha=0.18, linewidth=0)
    axes.plot(time, mean, color=FEW[0], linewidth=1.4)
    if curve.limit is not None:
        axes.axhline(curve.limit, color=FEW[1], linewidth=1.0, linestyle=_DASHES)
        axes.text(
            0.005, curve.limit, "allowed ", transform=axes.get_yaxis_transform(), va="bottom", fontsize=8, color=FEW[1]
        )
        if curve.judged is not None:
            # what comes later, such as the landing, may be off
            axes.axvspan(*curve.judged, color=FEW[1], alpha=0.15, linewidth=0)
            axes.text(
                curve.judged[0],
                0.93,
                "judged ",
                transform=axes.get_xaxis_transform(),
                ha="right",
                va="top",
                fontsize=8,
                color=FEW[1],
            )
    if not curve.is_logarithmic:
        axes.set_ylim(bottom=0.0)
    _note(axes, curve.note)


def _draw_marks(axes: Axes, marks: Sequence[Mark], colors: Sequence[str]) -> None:
    """Draw each point once, as it was at last: with the shape of its kind, or in a box with its label."""
    last = {(*mark.position[:2], mark.label, mark.kind): mark for mark in marks}
    for mark in sorted(marks, key=lambda mark: mark.end):
        last[(*mark.position[:2], mark.label, mark.kind)] = mark
    for mark in last.values():
        if mark.kind in SHAPES:
            _draw_shape(axes, mark)
        else:
            _draw_box(axes, mark, _SOFT if mark.drone is None else colors[mark.drone])


def _draw_shape(axes: Axes, mark: Mark) -> None:
    x, y, _ = mark.position
    # what moves is a line already, and ends here
    size = 40.0 if mark.moves else 130.0
    shape, color = SHAPES[mark.kind], COLORS[mark.kind]
    axes.scatter([x], [y], marker=shape, s=size, color=color, linewidths=0.8, edgecolors="white", zorder=7)


def _draw_box(axes: Axes, mark: Mark, color: str) -> None:
    x, y, _ = mark.position
    if mark.link is not None:
        axes.annotate(
            "",
            mark.link[:2],
            (x, y),
            arrowprops={"arrowstyle": "->", "color": color, "linestyle": ":", "linewidth": 0.9, "alpha": 0.8},
            zorder=0.6,
        )
    axes.scatter(x, y, marker="s", s=90.0, facecolors="white", edgecolors=color, linewidths=1.3, zorder=6)
    axes.text(x, y, mark.label, ha="center", va="center", fontsize=6.5, color=_INK, zorder=7, clip_on=True)


def _draw_intervals(axes: Axes, timeline: TaskTimeline, colors: Sequence[str]) -> None:
    """Draw the tasks of each drone: a bar from the time when it took one on, filled if it finished it."""
    _tidy(axes, timeline.title)
    axes.set_xlabel("time (s)")
    axes.set_ylim(len(colors) - 0.5, -0.5)
    axes.set_yticks([])
    # several at a time share the line of their drone
    for drone, color in enumerate(colors):
        own = sorted(
            (interval for interval in timeline.intervals if interval.drone == drone),
            key=lambda interval: interval.begin,
        )
        ends: list[float] = []
        rows = []
        for interval in own:
            row = next((k for k, end in enumerate(ends) if end <= interval.begin + 1e-9), len(ends))
            ends[row : row + 1] = [interval.end]
            rows.append(row)
        height = 0.8 / max(1, len(ends))
        for interval, row in zip(own, rows, strict=True):
            low = drone - 0.4 + row * height
            face = color if interval.is_finished else "white"
            axes.broken_barh(
                [(interval.begin, interval.end - interval.begin)],
                (low, 0.92 * height),
                facecolors=face,
                edgecolors=color,
                linewidth=0.8,
                zorder=3,
                alpha=0.75 if interval.is_finished else 0.9,
            )
            if interval.end - interval.begin > 0.6:
                axes.text(
                    (interval.begin + interval.end) / 2.0,
                    low + 0.46 * height,
                    interval.label,
                    ha="center",
                    va="center",
                    fontsize=6.0,
                    color="white" if interval.is_finished else _INK,
                    clip_on=True,
                    zorder=4,
                )
    _note(axes, "filled: done; empty: handed on")


def _tidy(axes: Axes, label: str) -> None:
    axes.set_ylabel(label, color=_INK)
    axes.grid(color="#E4E7EB", linewidth=0.7)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color("#B9C0C8")
    axes.tick_params(colors=_INK, labelsize=9)
    axes.margins(x=0.01)
    axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]))


def _note(axes: Axes, text: str) -> None:
    """Say above the row what its lines and shades are."""
    axes.text(0.995, 1.02, text, transform=axes.transAxes, ha="right", fontsize=8, color=_SOFT)


def _explain_lines(space: Axes3D, with_reference: bool) -> None:
    """Say above the paths what solid, dashed, ring and dot mean."""
    entries = [Line2D([], [], color=_INK, linewidth=1.6, label="true")]
    if with_reference:
        entries.append(Line2D([], [], color=_INK, linewidth=1.2, linestyle=_DASHES, label="reference"))
    ring = {"marker": "o", "linestyle": "none", "markeredgecolor": _INK}
    entries.append(Line2D([], [], markerfacecolor="white", label="start", **ring))
    entries.append(Line2D([], [], markerfacecolor=_INK, label="end", **ring))
    space.legend(
        handles=entries, loc="upper left", bbox_to_anchor=(0.0, 1.02), ncols=4, fontsize=9, frameon=False, borderpad=0
    )


def _name_drones(figure: Figure, above: Axes, drone_ids: Sequence[str], colors: Sequence[str]) -> None:
    """Name the drones below the page: one entry each for a few, a colored scale for many."""
    count = len(drone_ids)
    if not count:
        return
    if count <= len(FEW):
        lines = [Line2D([], [], color=color, linewidth=3.0) for color in colors]
        names = [_short(name, 18) for name in drone_ids]
        figure.legend(lines, names, loc="outside lower center", ncols=count, fontsize=9, frameon=False)
        return
    scale = ScalarMappable(BoundaryNorm(np.arange(count + 1) - 0.5, count), ListedColormap(colors))
    ticks = np.arange(0, count, -(-(count - 1) // 6))
    bar = figure.colorbar(scale, ax=above, orientation="horizontal", ticks=ticks, shrink=0.9, aspect=50, pad=0.02)
    bar.set_ticklabels([_short(drone_ids[k], 10) for k in ticks], fontsize=8)
    bar.outline.set_visible(False)
    bar.ax.tick_params(length=0)
    bar.ax.minorticks_off()


def _short(name: str, most: int = 24) -> str:
    """Return *name* cut to *most* characters, with nothing that matplotlib would take for mathematics or hide."""
    name = name if len(name) <= most else name[: most - 1] + "…"
    return name.replace("$", r"\$").lstrip("_")


def _facts(log: FlightLog) -> str:
    """Return what flew, in one line."""
    facts = [f"{len(log.drone_ids)} drones" if len(log.drone_ids) != 1 else "1 drone", f"{log.duration_s:.1f} s"]
    for key in ("mission", "backend", "provider", "platform", "version", "seed"):
        if key in log.metadata:
            facts.append(f"{key} {_short(str(log.metadata[key]), 60)}")
    return "  ·  ".join(facts)
