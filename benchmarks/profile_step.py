"""Where a step goes: instructions and cache misses of each stage, per drone and step, by the size of the swarm.

    python benchmarks/profile_step.py
    python benchmarks/profile_step.py --drones 1 100 --json profile.json

A simulated processor counts (callgrind of valgrind, which this benchmark alone needs: `apt install valgrind`), so the
figures do not depend on the machine or on what else it does: 32 KB and 48 KB of first-level cache for instructions and
data, and a second level of 2 MB for both. An instruction takes a fraction of a nanosecond; a miss of the first level
takes 15 cycles, of the second some 70 ns if nothing hides it. The simulated processor does no prefetching.

The swarm takes off outside of valgrind and is handed over as a compiled model with its state.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from swarm_scale import hovering_world

from crazychoir_fw._core import lib

STATE = mujoco.mjtState.mjSTATE_INTEGRATION
EVENTS = ("Ir", "I1mr", "D1mr", "D1mw", "ILmr", "DLmr", "DLmw")
CACHES = ("--I1=32768,8,64", "--D1=49152,12,64", "--LL=2097152,16,64")
WARM_UP_STEPS = 4

# what a stage takes: functions that count, and functions within them that do not
STAGES = {
    "kinematics, centers of mass": (("mj_fwdKinematics",), ()),
    "inertia matrix and its factors": (("mj_crb", "mj_factorM"), ()),
    "collisions: sweep and prune": (("mj_SAP",), ()),
    "collisions: pairs": (("mj_collision",), ("mj_SAP", "leaves_out")),
    "velocities": (("mj_comVel",), ()),
    "bias forces": (("mj_rne",), ()),
    "passive forces": (("mj_passive",), ("compute",)),
    "accelerations": (("mj_fwdAcceleration",), ()),
    "constraints": (("mj_makeConstraint", "mj_fwdConstraint"), ()),
    "integration": (("mj_EulerSkip",), ("advance",)),
    "MuJoCo, the rest": ((), ()),
    "contact filter": (("leaves_out",), ()),
    "sample, rest, look around": (
        ("advance",),
        ("cf_sense", "cf_think", "cf_rotors_step", "cf_battery_step", "cf_forces_of"),
    ),
    "sense": (("cf_sense",), ()),
    "think": (("cf_think",), ()),
    "actuate": (("cf_rotors_step", "cf_battery_step"), ()),
    "forces": (("cf_forces_of", "compute"), ()),
}
REST = "MuJoCo, the rest"
OURS = tuple(STAGES)[tuple(STAGES).index(REST) + 1 :]
WITHIN_OURS = frozenset(name for stage in OURS for name in (*STAGES[stage][0], *STAGES[stage][1]))

_LINE = re.compile(r"^\s*(?P<counts>(?:[\d,.]+ (?:\([ \d.]+%\))?\s*)+)(?P<where>\S.*)$")
_SUFFIX = re.compile(r"\.(lto_priv|part|isra|constprop|llvm|cold)\b.*")


def prepare(count: int, folder: Path) -> None:
    """Let a swarm take off, and save its model and state."""
    world = hovering_world(count)
    state = np.empty(mujoco.mj_stateSize(world.model, STATE))
    mujoco.mj_getState(world.model, world.data, state, STATE)
    mujoco.mj_saveModel(world.model, str(folder / "model.mjb"))
    state.tofile(folder / "state")


def step_under_valgrind(folder: Path, steps: int) -> None:
    """Go on from there; what callgrind counts are the calls of mj_step."""
    model = mujoco.MjModel.from_binary_path(str(folder / "model.mjb"))
    data = mujoco.MjData(model)
    mujoco.mj_setState(model, data, np.fromfile(folder / "state"), STATE)
    lib.cf_plugin_overlap(model._address, data._address, True)
    for _ in range(WARM_UP_STEPS):
        mujoco.mj_step1(model, data)
        mujoco.mj_step2(model, data)
    mujoco.mj_step(model, data, nstep=steps)
    lib.cf_plugin_overlap(model._address, data._address, False)
    os._exit(0)  # quickly: freeing all this takes valgrind seconds


def count_events(folder: Path, steps: int) -> dict[str, np.ndarray]:
    """Return what each function and what it calls took, in the order of EVENTS."""
    out = folder / "callgrind.out"
    own = [sys.executable, __file__, "--continue", str(folder), "--steps", str(steps)]
    tool = ["valgrind", "--tool=callgrind", "--cache-sim=yes", *CACHES, "--toggle-collect=mj_step"]
    run = subprocess.run(
        [*tool, f"--callgrind-out-file={out}", *own],
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
    )
    if run.returncode or not out.exists():
        raise SystemExit(f"valgrind failed:\n{run.stderr[-2000:]}")
    annotate = ["callgrind_annotate", "--inclusive=yes", "--threshold=100", f"--show={','.join(EVENTS)}", str(out)]
    return read_annotation(subprocess.run(annotate, check=True, capture_output=True, text=True).stdout)


def read_annotation(text: str) -> dict[str, np.ndarray]:
    """Return the counts of each function of MuJoCo or of ours; inlined files of a function are part of it."""
    taken: dict[str, np.ndarray] = {}
    for line in text.splitlines():
        found = _LINE.match(line)
        if not found:
            continue
        numbers = re.sub(r"\([ \d.]+%\)", "", found["counts"]).replace(",", "").split()
        if len(numbers) != len(EVENTS):
            continue
        counts = np.array([0.0 if number == "." else float(number) for number in numbers])
        where = found["where"]
        if "PROGRAM TOTALS" in where:
            taken["all"] = counts
            continue
        name = _SUFFIX.sub("", where.split(" [")[0].rsplit(":", 1)[-1])
        if name in WITHIN_OURS and "libmujoco" in where:
            continue  # MuJoCo has functions of the same names
        if name not in taken or counts[0] > taken[name][0]:
            taken[name] = counts
    return taken


def stages_of(taken: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return what each stage took."""
    nothing = np.zeros(len(EVENTS))
    stages = {
        stage: sum((taken.get(name, nothing) for name in added), nothing)
        - sum((taken.get(name, nothing) for name in left_out), nothing)
        for stage, (added, left_out) in STAGES.items()
    }
    stages[REST] = taken["all"] - sum(stages.values(), nothing)
    return stages


