"""What a drone's tick costs with each provider, and what of it is the switch from drone to drone.

    python benchmarks/provider_cost.py --path ~/crazyflie-firmware --drones 100 --json providers.json

Builtin is compared with a checkout at each of its levels: its algorithms, the modules around them, its loop as well. A
compiled provider keeps its variables in one place: before a drone's tick they are copied there, afterwards back.
Without --path the checkout of the environment variable CRAZYFLIE_FIRMWARE or of the submodule is taken, and without
one the miniature of the tests. Runs alternate between the providers; figures are medians.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from swarm_scale import hovering_world

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import CheckoutError
from crazychoir_fw.firmware import providers
from crazychoir_fw.firmware.checkout import locate, open_checkout
from crazychoir_fw.firmware.levels import LEVELS, word_of
from crazychoir_fw.simulation import World, set_threads

TICKS = 500  # timed at a time
SWITCHES = 20_000


def checkout(path: Path | None, folder: Path) -> Path:
    """Return the checkout that is asked for, or a miniature in this folder."""
    try:
        return open_checkout(locate(path)).root
    except CheckoutError:
        if path is not None:
            raise
    sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "firmware"))
    from miniature import lay_out

    return lay_out(folder / "miniature")


def tick_microseconds(world: World) -> float:
    """Return the mean cost (µs) of a drone's onboard tick."""
    spent = np.zeros(2, np.uint64)
    lib.cf_plugin_timing(1)
    mujoco.mj_step(world.model, world.data, nstep=TICKS)
    lib.cf_plugin_timing_read(ffi.cast("uint64_t *", spent.ctypes.data))
    lib.cf_plugin_timing(0)
    return float(spent[0]) * 1e-3 / (TICKS * len(world.drones))


def switch_microseconds(number: int, drones: int) -> float:
    """Return what it costs (µs) to bring the variables of a drone to their place and back, drones taking turns."""
    provider, builtin = lib.cf_provider(number), lib.cf_provider(0)
    blocks = [ffi.new("uint64_t[]", provider.state_bytes // 8) for _ in range(drones)]
    for block in blocks:
        provider.init(block, lib.CF_PLATFORM_CF2, 0)
    plain = ffi.new("uint64_t[]", builtin.state_bytes // 8)
    turns = [blocks[i % drones] for i in range(SWITCHES)]
    begin, end, nothing = provider.begin, provider.end, builtin.plan_is_stopped

    started = time.perf_counter()
    for block in turns:
        begin(block)
        end(block)
    switched = time.perf_counter()
    for _ in turns:
        nothing(plain)
        nothing(plain)
    # what calling from Python costs is not the switch's
    return ((switched - started) - (time.perf_counter() - switched)) * 1e6 / SWITCHES


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--path", type=Path, help="a checkout of the firmware")
    parser.add_argument("--drones", type=int, default=100)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()

    set_threads(1)
    with tempfile.TemporaryDirectory() as folder:
        os.environ["CRAZYFLIE_FIRMWARE"] = str(checkout(options.path, Path(folder)))
        numbers = {word: providers.load(word, "cf2") for word in map(word_of, LEVELS)}
        worlds = {word: hovering_world(options.drones, word) for word in ("builtin", *numbers)}
    ticks: dict[str, list[float]] = {word: [] for word in worlds}
    switches: dict[str, list[float]] = {word: [] for word in numbers}
    for _ in range(options.repeats):
        for word, world in worlds.items():
            ticks[word].append(tick_microseconds(world))
        for word, number in numbers.items():
            switches[word].append(switch_microseconds(number, options.drones))

    result: dict[str, Any] = {
        "drones": options.drones,
        "bytes_of_variables": {word: lib.cf_provider(number).state_bytes for word, number in numbers.items()},
        "us_per_switch": {word: statistics.median(values) for word, values in switches.items()},
        "us_per_tick": {word: statistics.median(values) for word, values in ticks.items()},
    }
    print(f"{'':20} {'tick':>8} {'switch':>8} {'variables':>10}")
    for word, cost in result["us_per_tick"].items():
        switch, size = result["us_per_switch"].get(word), result["bytes_of_variables"].get(word)
        more = f"{switch:5.3f} µs {size:8d} B" if switch is not None else ""
        print(f"{word:20} {cost:5.3f} µs {more}".rstrip())
    if options.json:
        options.json.write_text(json.dumps(result, indent=2) + "\n")


if __name__ == "__main__":
    main()
