"""What one tick of the onboard software costs, for each pair of controller and estimator.

    python benchmarks/tick_cost.py --drones 100 --json ticks.json

Drones hover; then controller and estimator are switched in flight and the onboard part of the following ticks is timed.
Each figure is the median of several runs that start from the same snapshot and alternate between the pairs.
"""

from __future__ import annotations

import argparse
import itertools
import json
import statistics
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from swarm_scale import hovering_world

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.onboard.core import choices
from crazychoir_fw.simulation import World, set_threads

TICKS = 200  # timed at a time; short, because not every pair stays in the air


def onboard_microseconds(world: World, controller: int, estimator: int) -> float:
    """Return the mean cost (µs) of a drone's onboard tick with this pair, from the present state on."""
    for drone in world.drones:
        drone.param["stabilizer.controller"] = controller
        drone.param["stabilizer.estimator"] = estimator
    world.step(20)
    active = (world.drones[0].param["stabilizer.controller"], world.drones[0].param["stabilizer.estimator"])
    if active != (controller, estimator):
        raise SystemExit(f"controller and estimator {controller}, {estimator} were read back as {active}")

    spent = np.zeros(2, np.uint64)
    lib.cf_plugin_timing(1)
    mujoco.mj_step(world.model, world.data, nstep=TICKS)
    lib.cf_plugin_timing_read(ffi.cast("uint64_t *", spent.ctypes.data))
    lib.cf_plugin_timing(0)
    return float(spent[0]) * 1e-3 / (TICKS * len(world.drones))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drones", type=int, default=100)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()

    set_threads(1)
    world = hovering_world(options.drones)
    snapshot = world.snapshot()
    # the built-in provider carries nothing out of the tree
    controllers = {word: i + 1 for i, word in enumerate(choices("controller")) if word != "out_of_tree"}
    estimators = {word: i + 1 for i, word in enumerate(choices("estimator")) if word != "out_of_tree"}
    pairs = list(itertools.product(controllers, estimators))
    runs: dict[tuple[str, str], list[float]] = {pair: [] for pair in pairs}
    for _ in range(options.repeats):
        for controller, estimator in pairs:
            world.restore(snapshot)
            runs[controller, estimator].append(
                onboard_microseconds(world, controllers[controller], estimators[estimator])
            )

    rows: list[dict[str, Any]] = []
    for (controller, estimator), values in runs.items():
        rows.append({"controller": controller, "estimator": estimator, "us_per_tick": statistics.median(values)})
        print(f"{controller:12} {estimator:14} {rows[-1]['us_per_tick']:.3f} µs per drone and tick")
    if options.json:
        options.json.write_text(json.dumps({"bytes_per_drone": lib.cf_state_bytes(0), "rows": rows}, indent=2) + "\n")


if __name__ == "__main__":
    main()
