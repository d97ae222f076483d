"""Install a wheel where there is no compiler, and do what README promises.

    python .ci/fly_wheel.py dist/crazychoir_fw-*.whl

Prints what the installation weighs and how much processor time the first flight takes; fails when a promise is broken.
"""

from __future__ import annotations

import argparse
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

BASE_MB = 300
FILES_MB = 250
"""Sizes of the files that pip installs, without pip itself; unused ends of blocks on the disk are left out."""
TOOLS = ("pip", "setuptools", "pkg_resources", "_distutils_hack")
IMPORT_S, HELP_S, FLIGHT_S = 0.15, 0.4, 30.0
USERS_PROGRAM = """\
from crazychoir_fw.simulation import DroneConfig, World

world = World([DroneConfig("cf1", (0.0, 0.0))], seed=1)
reveal_type(world["cf1"].true_position)
world.run("one second")
"""


def run(words: list[str], where: Path, **options: object) -> subprocess.CompletedProcess[str]:
    """Run a command without compilers on PATH, in an empty folder."""
    environment = {
        "PATH": str(where / "venv/bin"),
        "HOME": str(where),
        "MUJOCO_GL": os.environ.get("MUJOCO_GL", ""),
        **{name: value for name, value in os.environ.items() if name.startswith(("PIP_", "SSL_", "HTTP", "http"))},
    }
    return subprocess.run(words, cwd=where, env=environment, text=True, check=False, **options)  # type: ignore[call-overload]


def processor_time(words: list[str], where: Path) -> float:
    """Return the median of the processor time of five runs (s)."""
    times = []
    for _ in range(5):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        assert run(words, where, stdout=subprocess.DEVNULL).returncode == 0, words
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return sorted(times)[2]


def weigh(folder: Path) -> dict[str, float]:
    """Return how large each package of an environment is (MB)."""
    return {
        entry.name: sum(file.lstat().st_blocks * 512 for file in [entry, *entry.rglob("*")]) / 2**20
        for entry in folder.iterdir()
    }


def is_tool(file: Path, site: Path) -> bool:
    """Return whether a file belongs to what each virtual environment begins with."""
    return file.relative_to(site).parts[0].split("-")[0] in TOOLS


def check(wheel: Path, project: Path, where: Path, typed: bool) -> list[str]:
    """Return what is broken."""
    broken = []
    subprocess.run([sys.executable, "-m", "venv", where / "venv"], check=True)
    python, crazychoir = str(where / "venv/bin/python"), str(where / "venv/bin/crazychoir")
    assert run([python, "-m", "pip", "install", "-q", "--only-binary", ":all:", str(wheel)], where).returncode == 0
    for name in ("gcc", "cc", "clang"):
        assert shutil.which(name, path=str(where / "venv/bin")) is None

    site = Path(run([python, "-c", "import mujoco; print(mujoco.__path__[0])"], where, stdout=-1).stdout.strip()).parent
    packages = weigh(site)
    whole = sum(packages.values())
    brought = sum(file.stat().st_size for file in site.rglob("*") if file.is_file() and not is_tool(file, site)) / 2**20
    heaviest = sorted(packages.items(), key=lambda item: -item[1])[:12]
    print(
        f"installed: {whole:.0f} MB on the disk, {brought:.0f} MB of files beside pip, of which",
        ", ".join(f"{name} {size:.0f}" for name, size in heaviest),
    )
    if whole > BASE_MB:
        broken.append(f"the base installation takes {whole:.0f} MB, allowed: {BASE_MB}")
    if brought > FILES_MB:
        broken.append(f"pip brings {brought:.0f} MB of files, allowed: {FILES_MB}")

    begin = resource.getrusage(resource.RUSAGE_CHILDREN)
    flown = run([crazychoir, "fly", str(project / "examples/bearing_formation.yaml")], where)
    end = resource.getrusage(resource.RUSAGE_CHILDREN)
    took = end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime
    print(f"first flight: {took:.1f} s of processor time")
    if flown.returncode or not (where / "out/bearing_formation/flight.png").exists():
        broken.append(f"README's first flight ended with {flown.returncode} and {list(where.glob('out/*/*'))}")
    if took > FLIGHT_S:
        broken.append(f"README's first flight took {took:.0f} s, allowed: {FLIGHT_S:.0f}")

    for words, most in (([python, "-c", "import crazychoir_fw"], IMPORT_S), ([crazychoir, "--help"], HELP_S)):
        seconds = processor_time(words, where)
        print(f"{' '.join(words[1:])}: {seconds:.2f} s of processor time")
        if seconds > most:
            broken.append(f"{' '.join(words[1:])} takes {seconds:.2f} s, allowed: {most}")

    built = run([crazychoir, "app", "build", str(project / "examples/app_task/hop.c")], where, stderr=-1, stdout=-1)
    if not built.returncode or "Traceback" in built.stderr or "compiler" not in built.stderr:
        broken.append(f"an app without a compiler must end with a sentence about compilers, said: {built.stderr}")
    for kind in ("mission", "guidance", "controller", "app", "policy", "scene"):
        if run([crazychoir, "new", kind, f"my_{kind}"], where, stdout=-1).returncode:
            broken.append(f"`crazychoir new {kind}` does not find its files in the installed package")
    for file in ("ament_index/resource_index/packages/crazychoir_fw", "crazychoir_fw/package.xml",
                 "crazychoir_fw/launch/bearing_formation.launch.py"):  # fmt: skip
        if not (where / "venv/share" / file).exists():
            broken.append(f"share/{file} is not installed, so ROS 2 does not find the package")
    return broken + (check_types(python, where) if typed else [])


def check_types(python: str, where: Path) -> list[str]:
    """Return what a type checker does not see in a program that uses the installed package."""
    (where / "program.py").write_text(USERS_PROGRAM)
    assert run([python, "-m", "pip", "install", "-q", "mypy"], where).returncode == 0
    said = run([python, "-m", "mypy", "program.py"], where, stdout=-1).stdout
    wanted = ('has incompatible type "str"; expected "float"', "numpy.ndarray")
    return [f"the type checker does not say {text}, but: {said}" for text in wanted if text.lower() not in said.lower()]


def main() -> None:
    """Check one wheel."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path)
    parser.add_argument("--project", type=Path, default=Path(__file__).resolve().parents[1])
    parser.add_argument("--typed", action="store_true", help="also check a program of a user with mypy")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        broken = check(arguments.wheel.resolve(), arguments.project.resolve(), Path(folder), arguments.typed)
    for sentence in broken:
        print(f"broken: {sentence}", file=sys.stderr)
    sys.exit(len(broken))


if __name__ == "__main__":
    main()
