"""How well each gain set of the control layer flies: hover, a step of 1 m, a circle.

    python benchmarks/control_gains.py --markdown gains.md --figure gains.png --json gains.json

`HierarchicalController` gives commands at 100 Hz to the simulated onboard software, from the onboard estimate (motion
capture) or from the truth. References have position, velocity, acceleration, jerk and yaw. Figures are of the true
motion.
"""

from __future__ import annotations

import argparse
import json
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Pose, Reference, Twist
from crazychoir_fw.control import (
    FlatnessPositionCtrl,
    FPQRSender,
    FRPYSender,
    GeometryAttitudeCtrl,
    HierarchicalController,
)
from crazychoir_fw.simulation import Drone, DroneConfig, MotorCtrl, MotorCtrlFPQR, MotorCtrlFRPY, World
from crazychoir_fw.simulation.integrator.platforms import platform_mass

Array = NDArray[np.float64]

SETS = ("webots", "vicon", "mujoco")
FLIGHTS = ("hover", "step", "climb", "circle")
HEIGHT = 1.0  # [m]
TAKEOFF = 3.0  # [s]
SETTLING = 4.0  # [s], after take-off
STEP = 1.0  # [m]
RADIUS = 1.0  # [m]
SPEED = 1.5  # [m/s], on the circle
PICK_UP = 2.0  # [s], until the circle has its speed
PERIOD = 0.01  # [s] between two samples
LOST = 0.5  # [m] from the reference at the end


def estimated_pose(drone: Drone, gyro: Array, time: float) -> Pose:
    """Return what the onboard software believes."""
    estimate = drone.struct.onboard.estimate
    q, v, p = estimate.attitudeQuaternion, estimate.velocity, estimate.position
    return Pose(np.array([p.x, p.y, p.z]), np.array([q.x, q.y, q.z, q.w]), np.array([v.x, v.y, v.z]), gyro, time)


def true_pose(drone: Drone, time: float) -> Pose:
    """Return what is so."""
    quat_xyzw = np.roll(drone.true_quat_wxyz, -1)
    return Pose(drone.true_position, quat_xyzw, drone.true_velocity, drone.true_rates, time)


def take_off(time: float) -> Reference:
    """Rise smoothly to the height; before time 0 stand."""
    s = min(max(time / TAKEOFF, 0.0), 1.0)
    up = np.array([0.0, 0.0, HEIGHT])
    return Reference(
        position=up * s**3 * (10.0 - 15.0 * s + 6.0 * s**2),
        velocity=up * 30.0 * s**2 * (1.0 - s) ** 2 / TAKEOFF,
        acceleration=up * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / TAKEOFF**2,
        jerk=up * 60.0 * (1.0 - 6.0 * s * (1.0 - s)) / TAKEOFF**3 * (0.0 < s < 1.0),
        yaw=0.0,
    )


def at(*position: float) -> Reference:
    """Stand still at a point (m)."""
    return Reference(np.array(position), np.zeros(3), np.zeros(3), np.zeros(3), 0.0)


def circle(time: float) -> Reference:
    """Fly a circle through the point above the start, picking up speed at first."""
    s = min(time / PICK_UP, 1.0)
    # the speed is a smooth step of the time; the way is its integral, and so on
    rate = SPEED / RADIUS
    angle = rate * PICK_UP * (s**3 - 0.5 * s**4) + rate * max(time - PICK_UP, 0.0)
    first = rate * s**2 * (3.0 - 2.0 * s)
    second = rate * 6.0 * s * (1.0 - s) / PICK_UP
    third = rate * 6.0 * (1.0 - 2.0 * s) / PICK_UP**2 * (s < 1.0)
    out = np.array([np.sin(angle), 1.0 - np.cos(angle), 0.0])
    along = np.array([np.cos(angle), np.sin(angle), 0.0])
    inwards = np.array([-np.sin(angle), np.cos(angle), 0.0])
    return Reference(
        position=RADIUS * out + [0.0, 0.0, HEIGHT],
        velocity=RADIUS * first * along,
        acceleration=RADIUS * (second * along + first**2 * inwards),
        jerk=RADIUS * ((third - first**3) * along + 3.0 * first * second * inwards),
        yaw=0.0,
    )


REFERENCES: dict[str, tuple[Callable[[float], Reference], float]] = {
    "hover": (lambda _: at(0.0, 0.0, HEIGHT), 6.0),
    "step": (lambda _: at(STEP, 0.0, HEIGHT), 8.0),
    "climb": (lambda _: at(0.0, 0.0, HEIGHT + STEP), 8.0),
    "circle": (circle, PICK_UP + 3.0 * 2.0 * np.pi * RADIUS / SPEED),
}
"""What follows take-off and settling, of the time since then (s), and how long (s)."""


def controller(gains: str, mass: float, kind: str) -> HierarchicalController:
    """Return a controller of the gain set."""
    if kind == "frpy":
        return HierarchicalController(FlatnessPositionCtrl(gains=gains, mass=mass), command_sender=FRPYSender())
    return HierarchicalController(
        FlatnessPositionCtrl(gains=gains, mass=mass), GeometryAttitudeCtrl(gains=gains), FPQRSender()
    )


def flyer(
    law: HierarchicalController,
    kind: str,
    reference: Callable[[float], Reference],
    delay: int = 0,
    knows_truth: bool = False,
) -> type[MotorCtrl]:
    """Return a class that flies by the law, along a reference of the simulated time (s), some steps late."""
    on_the_way: deque[Twist] = deque()
    parent: type[MotorCtrl] = {"fpqr": MotorCtrlFPQR, "frpy": MotorCtrlFRPY}[kind]

    class Flyer(parent):  # type: ignore[valid-type, misc]
        def step(self) -> None:
            if knows_truth:
                law.set_pose(true_pose(self.drone, self.time))
            else:
                law.set_pose(estimated_pose(self.drone, self.gyro, self.time))
            law.set_reference(reference(self.time))
            twist = law.step(self.time)
            if twist is not None:
                on_the_way.append(twist)
            if len(on_the_way) > delay:
                twist = on_the_way.popleft()
                self.cmd_vel(twist.linear, twist.angular)

    return Flyer


