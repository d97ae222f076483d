"""Is the filter honest? Errors of the estimate over the deviations that the filter believes, for every system.

    python benchmarks/estimator_consistency.py --seeds 20 --markdown table.md
    python benchmarks/estimator_consistency.py --systems mocap lighthouse --set mocap_quality=poor

One drone per seed takes off, hovers and then flies a square by velocity commands. The normalized error squared (NEES)
of position, velocity and attitude is 3 on average for a filter that knows its errors, larger for one that trusts itself
too much, smaller for one that is too careful. `in band` is the share of instants at which the mean over all seeds lies
within the 95 % band of that mean. NIS is the normalized innovation squared of every scalar measurement that the filter
takes, 1 on average for an honest filter. `gain` is the slope of estimated over true velocity.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from innovations import Innovations
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from crazychoir_fw.mission.fleet import POSITIONINGS
from crazychoir_fw.onboard.variables import log_table
from crazychoir_fw.simulation import Drone, DroneConfig, World

SYSTEMS = tuple(system for system in POSITIONINGS if system != "none")
SPEED, SIDE = 0.4, 2.0
"""Of the square: velocity command (m/s) and time per side (s)."""

_SETTLE, _HOVER = 8.0, 8.0  # [s] after a takeoff of 2 s
_EVERY = 0.05  # [s]
_BAND = (0.025, 0.975)


@dataclass
class Flight:
    """What one drone believed and did, sampled at 20 Hz; errors are estimate minus truth."""

    nees: NDArray[np.float64]
    """Normalized error squared of position, velocity, attitude, shape (T, 3)."""
    error: NDArray[np.float64]
    """Of the position (m, world), shape (T, 3)."""
    velocity: NDArray[np.float64]
    """True and estimated velocity (m/s, world), shape (T, 2, 3)."""
    nis: NDArray[np.float64]
    """Of every scalar measurement, shape (M,)."""


class _Belief:
    """State and covariance of the built-in filter, where they are in the memory of a drone."""

    def __init__(self, drone: Drone) -> None:
        place = log_table(drone.provider_number)["kalman.varX"].offset
        self._covariance = drone.memory[place : place + 4 * 81].view(np.float32).reshape(9, 9)
        self._state = drone.memory[place - 4 * 22 : place].view(np.float32)

    def read(self) -> tuple[NDArray, NDArray, Rotation]:
        """Return state (9,), covariance (9, 9) and attitude."""
        state = self._state.astype(float)
        w, x, y, z = state[9:13]
        return state[:9], self._covariance.astype(float), Rotation.from_quat([x, y, z, w])


def _sample(drone: Drone, belief: _Belief) -> tuple[list[float], NDArray, NDArray]:
    state, covariance, attitude = belief.read()
    truth = Rotation.from_quat(drone.true_quat_wxyz[[1, 2, 3, 0]])
    velocity = attitude.apply(state[3:6])
    errors = (
        state[0:3] - drone.true_position,
        # in the body, where the filter has it: a tilt error of the filter turns no velocity
        state[3:6] - truth.inv().apply(drone.true_velocity),
        (truth.inv() * attitude).as_rotvec(),
    )
    blocks = [covariance[i : i + 3, i : i + 3] for i in (0, 3, 6)]
    nees = [float(e @ np.linalg.solve(block, e)) for e, block in zip(errors, blocks, strict=True)]
    return nees, errors[0], np.array([drone.true_velocity, velocity])


def _square(drone: Drone, elapsed: float) -> None:
    side = int(elapsed / SIDE) % 4
    vx, vy = ((SPEED, 0.0), (0.0, SPEED), (-SPEED, 0.0), (0.0, -SPEED))[side]
    drone.commander.send_velocity_world_setpoint(vx, vy, 0.0, 0.0)


def fly(
    config: DroneConfig, seed: int, seconds: float = 4 * SIDE, has_innovations: bool = True
) -> tuple[Flight, Flight]:
    """Fly one drone and return what it believed in hover and in motion.

    Args:
        config: The drone.
        seed: Of the world.
        seconds: Of hover after settling, and of motion.
        has_innovations: Whether to read the innovations, for which every tick is looked at.
    """
    world = World([config], seed=seed)
    world.wait_until_ready()
    drone = world.drones[0]
    drone.high_level_commander.takeoff(1.0, 2.0)
    world.run(2.0 + _SETTLE)
    innovations = Innovations(drone) if has_innovations else None
    hover = _record(world, drone, innovations, seconds, moves=False)
    motion = _record(world, drone, innovations, seconds, moves=True)
    return hover, motion


def _record(world: World, drone: Drone, innovations: Innovations | None, seconds: float, moves: bool) -> Flight:
    belief, start = _Belief(drone), world.time
    samples, nis = [], []
    ticks = round(1000 * _EVERY)
    for step in range(round(seconds / _EVERY)):
        if moves:
            _square(drone, step * _EVERY)
        if innovations is not None:
            for _ in range(ticks):
                innovations.watch()
                world.step()
                nis += innovations.read()
        else:
            world.step(ticks)
        samples.append(_sample(drone, belief))
    if drone.failure is not None:
        raise RuntimeError(f"{drone.id} failed after {world.time - start:.1f} s: {drone.failure}")
    nees, error, velocity = (np.array(part) for part in zip(*samples, strict=True))
    return Flight(nees, error, velocity, np.array(nis))


def _in_band(nees: NDArray) -> float:
    """Return the share of instants at which the mean over all seeds is within its band; `nees` has shape (N, T)."""
    count = len(nees)
    low, high = chi2.ppf(_BAND, 3 * count) / count
    mean = nees.mean(axis=0)
    return float(np.mean((mean >= low) & (mean <= high)))


def gain(flights: Sequence[Flight]) -> float:
    """Return the slope of estimated over true horizontal velocity, without each flight's own mean error."""
    true = np.concatenate([f.velocity[:, 0, :2] - f.velocity[:, 0, :2].mean(axis=0) for f in flights]).ravel()
    estimated = np.concatenate([f.velocity[:, 1, :2] - f.velocity[:, 1, :2].mean(axis=0) for f in flights]).ravel()
    return float(true @ estimated / (true @ true))


