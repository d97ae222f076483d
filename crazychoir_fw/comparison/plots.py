"""Pictures of simulated flights beside real ones."""

from __future__ import annotations

from pathlib import Path

import matplotlib.figure
import numpy as np

from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.comparison.whole_chain import ChainComparison

_REAL, _SIMULATED, _TARGET = "#1f4e79", "#d9622b", "#9a9a9a"


def draw_chain(comparison: ChainComparison, title: str, path: Path) -> None:
    """Draw path, distance to the setpoint, tilt, thrust and voltage of both flights into a PNG file."""
    figure = matplotlib.figure.Figure(figsize=(11, 7), layout="constrained")
    grid = figure.subplot_mosaic(
        [["path", "x"], ["path", "y"], ["path", "z"], ["tilt", "thrust"], ["distance", "voltage"]],
        height_ratios=[1, 1, 1, 1.3, 1.3],
    )
    time, rows = comparison.time, comparison.rows
    real, simulated, target = comparison.real, comparison.simulated, comparison.setpoint

    plane = grid["path"]
    plane.plot(*target[rows, :2].T, color=_TARGET, lw=0.8, label="setpoint")
    plane.plot(*real["position"][rows, :2].T, color=_REAL, label="real")
    plane.plot(*simulated["position"][rows, :2].T, color=_SIMULATED, label="simulated")
    plane.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", adjustable="datalim")
    plane.legend(loc="upper right", fontsize=8)
    for i, name in enumerate("xyz"):
        grid[name].plot(time, target[:, i], color=_TARGET, lw=0.8)
        grid[name].plot(time, real["position"][:, i], color=_REAL)
        grid[name].plot(time, simulated["position"][:, i], color=_SIMULATED, lw=1)
        grid[name].set_ylabel(f"{name} [m]")
    behind = [100 * np.linalg.norm(flown["position"] - target, axis=1) for flown in (real, simulated)]
    grid["distance"].plot(time, behind[0], color=_REAL)
    grid["distance"].plot(time, behind[1], color=_SIMULATED, lw=1)
    grid["distance"].set(ylabel="to setpoint [cm]", xlabel="time [s]")
    labels = {"tilt": "tilt [deg]", "thrust": "thrust [1000 counts]", "voltage": "pack [V]"}
    for name, label in labels.items():
        factor = 1e-3 if name == "thrust" else 1.0
        grid[name].plot(time, factor * real[name], color=_REAL, lw=0.9)
        grid[name].plot(time, factor * simulated[name], color=_SIMULATED, lw=0.9)
        grid[name].set_ylabel(label)
    grid["voltage"].set_xlabel("time [s]")
    for name, axes in grid.items():
        axes.grid(alpha=0.25)
        if name != "path":
            axes.axvspan(time[rows][0], time[rows][-1], color="#f3efe6", zorder=0)
            axes.set_xlim(time[0], time[-1])
    shift = f"simulated is {1000 * comparison.lag_s:.0f} ms later; shown after that shift"
    figure.suptitle(f"{title}: paths {100 * comparison.path_rms_m:.1f} cm apart (RMS), {shift}", fontsize=11)
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=75)
