"""Lays out a small source tree with the shape of the firmware's.

The real one cannot be had everywhere and takes a second repository to compile. This one has the same files, types
and functions as far as a provider looks at them, and flies: its algorithms are ours.
"""

import re
import subprocess
from pathlib import Path

from miniature import forks, generated

HERE = Path(__file__).parent
RELEASES = {"2024.10": 202410, "2025.02": 202502, "2025.12": 202512, "2026.08": 202608, "after": 202609}
"""Releases in order. `after` is what is said of the tree behind the newest one."""

SETUP_PY = ("2023", "computed", "2025", "2026")
CMSIS = "vendor/CMSIS"
SYSTEM = HERE / "system"
"""Modules of the operating system, which a build may take or leave; laid out like tree/."""

# what came with a release; older ones lack it
SINCE = {
    "src/modules/src/controller/controller_lee.c": "2025.12",
    "src/modules/interface/controller/controller_lee.h": "2025.12",
    "src/modules/interface/kalman_core/kalman_core_params_defaults.h": "2025.12",
    "src/modules/interface/crtp_supervisor.h": "2026.08",
    "src/modules/src/crtp_supervisor.c": "2026.08",
    "src/platform/interface/platform_defaults_cf21bl.h": "2025.02",
    "configs/cf21bl_defconfig": "2025.02",
}


def for_release(text: str, release: str) -> str:
    """Leaves of `#if MINIATURE_RELEASE >= n` ... `#else` ... `#endif` what the release has."""
    lines, kept = [], []
    for line in text.splitlines(keepends=True):
        if match := re.match(r"#if MINIATURE_RELEASE >= (\d+)", line):
            kept.append(RELEASES[release] >= int(match.group(1)))
        elif line.startswith("#if"):
            kept.append(None)  # not a condition on the release
            lines.append((line, list(kept)))
        elif line.startswith("#else") and kept[-1] is not None:
            kept[-1] = not kept[-1]
        elif line.startswith("#endif") and kept.pop() is not None:
            continue
        else:
            lines.append((line, list(kept)))
    return "".join(line for line, kept in lines if False not in kept)


def _read(folder: Path) -> dict[str, str]:
    return {
        path.relative_to(folder).as_posix(): path.read_text() for path in sorted(folder.rglob("*")) if path.is_file()
    }


def _has(name: str, release: str) -> bool:
    return RELEASES[SINCE.get(name, release)] <= RELEASES[release]


def _files(release: str, setup_py: str) -> dict[str, str]:
    files = _read(HERE / "tree") | {name: make() for name, make in generated.FILES.items()} | _read(SYSTEM)
    estimator = "src/modules/interface/estimator/estimator.h"
    files[estimator] = generated.estimator(files[estimator])
    files = {name: generated.with_precise_landing(text, name) for name, text in files.items()}
    files = {name: for_release(text, release) for name, text in files.items() if _has(name, release)}

    script = (HERE / "setup_py" / f"{setup_py}.py.txt").read_text()
    # the same bits in two thirds of the compiler's time
    script = script.replace('"-O3"', '"-O1"')
    for name in SINCE:
        if not _has(name, release):
            module = re.escape(name.removeprefix("src/modules/src/"))
            script = re.sub(rf'.*"(src/modules/src/)?{module}",\n', "", script)
    files["bindings/setup.py"] = script
    files["cffirmware_setup.py"] = script  # what `make bindings_python` copies to build/setup.py
    return files


def _commit(folder: Path, release: str) -> None:
    def git(*arguments: str) -> None:
        command = ["git", "-C", str(folder), "-c", "user.name=miniature", "-c", "user.email=miniature@localhost"]
        subprocess.run([*command, *arguments], check=True, capture_output=True)

    git("-c", "init.defaultBranch=master", "init")
    git("add", "--all")
    git("-c", "commit.gpgsign=false", "commit", "--message", f"Release {release}")
    git("-c", "tag.gpgsign=false", "tag", release)


def lay_out(
    folder: Path,
    *,
    release: str = "2026.08",
    setup_py: str = "2025",
    cmsis: bool = True,
    git: bool = False,
    fork: str | None = None,
) -> Path:
    """Writes a checkout into a folder, which is made.

    Args:
        folder: where the root of the checkout shall be.
        release: one of RELEASES. They differ as docs/reference/upstream-shape.md#7.2 says that the firmware's did.
        setup_py: one of SETUP_PY, the form of bindings/setup.py.
        cmsis: whether the nested submodule vendor/CMSIS is there; its empty folder is in any case.
        git: whether to make it a repository with one commit, tagged with the release.
        fork: one of forks.FORKS, the changes of a fork; None: the release without changes.
    """
    files = {name: text.encode() for name, text in _files(release, setup_py).items()}
    if fork is not None:
        files = forks.FORKS[fork](files)
    for name, content in files.items():
        if cmsis or not name.startswith(CMSIS + "/"):
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
    (folder / CMSIS).mkdir(parents=True, exist_ok=True)
    if git:
        _commit(folder, release)
    return folder
