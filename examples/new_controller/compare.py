"""Fly compare.yaml and draw the two controllers into one picture, with the figures that matter.

    python examples/new_controller/compare.py [OUTPUT.png]

Any mission with the drones `pid` and `ours` and these phases will do: change the C file, run it again.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from crazychoir_fw.flight import fly
from crazychoir_fw.mission import load_mission
from crazychoir_fw.mission.plan import TICKS_PER_SECOND, plan_flight

MISSION = Path(__file__).with_name("compare.yaml")
COLORS = {"pid": "#D55E00", "ours": "#0072B2"}
STEP, FIGURE_8 = 2, 4  # places of the phases in the mission
SETTLED = 0.05  # of the step


def phase(mission, log, number, last):
    """Return which samples lie between the begin of one phase and the end of another, shape (T,)."""
    ends = {}
    for waypoint in plan_flight(mission).waypoints:
        place = int(waypoint.phase.split("[")[1].split("]")[0])
        ends[place] = waypoint.tick / TICKS_PER_SECOND
    since = log.time - log.time[0]
    return (since > ends[number - 1]) & (since <= ends[last])


def step_figures(time, path, goal):
    """Return rise time to 90 % (s), overshoot (%) and settling time to 5 % (s) of a step; NaN where it never came."""
    part = (path - path[0]) / (goal - path[0])
    reached = np.flatnonzero(part >= 0.9)
    outside = np.flatnonzero(abs(part - 1.0) > SETTLED)
    has_settled = outside[-1] + 1 < len(time)
    return {
        "rise_s": time[reached[0]] - time[0] if len(reached) else np.nan,
        "overshoot_percent": 100.0 * max(0.0, part.max() - 1.0),
        "settled_s": time[outside[-1] + 1] - time[0] if has_settled else np.nan,
    }


def figures(mission, log):
    """Return the figures of each drone, by its id."""
    true = log.stack("sim.x", "sim.y", "sim.z")
    wanted = log.stack("ctrltarget.x", "ctrltarget.y", "ctrltarget.z")
    step, eight = phase(mission, log, STEP, STEP + 1), phase(mission, log, FIGURE_8, FIGURE_8)
    table = {}
    for k, name in enumerate(log.drone_ids):
        miss = 1000.0 * np.linalg.norm(true[eight, k] - wanted[eight, k], axis=1)
        table[name] = {
            **step_figures(log.time[step], true[step, k, 0], wanted[step, k, 0][-1]),
            "height_lost_mm": 1000.0 * max(0.0, true[step, k, 2][0] - true[step, k, 2].min()),
            "figure8_rms_mm": np.sqrt(np.mean(miss**2)),
            "figure8_max_mm": miss.max(),
        }
    return table


def draw(mission, log, table, path):
    """Draw the step over time, the figure-8 from above and its error over time."""
    true = log.stack("sim.x", "sim.y", "sim.z")
    wanted = log.stack("ctrltarget.x", "ctrltarget.y", "ctrltarget.z")
    step, eight = phase(mission, log, STEP, STEP + 1), phase(mission, log, FIGURE_8, FIGURE_8)
    figure = Figure(figsize=(10.0, 8.2), dpi=80, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplot_mosaic([["step", "error"], ["eight", "eight"]], height_ratios=[1.0, 1.35])

    # the drones fly side by side: for the picture both start at the origin
    home = true[0] * [1.0, 1.0, 0.0]
    begin = log.time[step][0], log.time[eight][0]
    axes["step"].plot(log.time[step] - begin[0], wanted[step, 0, 0] - home[0, 0], "k--", lw=1.0, label="setpoint")
    shift = wanted[eight, 0] - home[0]
    axes["eight"].plot(shift[:, 0], shift[:, 1], "k--", lw=1.0, label="setpoint")
    for k, name in enumerate(log.drone_ids):
        found, color = table[name], COLORS.get(name)
        axes["step"].plot(
            log.time[step] - begin[0],
            true[step, k, 0] - home[k, 0],
            color=color,
            label=f"{name}: rise {found['rise_s']:.2f} s, overshoot {found['overshoot_percent']:.0f} %",
        )
        x, y, _ = (true[eight, k] - home[k]).T
        axes["eight"].plot(x, y, color=color, label=name)
        miss = 1000.0 * np.linalg.norm(true[eight, k] - wanted[eight, k], axis=1)
        axes["error"].plot(
            log.time[eight] - begin[1], miss, color=color, label=f"{name}: {found['figure8_rms_mm']:.0f} mm RMS"
        )
    axes["step"].set(title="step of 0.5 m", xlabel="time (s)", ylabel="x (m)")
    axes["error"].set(
        title="figure-8: distance from the setpoint", xlabel="time (s)", ylabel="error (mm)", ylim=(0, None)
    )
    axes["eight"].set(title="figure-8 from above", xlabel="x (m)", ylabel="y (m)", aspect="equal")
    for each in axes.values():
        each.grid(color="#E4E7EB")
        each.spines[["top", "right"]].set_visible(False)
        each.legend(frameon=False, fontsize=9)
    figure.suptitle(mission.description)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)


def main(output):
    """Fly, print the figures, draw."""
    mission = load_mission(MISSION)
    result = fly(mission)
    for failure in result.failures:
        print(failure, file=sys.stderr)
    table = figures(mission, result.log)
    print(f"{'':20}" + "".join(f"{name:>10}" for name in table))
    for row in next(iter(table.values())):
        print(f"{row:20}" + "".join(f"{found[row]:10.2f}" for found in table.values()))
    draw(mission, result.log, table, output)
    print(f"see {output}")
    return 0 if result.success else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("out/new_controller/compare.png")))