def fly(
    gains: str,
    flight: str,
    platform: str = "cf2",
    kind: str = "fpqr",
    delay: int = 0,
    knows_truth: bool = False,
    seed: int = 1,
) -> tuple[Array, Array]:
    """Fly; return true positions and those of the reference (m), shape (T, 3) each, one per 10 ms."""
    law = controller(gains, platform_mass(platform), kind)
    path, seconds = REFERENCES[flight]
    begin = TAKEOFF + SETTLING
    start = 2.0  # [s], the onboard software has booted and is calibrated

    def reference(time: float) -> Reference:
        time -= start
        return take_off(time) if time < begin else path(time - begin)

    config = DroneConfig("cf1", platform=platform, motor_ctrl=flyer(law, kind, reference, delay, knows_truth))
    world = World([config], seed=seed, visuals=False)
    drone = world.drones[0]
    world.run(start + begin)
    rows = []
    for _ in range(round(seconds / PERIOD)):
        world.run(PERIOD)
        rows.append((drone.true_position.copy(), reference(world.time).position))
    if drone.failure is not None:
        raise RuntimeError(f"{gains}: {flight}: {drone.failure}")
    true, wanted = (np.array(column) for column in zip(*rows, strict=True))
    return true, wanted


def figures(flight: str, true: Array, wanted: Array) -> dict[str, float]:
    """Return what a flight is judged by."""
    distance = np.linalg.norm(true - wanted, axis=1)
    if distance[-1] > LOST:
        return {f"{flight}_lost_m": float(distance[-1])}
    if flight in ("hover", "circle"):
        late = len(distance) // 2
        return {f"{flight}_rms_mm": 1000 * float(np.sqrt(np.mean(distance[late:] ** 2)))}
    way = true[:, 0 if flight == "step" else 2] - (0.0 if flight == "step" else HEIGHT)
    reached = [int(np.argmax(way >= part * STEP)) for part in (0.1, 0.9)]
    outside = np.flatnonzero(distance > 0.05)
    return {
        f"{flight}_rise_s": (reached[1] - reached[0]) * PERIOD,
        f"{flight}_overshoot_percent": 100 * float(max(way.max() / STEP - 1.0, 0.0)),
        f"{flight}_settled_s": (int(outside[-1]) + 1) * PERIOD if len(outside) else 0.0,
    }


def markdown(rows: list[dict[str, Any]]) -> str:
    """Return the figures as a table."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    lines = ["| " + " | ".join(name.replace("_", " ") for name in names) + " |", "|---" * len(names) + "|"]
    for row in rows:
        values = [row.get(name, "") for name in names]
        lines.append("| " + " | ".join(f"{v:.3g}" if isinstance(v, float) else v for v in values) + " |")
    return "\n".join(lines) + "\n"


def draw(path: Path, tracks: dict[str, dict[str, tuple[Array, Array]]]) -> None:
    """Draw step, climb and circle of each set."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (left, middle, right) = pyplot.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
    for gains, flights in tracks.items():
        for flight, axes, column in (("step", left, 0), ("climb", middle, 2)):
            true, _ = flights[flight]
            axes.plot(np.arange(len(true)) * PERIOD, true[:, column], label=gains)
        right.plot(*flights["circle"][0][:, :2].T, label=gains)
    lap = flights["circle"][1][-round(2.0 * np.pi * RADIUS / SPEED / PERIOD) :]
    right.plot(*lap[:, :2].T, "k:", label="reference")
    left.set(title="step of 1 m", xlabel="time (s)", ylabel="x (m)", xlim=(0, 6))
    middle.set(title="climb of 1 m", xlabel="time (s)", ylabel="z (m)", xlim=(0, 6))
    right.set(title=f"circle at {SPEED} m/s", xlabel="x (m)", ylabel="y (m)", aspect="equal")
    for axes in (left, middle, right):
        axes.grid(alpha=0.3)
    right.legend(loc="center")
    figure.savefig(path, dpi=100)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sets", nargs="+", default=list(SETS), choices=SETS)
    parser.add_argument("--flights", nargs="+", default=list(FLIGHTS), choices=FLIGHTS)
    parser.add_argument("--platform", default="cf2", choices=("cf2", "cf21bl"))
    parser.add_argument("--kind", default="fpqr", choices=("fpqr", "frpy"))
    parser.add_argument("--delay", type=int, default=0, help="steps of 10 ms that a command is on its way")
    parser.add_argument("--truth", action="store_true", help="control by the true motion, not by the estimate")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--markdown", type=Path)
    parser.add_argument("--figure", type=Path, help="needs all flights")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()

    rows, tracks = [], {}
    for gains in options.sets:
        row: dict[str, Any] = {"gains": gains}
        tracks[gains] = {}
        for flight in options.flights:
            tracks[gains][flight] = fly(
                gains, flight, options.platform, options.kind, options.delay, options.truth, options.seed
            )
            row |= figures(flight, *tracks[gains][flight])
        rows.append(row)
    print(markdown(rows))
    if options.markdown:
        options.markdown.write_text(markdown(rows))
    if options.json:
        options.json.write_text(json.dumps(rows, indent=2))
    if options.figure:
        draw(options.figure, tracks)


if __name__ == "__main__":
    main()