def profile(count: int, steps: int) -> dict[str, dict[str, float]]:
    """Return instructions and misses per drone and step, by stage."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        # in a process of its own, so that the memory of a large swarm is free again
        subprocess.run([sys.executable, __file__, "--prepare", str(folder), "--drones", str(count)], check=True)
        stages = stages_of(count_events(folder, steps))
    stages["all of MuJoCo"] = sum(stages[stage] for stage in STAGES if stage not in OURS)
    stages["all of ours"] = sum(stages[stage] for stage in OURS)
    return {
        stage: {
            "instructions": counts[0] / (count * steps),
            "misses_l1": counts[1:4].sum() / (count * steps),
            "misses_l2": counts[4:7].sum() / (count * steps),
        }
        for stage, counts in stages.items()
    }


def print_table(profiles: dict[int, dict[str, dict[str, float]]]) -> None:
    """Print the profiles side by side, as a table of Markdown."""
    print("| per drone and step | " + " | ".join(f"{count} drones" for count in profiles) + " |")
    print("|---|" + "---|" * len(profiles))
    for stage in next(iter(profiles.values())):
        cells = (
            f"{p[stage]['instructions']:.0f} / {p[stage]['misses_l1']:.1f} / {p[stage]['misses_l2']:.1f}"
            for p in profiles.values()
        )
        print(f"| {stage} | " + " | ".join(cells) + " |")


def main() -> None:
    """Profile, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drones", type=int, nargs="+", default=[1, 100, 1000, 3000])
    parser.add_argument(
        "--steps", type=int, default=10, help="a multiple of 10, since the slowest stages run at 100 Hz"
    )
    parser.add_argument("--json", type=Path)
    parser.add_argument("--prepare", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--continue", dest="folder", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.prepare:
        return prepare(arguments.drones[0], arguments.prepare)
    if arguments.folder:
        return step_under_valgrind(arguments.folder, arguments.steps)
    if not shutil.which("valgrind"):
        raise SystemExit("this benchmark counts with valgrind, which is not installed: apt install valgrind")
    profiles: dict[int, Any] = {}
    for count in arguments.drones:
        print(f"{count} drones ...", file=sys.stderr)
        profiles[count] = profile(count, arguments.steps)
    print("instructions / misses of the first-level caches / misses of a second-level cache of 2 MB\n")
    print_table(profiles)
    if arguments.json:
        arguments.json.write_text(json.dumps({"steps": arguments.steps, "profiles": profiles}, indent=2) + "\n")
    return None


if __name__ == "__main__":
    main()
