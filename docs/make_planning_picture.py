"""Draw `images/planning.png`: three curves through the same points, a new goal in flight, and a drawing made to fly."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from crazychoir_fw.common.messages import Pose, TrajectoryPoint
from crazychoir_fw.planning import GENTLE, Drawn, MinimumSnap, Polynomial7th, Spline, fit_drawn, thinned

POINTS = [(0.0, 0.0, 1.0), (1.0, 0.2, 1.0), (1.2, 1.0, 1.0), (0.2, 1.2, 1.0), (-0.4, 0.4, 1.0)]
TIMES = [0.0, 2.0, 3.5, 5.5, 7.5]
HANDLERS = {"Polynomial7th": Polynomial7th, "Spline": Spline, "MinimumSnap": MinimumSnap}


def path(handler, end: float, begin: float = 0.0) -> tuple[np.ndarray, list]:
    """Return times (s) and references from one time to another."""
    times = np.linspace(begin, end, 400)
    return times, [handler.evaluate(time) for time in times]


def message(points, times) -> list[TrajectoryPoint]:
    """Return points as a message."""
    return [TrajectoryPoint(time, np.array(point)) for time, point in zip(times, points, strict=True)]


def draw_curves(plan, speed) -> None:
    """Draw what the handlers make of the same message, from above and over time."""
    for number, (name, make) in enumerate(HANDLERS.items()):
        handler = make()
        handler.set_trajectory(message(POINTS, TIMES), Pose(np.array(POINTS[0])), 0.0)
        times, references = path(handler, TIMES[-1])
        x, y, _ = np.array([reference.position for reference in references]).T
        plan.plot(x, y, f"C{number}", label=name)
        speed.plot(times, [np.linalg.norm(reference.velocity) for reference in references], f"C{number}", label=name)
    plan.plot(*np.array(POINTS).T[:2], "ko", markersize=5)
    plan.set(title="one message, three handlers", xlabel="x (m)", ylabel="y (m)", aspect="equal")
    plan.legend(loc="center", fontsize=8)
    for time in TIMES:
        speed.axvline(time, color="0.8", linewidth=0.8, zorder=0)
    speed.set(title="speed on them (lines: times of the points)", xlabel="time (s)", ylabel="m/s", ylim=(0, None))


def draw_new_goal(axes) -> None:
    """Draw the velocity when a second goal comes while the first is approached."""
    for legacy, color, label in ((True, "C3", "legacy: starts from rest"), (False, "C0", "goes on as it moves")):
        handler = Spline(legacy=legacy)
        home = np.array([0.0, 0.0, 1.0])
        handler.set_trajectory(message([(2.0, 0.0, 1.0)], [4.0]), Pose(home), 0.0)
        first = path(handler, 1.6)
        handler.set_trajectory(message([(0.0, 1.0, 1.0)], [4.0]), Pose(handler.evaluate(1.6).position), 1.6)
        times, references = (a + b for a, b in zip(map(list, first), map(list, path(handler, 6.0, 1.6)), strict=True))
        axes.plot(times, [reference.velocity[0] for reference in references], color, label=label)
    axes.axvline(1.6, color="0.8", linewidth=0.8, zorder=0)
    axes.set(title="a new goal at 1.6 s: velocity along x", xlabel="time (s)", ylabel="m/s")
    axes.legend(fontsize=8)


def draw_drawing(axes) -> None:
    """Draw samples of a shaky hand and the curve through them."""
    angles = np.linspace(0.0, 2.0 * np.pi, 240)
    shaking = np.random.default_rng(1).normal(0.0, 0.008, (240, 2))
    points = np.column_stack([np.sin(angles) + shaking[:, 0], 0.6 * np.sin(2 * angles) + shaking[:, 1], 0 * angles + 1])
    drawn = Drawn(points, angles)
    fit = fit_drawn(drawn, distance=0.2, limits=GENTLE)
    axes.plot(*points.T[:2], ".", color="0.6", markersize=3, label="drawn")
    axes.plot(*thinned(drawn).points.T[:2], "C1o", markersize=4, label="kept")
    axes.plot(
        *fit.curve.position(np.linspace(0, fit.curve.duration, 600)).T[:2],
        "C0",
        label=f"its times, slowed: {fit.curve.duration:.0f} s",
    )
    free = fit_drawn(Drawn(points), distance=0.3, limits=GENTLE, method="minimum_snap")
    axes.plot(
        *free.curve.position(np.linspace(0, free.curve.duration, 600)).T[:2],
        "C2--",
        label=f"free times: {free.curve.duration:.0f} s",
    )
    title = "a drawing flown within 1 m/s and 2 m/s²"
    axes.set(title=title, xlabel="x (m)", ylabel="y (m)", aspect="equal", ylim=(-0.8, 1.2))
    axes.legend(fontsize=8, ncols=2, loc="upper center")


def main() -> None:
    """Draw."""
    figure, axes = plt.subplots(2, 2, figsize=(9.0, 7.0), layout="constrained")
    draw_curves(axes[0, 0], axes[0, 1])
    draw_new_goal(axes[1, 0])
    draw_drawing(axes[1, 1])
    for each in axes.flat:
        each.grid(alpha=0.3)
    figure.savefig(Path(__file__).parent / "images" / "planning.png", dpi=110)


if __name__ == "__main__":
    main()
