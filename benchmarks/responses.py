"""Step and frequency responses of all controllers, as people see them: default vehicle, noise, motion capture, filter.

    python benchmarks/responses.py --docs docs
    python benchmarks/responses.py --log my_step.csv --axis x --out my_step.png

The first makes the pictures and numbers of docs/responses.md. The second draws the step of a log over ours. A sample
has the setpoint that is in force and the true motion, as a row of a log has `ctrltarget` and the pose.
"""

from __future__ import annotations

import argparse
import csv
import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import matplotlib.figure
import matplotlib.ticker
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.comparison.log_flight import load_flight
from crazychoir_fw.comparison.signals import roll_pitch_yaw
from crazychoir_fw.simulation import DroneConfig, World

Array = NDArray[np.float64]

CONTROLLERS = ("pid", "mellinger", "indi", "brescianini", "lee")
COLORS = dict(zip(CONTROLLERS, ("#1f4e79", "#d9622b", "#4a8f3c", "#8a5aa8", "#9a7b1e"), strict=True))
STEPS = {"x": 0.5, "y": 0.5, "z": 0.3, "yaw": 45.0}
UNITS = {"x": "m", "y": "m", "z": "m", "yaw": "deg"}
RATE = 100  # [Hz]
SETTLED = 10.0  # [s] from the first setpoint: the integrators of the PID cascade take their time
SEEN = 4.0  # [s] after a step
APART = 3.0  # [m]
SLOW = (0.15, 0.2, 0.3, 0.45, 0.7, 1.0, 1.5, 2.0, 3.0)
FAST = (0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 13.0)
TICKS = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0)  # [Hz]
AMPLITUDES = {"x": 0.1, "z": 0.08, "yaw": 10.0, "velocity": 0.2, "attitude": 4.0}
PERIODS = 2  # that pass before as many are measured


@dataclass
class Trial:
    """One drone with what it is told."""

    controller: str
    loop: str
    """An axis of `STEPS`, ``velocity`` or ``attitude``."""
    frequency: float | None = None
    """Of a sine (Hz); None for a step."""
    told: list[float] = field(default_factory=list)
    seen: list[float] = field(default_factory=list)
    told_rate: list[float] = field(default_factory=list)
    seen_rate: list[float] = field(default_factory=list)

    @property
    def seconds(self) -> float:
        """How long it takes after the drones have settled."""
        return SEEN if self.frequency is None else 2 * PERIODS / self.frequency

    def value(self, time: float) -> float:
        """Return the deflection at a time after settling."""
        if time < 0.0 or time >= self.seconds:
            return 0.0
        if self.frequency is None:
            return STEPS[self.loop]
        return AMPLITUDES[self.loop] * float(np.sin(2 * np.pi * self.frequency * time))

    def send(self, commander: Any, home: Array, value: float) -> None:
        """Tell the drone its setpoint."""
        x, y, z = home
        if self.loop == "velocity":
            commander.send_velocity_world_setpoint(value, 0.0, 0.0, 0.0)
        elif self.loop == "attitude":
            commander.send_zdistance_setpoint(value, 0.0, 0.0, z)
        else:
            moved = {"x": 0.0, "y": 0.0, "z": 0.0, "yaw": 0.0, self.loop: value}
            commander.send_position_setpoint(x + moved["x"], y + moved["y"], z + moved["z"], moved["yaw"])