def figures(flights: Sequence[Flight]) -> dict[str, float | list[float]]:
    """Return mean NEES, share in band, RMS error (mm) and mean NIS over flights of one part."""
    nees = np.array([flight.nees for flight in flights])
    error = np.concatenate([flight.error for flight in flights])
    nis = np.concatenate([flight.nis for flight in flights])
    return {
        "nees": [float(value) for value in nees.mean(axis=(0, 1))],
        "in_band": [_in_band(nees[:, :, i]) for i in range(3)],
        "rms_mm": [float(1000 * value) for value in np.sqrt(np.mean(error**2, axis=0))],
        "nis": float(nis.mean()) if len(nis) else float("nan"),
    }


def measure(
    systems: Sequence[str], seeds: int, nis_seeds: int, attributes: Mapping[str, str | float], **config: object
) -> Iterator[dict[str, object]]:
    """Fly every system with every seed; yield one row per system."""
    for system in systems:
        drone = DroneConfig("cf1", (0.0, 0.0), positioning=system, attributes=attributes, **config)
        hover, motion = zip(
            *(fly(drone, seed, has_innovations=seed <= nis_seeds) for seed in range(1, seeds + 1)), strict=True
        )
        yield {"system": system, "hover": figures(hover), "motion": figures(motion), "gain": gain(motion)}


_COLUMNS = (
    "`positioning`",
    *(
        f"{part}{what}"
        for part in ("hover: ", "motion: ")
        for what in ("position, velocity, attitude", "in band [%]", "NIS")
    ),
    "error in hover, motion [mm]",
    "gain",
)
HEADER = f"| {' | '.join(_COLUMNS)} |\n|{'---|' * len(_COLUMNS)}"


def _line(row: Mapping) -> str:
    cells = [f"`{row['system']}`"]
    for part in (row["hover"], row["motion"]):
        cells += [", ".join(f"{value:.2g}" for value in part["nees"])]
        cells += [", ".join(f"{100 * value:.0f}" for value in part["in_band"])]
        cells += [f"{part['nis']:.2g}"]
    cells += [", ".join(f"{np.linalg.norm(row[part]['rms_mm']):.1f}" for part in ("hover", "motion"))]
    cells += [f"{row['gain']:.3f}"]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--systems", nargs="+", default=SYSTEMS, choices=SYSTEMS)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--nis-seeds", type=int, default=4, help="of these, how many are looked at tick by tick")
    parser.add_argument("--set", nargs="+", default=[], metavar="NAME=VALUE", help="attributes of the plugin")
    parser.add_argument("--vehicle", nargs="+", default=[], help="nanobench, kit, legacy or a YAML file")
    parser.add_argument("--markdown", type=Path)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    attributes = dict(pair.split("=", 1) for pair in options.set)
    rows = []
    print(HEADER)
    for row in measure(options.systems, options.seeds, options.nis_seeds, attributes, vehicle=options.vehicle):
        rows.append(row)
        print(_line(row), flush=True)
    if options.markdown:
        options.markdown.write_text("\n".join([HEADER, *map(_line, rows)]) + "\n")
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
