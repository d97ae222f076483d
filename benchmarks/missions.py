"""How long every mission of the examples takes, from the command to its table, and to its film.

    python benchmarks/missions.py                        # all of them
    python benchmarks/missions.py hello_swarm swap_ten   # those with one of these words in their names
    python benchmarks/missions.py --no-film --json missions.json

Each is flown by the command in its header. Where that flies over the radio, the simulation that the header names is
served. Times are those of the clock on the wall from the start of a process: a machine that has other work shows
longer ones, which is why processor time stands beside them.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import shlex
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CODE = "from crazychoir_fw.cli import app\napp()"
COMMAND = re.compile(r"^#.*?crazychoir (fly|serve) (examples/\S+\.yaml[^#\n&]*)", re.MULTILINE)


@dataclass
class Row:
    """One mission."""

    mission: str
    command: str
    table_s: float | None
    """Wall time from the command to the verdict below its table (s)."""
    done_s: float
    """To the end of the command, with log and plot (s)."""
    film_s: float | None
    """To the end of `crazychoir film` behind it (s)."""
    cpu_s: float
    """Processor time of flying (s)."""
    verdict: str


def main() -> None:
    """Fly them, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*", help="parts of names of missions; none means all")
    parser.add_argument("--no-film", action="store_true", help="make no films")
    parser.add_argument("--json", type=Path, help="write the rows to a file")
    arguments = parser.parse_args()
    missions = [path for path in sorted((ROOT / "examples").rglob("*.yaml")) if is_mission(path)]
    chosen = [path for path in missions if not arguments.words or any(word in str(path) for word in arguments.words)]
    print("| mission | table (s) | log and plot (s) | film (s) | CPU (s) | verdict |\n|---|---|---|---|---|---|")
    rows = []
    for path in chosen:
        row = fly(path, not arguments.no_film)
        rows.append(row)
        seconds = ["-" if value is None else f"{value:.1f}" for value in (row.table_s, row.done_s, row.film_s)]
        print(f"| {row.mission} | {' | '.join(seconds)} | {row.cpu_s:.1f} | {row.verdict} |", flush=True)
    if arguments.json is not None:
        arguments.json.write_text(json.dumps([asdict(row) for row in rows], indent=2) + "\n")
    sys.exit(any(not row.verdict.startswith("success") for row in rows))


def is_mission(path: Path) -> bool:
    """Return whether a file is a mission, and no campaign of one."""
    keys = set(re.findall(r"^(\w+):", path.read_text(), re.MULTILINE))
    return bool(keys & {"flight", "extends"}) and "flights" not in keys


def commands_of(path: Path) -> tuple[list[str] | None, list[str]]:
    """Return what is to be served, and what flies it, as the header of a mission says."""
    name = str(path.relative_to(ROOT))
    found = COMMAND.findall(path.read_text())
    served = [shlex.split(rest) for word, rest in found if word == "serve"]
    flown = [shlex.split(rest) for word, rest in found if word == "fly"] or [[name]]
    if not served:
        return None, flown[0]
    over_udp = [words for words in flown if "--uri-base" in words]
    return served[0], (over_udp or flown)[0]


def fly(path: Path, wants_film: bool) -> Row:
    """Fly one mission."""
    served, flown = commands_of(path)
    with tempfile.TemporaryDirectory() as folder:
        server = None if served is None else serve(served)
        try:
            before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
            table, verdict = None, "no verdict"
            with start("fly", *flown, "--out", folder) as process:
                for line in process.stdout or ():
                    if line.startswith(("success: ", "failed: ")):
                        table, verdict = time.perf_counter() - began, line.split(",")[0].strip()
            done = time.perf_counter() - began
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
        finally:
            if server is not None:
                server.terminate()
                server.communicate()
        film = None
        if wants_film and (Path(folder) / "log.npz").exists():
            with start("film", folder) as process:
                process.communicate()
            film = time.perf_counter() - began if process.returncode == 0 else None
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    name = str(path.relative_to(ROOT / "examples"))
    return Row(name, shlex.join(["crazychoir", "fly", *flown]), table, done, film, used, verdict)


def serve(words: list[str]) -> subprocess.Popen[str]:
    """Serve what stands in for real drones, and wait until it does."""
    process = start("serve", *words)
    for line in process.stdout or ():
        if "udp://" in line:
            break
    return process


def start(*words: str) -> subprocess.Popen[str]:
    """Start a command."""
    return subprocess.Popen(
        [sys.executable, "-u", "-c", CODE, *words],
        cwd=ROOT,
        env={**os.environ, "COLUMNS": "200"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


if __name__ == "__main__":
    main()