def fly(trials: list[Trial]) -> None:
    """Fly all trials side by side in one world; each learns what it was told and what was seen."""
    side = int(np.ceil(np.sqrt(len(trials))))
    homes = np.array([(APART * (k % side), APART * (k // side), 1.0) for k in range(len(trials))])
    configs = [DroneConfig(f"d{k}", tuple(homes[k, :2]), controller=trial.controller) for k, trial in enumerate(trials)]
    world = World(configs, visuals=False, seed=1)
    world.wait_until_ready()
    drones = world.drones
    qpos = np.array([drone.qpos_address for drone in drones])[:, None] + np.arange(7)
    qvel = np.array([drone.qvel_address for drone in drones])[:, None] + np.arange(6)
    latest = max(trial.seconds for trial in trials)
    for row in range(round((SETTLED + latest) * RATE)):
        time = row / RATE - SETTLED
        climb = min(1.0, row / RATE / 2.0)
        for drone, trial, home in zip(drones, trials, homes, strict=True):
            if time < -1.0 or time >= trial.seconds:
                drone.commander.send_position_setpoint(*home[:2], 0.1 + 0.9 * climb, 0.0)
            else:
                trial.send(drone.commander, home, trial.value(time))
        world.step(1000 // RATE)
        if time < -1.0:
            continue
        pose, motion = world.data.qpos[qpos], world.data.qvel[qvel]
        angles = roll_pitch_yaw(pose[:, [4, 5, 6, 3]])
        for k, (drone, trial) in enumerate(zip(drones, trials, strict=True)):
            if time >= trial.seconds:
                continue
            trial.told.append(trial.value(time))
            place = {axis: pose[k, i] - homes[k, i] for i, axis in enumerate("xyz")}
            seen = {**place, "yaw": angles[k, 2], "velocity": motion[k, 0], "attitude": angles[k, 0]}
            trial.seen.append(float(seen[trial.loop]))
            if trial.loop == "attitude":
                trial.told_rate.append(drone.log["controller.rollRate"])
                trial.seen_rate.append(float(np.degrees(motion[k, 3])))


# ------------------------------------------------------------------------------------------ steps


def step_figures(time: Array, share: Array) -> dict[str, float]:
    """Return rise from 10 to 90 % (s), overshoot (%), and when it stays within 5 % (s)."""
    after = time >= 0.0
    t, y = time[after], share[after]
    ten, ninety = (float(t[int(np.argmax(y >= level))]) for level in (0.1, 0.9))
    outside = np.flatnonzero(np.abs(y - 1.0) > 0.05)
    settled = float(t[min(outside[-1] + 1, len(t) - 1)]) if len(outside) else 0.0
    return {"rise_s": ninety - ten, "overshoot_percent": 100 * max(float(y.max()) - 1.0, 0.0), "settled_s": settled}


def step_share(trial: Trial) -> tuple[Array, Array]:
    """Return times after the step (s), and the way as a share of it."""
    time = np.arange(len(trial.seen)) / RATE - 1.0
    seen = np.unwrap(trial.seen, period=360.0) if trial.loop == "yaw" else np.array(trial.seen)
    return time, (seen - seen[time < 0.0].mean()) / STEPS[trial.loop]


def step_of_log(path: Path, axis: str, columns: str | None) -> tuple[Array, Array]:
    """Return the largest step of a log on an axis, as `step_share` does."""
    flight = load_flight(path, columns)
    if axis == "yaw":
        told, seen = flight.setpoint_yaw, np.unwrap(roll_pitch_yaw(flight.quat_xyzw)[:, 2], period=360.0)
    else:
        told = None if flight.setpoint is None else flight.setpoint[:, "xyz".index(axis)]
        seen = flight.position[:, "xyz".index(axis)]
    if told is None:
        raise SystemExit(f"{path}: no setpoint of {axis} in the log")
    row = int(np.argmax(np.abs(np.diff(told)))) + 1
    rows = slice(max(row - RATE, 0), row + round(SEEN * RATE))
    size = told[min(row + 5, len(told) - 1)] - told[row - 1]
    if abs(size) < 1e-3:
        raise SystemExit(f"{path}: the setpoint of {axis} makes no step")
    before = seen[max(row - 50, 0) : row].mean()
    return flight.time[rows] - flight.time[row], (seen[rows] - before) / size


def draw_steps(trials: list[Trial], own: dict[str, tuple[Array, Array]], path: Path) -> None:
    """Draw one panel per axis."""
    axes_shown = list(own) or list(STEPS)
    width = 5.5 if len(axes_shown) > 1 else 8
    figure = matplotlib.figure.Figure(figsize=(2 * width if len(axes_shown) > 1 else width, 7), layout="constrained")
    panels = np.atleast_1d(figure.subplots(2, 2) if len(axes_shown) > 1 else figure.subplots()).ravel()
    for panel, axis in zip(panels, axes_shown, strict=True):
        panel.axhline(1.0, color="#9a9a9a", lw=0.8)
        for trial in (one for one in trials if one.loop == axis):
            time, share = step_share(trial)
            panel.plot(time, share, color=COLORS[trial.controller], lw=1.4, label=trial.controller)
        if axis in own:
            panel.plot(*own[axis], color="black", lw=2.0, label="your log")
        panel.set(xlim=(-0.2, SEEN), ylim=(-0.25, 1.6), title=f"{axis}: {STEPS[axis]:g} {UNITS[axis]}")
        panel.set(xlabel="time after the step [s]", ylabel="share of the step")
        panel.grid(alpha=0.25)
    panels[0].legend(loc="lower right", fontsize=9)
    figure.savefig(path, dpi=75)


# ------------------------------------------------------------------------------------- frequencies


def transfer(told: list[float], seen: list[float], frequency: float) -> complex:
    """Return gain and phase of what is seen over what is told, from the periods after the first ones."""
    rows = slice(RATE + round(PERIODS / frequency * RATE), None)
    time = np.arange(len(told))[rows] / RATE
    angle = 2 * np.pi * frequency * time
    base = np.stack([np.cos(angle), np.sin(angle), np.ones_like(time), time - time.mean()], axis=1)

    def phasor(values: list[float]) -> complex:
        cosine, sine, *_ = np.linalg.lstsq(base, np.array(values)[rows], rcond=None)[0]
        return complex(cosine, -sine)

    return phasor(seen) / phasor(told)


def curves(trials: list[Trial]) -> dict[tuple[str, str], tuple[Array, Array]]:
    """Return frequencies (Hz) and transfer by controller and loop."""
    found: dict[tuple[str, str], list[tuple[float, complex]]] = {}
    for trial in trials:
        if trial.frequency is None:
            continue
        one = transfer(trial.told, trial.seen, trial.frequency)
        found.setdefault((trial.controller, trial.loop), []).append((trial.frequency, one))
        if trial.told_rate:
            inner = transfer(trial.told_rate, trial.seen_rate, trial.frequency)
            found.setdefault((trial.controller, "rate"), []).append((trial.frequency, inner))
    return {key: (np.array([f for f, _ in points]), np.array([g for _, g in points])) for key, points in found.items()}


def bandwidth(frequencies: Array, gains: Array) -> float | None:
    """Return where the gain falls below -3 dB (Hz), or None within the measured band."""
    decibels = 20 * np.log10(np.abs(gains))
    below = np.flatnonzero(decibels < -3.0)
    if not len(below) or below[0] == 0:
        return None
    k = below[0]
    return float(np.exp(np.interp(3.0, -decibels[k - 1 : k + 1], np.log(frequencies[k - 1 : k + 1]))))


LOOPS = {
    "rate": "roll rate: gyro over controller.rollRate",
    "attitude": "roll: attitude over setpoint",
    "velocity": "velocity x: over setpoint",
    "x": "position x: over setpoint",
    "z": "position z: over setpoint",
    "yaw": "yaw: over setpoint",
}


def draw_bode(found: dict[tuple[str, str], tuple[Array, Array]], path: Path) -> None:
    """Draw gain and phase of each loop."""
    figure = matplotlib.figure.Figure(figsize=(12, 9), layout="constrained")
    panels = figure.subplots(4, 3)
    for k, (loop, title) in enumerate(LOOPS.items()):
        gain, phase = panels[2 * (k // 3), k % 3], panels[2 * (k // 3) + 1, k % 3]
        for (controller, name), (frequencies, values) in found.items():
            if name == loop:
                style = {"color": COLORS[controller], "marker": ".", "lw": 1.2, "label": controller}
                gain.semilogx(frequencies, 20 * np.log10(np.abs(values)), **style)
                phase.semilogx(frequencies, np.degrees(np.unwrap(np.angle(values))), **style)
        gain.axhline(-3.0, color="#9a9a9a", lw=0.8)
        gain.set(title=title, ylabel="gain [dB]", ylim=(-30, 12))
        phase.set(xlabel="frequency [Hz]", ylabel="phase [deg]", ylim=(-400, 40))
        for panel in (gain, phase):
            panel.grid(alpha=0.25, which="both")
            panel.set_xticks(TICKS, [f"{tick:g}" for tick in TICKS])
            panel.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
            panel.set_xlim((0.4, 16.0) if loop in ("rate", "attitude") else (0.12, 4.0))
    panels[2, 0].legend(fontsize=8)
    figure.savefig(path, dpi=75)


# ------------------------------------------------------------------------------------------- docs


def tables(chosen: Sequence[str], steps: list[Trial], found: dict[tuple[str, str], tuple[Array, Array]]) -> str:
    """Return the tables of docs/responses.md."""
    lines = ["| controller | " + " | ".join(f"{axis} {STEPS[axis]:g} {UNITS[axis]}" for axis in STEPS) + " |"]
    lines.append("|---|" + "---|" * len(STEPS))
    for controller in chosen:
        cells = []
        for axis in STEPS:
            trial = next(one for one in steps if (one.controller, one.loop) == (controller, axis))
            told = step_figures(*step_share(trial))
            cells.append(f"{told['rise_s']:.2f} s, {told['overshoot_percent']:.0f} %, {told['settled_s']:.1f} s")
        lines.append(f"| {controller} | " + " | ".join(cells) + " |")
    lines += ["", "| loop | " + " | ".join(chosen) + " |", "|---|" + "---|" * len(chosen)]
    for loop, title in LOOPS.items():
        cells = []
        for controller in chosen:
            known = found.get((controller, loop))
            width = None if known is None else bandwidth(*known)
            cells.append("–" if known is None else f"{width:.2f} Hz" if width else "beyond the band")
        lines.append(f"| {title} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def write_csv(steps: list[Trial], path: Path) -> None:
    """Write all steps, as shares, at 50 Hz."""
    time = step_share(steps[0])[0][::2]
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["time_s", *(f"{one.controller}.{one.loop}" for one in steps)])
        shares = np.stack([step_share(one)[1][::2] for one in steps], axis=1)
        for moment, row in zip(time, shares, strict=True):
            writer.writerow([f"{moment:.2f}", *(f"{value:.4f}" for value in row)])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--docs", type=Path, metavar="DIR", help="write pictures and steps, and print the tables")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--controllers", nargs="+", choices=CONTROLLERS, default=CONTROLLERS)
    parser.add_argument("--frequencies", nargs="+", type=float, metavar="HZ", help="instead of those of the page")
    parser.add_argument("--log", type=Path, help="a log with a step, in any format of crazychoir compare")
    parser.add_argument("--axis", choices=tuple(STEPS), default="x")
    parser.add_argument("--columns", metavar="PRESET|FILE.yaml")
    parser.add_argument("--out", type=Path, default=Path("step.png"))
    options = parser.parse_args()
    if options.log is not None:
        own = {options.axis: step_of_log(options.log, options.axis, options.columns)}
        trials = [Trial(controller, options.axis) for controller in options.controllers]
        fly(trials)
        draw_steps(trials, own, options.out)
        print(f"{options.out}: your step {step_figures(*own[options.axis])}")
        return
    chosen, slow, fast = options.controllers, options.frequencies or SLOW, options.frequencies or FAST
    steps = [Trial(controller, axis) for controller in chosen for axis in STEPS]
    sines = [Trial(controller, loop, f) for controller in chosen for loop in ("x", "z", "yaw") for f in slow]
    if "pid" in chosen:
        sines += [Trial("pid", "velocity", f) for f in slow] + [Trial("pid", "attitude", f) for f in fast]
    fly(steps)
    fly(sines)
    found = curves(sines)
    print(tables(chosen, steps, found))
    if options.docs is not None:
        draw_steps(steps, {}, options.docs / "images" / "responses_steps.png")
        draw_bode(found, options.docs / "images" / "responses_bode.png")
        write_csv(steps, options.docs / "responses_steps.csv")
    if options.json is not None:
        told = {f"{one.controller}.{one.loop}": step_figures(*step_share(one)) for one in steps}
        options.json.write_text(json.dumps(told, indent=1) + "\n")


if __name__ == "__main__":
    main()
