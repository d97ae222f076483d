"""Lays out a small source tree with the shape of the firmware's.

The real one cannot be had everywhere and takes a second repository to compile. This one has the same files, types
and functions as far as a provider looks at them, and flies: its algorithms are ours.
"""

import re
import subprocess
from pathlib import Path

from miniature import generated

HERE = Path(__file__).parent
RELEASES = {"2024.10": 202410, "2025.02": 202502, "2026.08": 202608}
SETUP_PY = ("2023", "2025", "2026")
CMSIS = "vendor/CMSIS"

# what came with a release; older ones lack it
SINCE = {
    "src/modules/src/controller/controller_lee.c": "2026.08",
    "src/modules/interface/controller/controller_lee.h": "2026.08",
}


def for_release(text: str, release: str) -> str:
    """Leaves of `#if MINIATURE_RELEASE >= n` ... `#else` ... `#endif` what the release has."""
    lines, kept = [], []
    for line in text.splitlines(keepends=True):
        if match := re.match(r"#if MINIATURE_RELEASE >= (\d+)", line):
            kept.append(RELEASES[release] >= int(match.group(1)))
        elif line.startswith("#if"):
            kept.append(None)  # somebody else's
            lines.append((line, list(kept)))
        elif line.startswith("#else") and kept[-1] is not None:
            kept[-1] = not kept[-1]
        elif line.startswith("#endif") and kept.pop() is not None:
            continue
        else:
            lines.append((line, list(kept)))
    return "".join(line for line, kept in lines if False not in kept)


def _files(release: str, setup_py: str) -> dict[str, str]:
    tree = HERE / "tree"
    files = {path.relative_to(tree).as_posix(): path.read_text() for path in sorted(tree.rglob("*")) if path.is_file()}
    files |= {name: make() for name, make in generated.FILES.items()}
    estimator = "src/modules/interface/estimator/estimator.h"
    files[estimator] = generated.estimator(files[estimator])
    files = {name: for_release(text, release) for name, text in files.items()}
    files = {name: text for name, text in files.items() if SINCE.get(name, release) <= release}

    script = (HERE / "setup_py" / f"{setup_py}.py.txt").read_text()
    for name, since in SINCE.items():
        if release < since:
            module = re.escape(name.removeprefix("src/modules/src/"))
            script = re.sub(rf'.*"(src/modules/src/)?{module}",\n', "", script)
    files["bindings/setup.py"] = script
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
    folder: Path, *, release: str = "2026.08", setup_py: str = "2025", cmsis: bool = True, git: bool = False
) -> Path:
    """Writes a checkout into a folder, which is made.

    Args:
        folder: where the root of the checkout shall be.
        release: one of RELEASES. They differ as the dossiers say that the firmware's did.
        setup_py: one of SETUP_PY, the form of bindings/setup.py.
        cmsis: whether the nested submodule vendor/CMSIS is there; its empty folder is in any case.
        git: whether to make it a repository with one commit, tagged with the release.
    """
    for name, text in _files(release, setup_py).items():
        if cmsis or not name.startswith(CMSIS + "/"):
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
    (folder / CMSIS).mkdir(parents=True, exist_ok=True)
    if git:
        _commit(folder, release)
    return folder
