"""A checkout of the firmware: where it is, whether it is complete, and which version."""

from __future__ import annotations

import os
import shlex
import subprocess
from dataclasses import dataclass
from pathlib import Path

import crazychoir_fw
from crazychoir_fw.common.errors import CheckoutError

VARIABLE = "CRAZYFLIE_FIRMWARE"
"""Environment variable that names a checkout."""

SUBMODULE = "firmware"
UPSTREAM = "https://github.com/bitcraze/crazyflie-firmware"
SUPPORTED = "releases 2024.10 and later"
PINNED = "2026.08"

SETUP = Path("bindings", "setup.py")
MODULES = Path("src", "modules", "src")
VENDOR = "vendor"
CMSIS = Path(VENDOR, "CMSIS")
CMSIS_HEADER = CMSIS / "CMSIS" / "DSP" / "Include" / "arm_math.h"


@dataclass(frozen=True)
class Checkout:
    """A folder with the sources of the firmware, complete enough to be compiled."""

    root: Path
    """Absolute path."""

    def version(self) -> str | None:
        """Return what `git describe` calls this folder; None without git, or if it is no repository itself."""
        return describe(self.root)


def project_root() -> Path | None:
    """Return the source checkout of this project: the one that runs, else the one that the work directory is in.

    An installed package runs from elsewhere, while its user stands in the repository that it was installed from.
    """
    runs = Path(crazychoir_fw.__file__).resolve().parents[1]
    here = Path.cwd()
    return next((root for root in (runs, here, *here.parents) if _is_project(root)), None)


def _is_project(root: Path) -> bool:
    return (root / "bindings" / "provider.h").is_file() and (root / "pyproject.toml").is_file()


def locate(path: Path | str | None = None) -> Path:
    """Return the folder that is meant: the given one, else that of the environment, else the submodule.

    Raises:
        CheckoutError: If none of them says where a checkout is.
    """
    if path is not None:
        return _folder(path)
    if named := os.environ.get(VARIABLE):
        return _folder(named)
    if project := project_root():
        return project / SUBMODULE
    raise CheckoutError(
        f"no firmware checkout is known: run `git clone --recurse-submodules {UPSTREAM}` and name the folder "
        f"with --path or {VARIABLE}"
    )


def _folder(path: Path | str) -> Path:
    """Return the one name of a folder, so that a build finds what it made under another one."""
    return Path(path).expanduser().resolve()


def open_checkout(path: Path | str | None = None) -> Checkout:
    """Return the checkout at a path (see `locate`), checked for what a build needs.

    Raises:
        CheckoutError: If it is missing, incomplete, older than what is supported, or something else.
    """
    root = locate(path)
    if not root.is_dir():
        raise CheckoutError(f"no firmware checkout at {root}: there is no such folder")
    if not any(root.iterdir()):
        raise CheckoutError(_empty(root))
    if not (root / "src").is_dir() or not (root / SETUP).is_file():
        missing = SETUP if (root / "src").is_dir() else "src/"
        raise CheckoutError(
            f"{root} is not a checkout of the Crazyflie firmware, it has no {missing}: name the top folder of a clone "
            f"of {UPSTREAM} with --path or {VARIABLE}"
        )
    if not (root / MODULES / "controller").is_dir():
        quoted = shlex.quote(str(root))
        raise CheckoutError(
            f"the firmware in {root} is too old, it has no {MODULES}/controller/; supported are {SUPPORTED}: run "
            f"`git -C {quoted} fetch --tags && git -C {quoted} checkout {PINNED}`"
        )
    if not (root / CMSIS_HEADER).is_file():
        raise CheckoutError(
            f"the firmware in {root} lacks its submodule {CMSIS}: run "
            f"`git -C {shlex.quote(str(root))} submodule update --init {CMSIS}`"
        )
    return Checkout(root)


def _empty(root: Path) -> str:
    """Return the sentence for an empty folder; that of a submodule can be filled."""
    if root.parent == project_root() and root.name == SUBMODULE:
        return f"the submodule {SUBMODULE}/ is empty: run `git submodule update --init {SUBMODULE}` in {root.parent}"
    return f"{root} is empty: run `git clone --recurse-submodules {UPSTREAM} {shlex.quote(str(root))}`"


def describe(folder: Path) -> str | None:
    """Return tag, distance, commit and dirtiness of the repository whose top is this folder, or None.

    A folder within another repository has no version of its own. Git may neither write (`git describe --dirty`
    refreshes the index) nor start a program that the repository names.
    """
    if not (folder / ".git").exists():
        return None
    questions = (
        ("describe", "--tags", "--always"),
        ("status", "--porcelain", "--untracked-files=no", "--ignore-submodules=all"),
    )
    asked: list[subprocess.Popen[str]] = []
    try:
        environment = _git_environment(folder)
        # both at once: the second one looks at every file
        for question in questions:
            asked.append(_ask_git(folder, environment, *question))
        told = [(process.communicate(timeout=30)[0].strip(), process.returncode) for process in asked]
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return None
    finally:
        for process in asked:
            _end(process)
    (version, described), (changes, compared) = told
    if described != 0 or compared != 0 or not version:
        return None
    return f"{version}-dirty" if changes else version


def _git_environment(folder: Path) -> dict[str, str]:
    """Return an environment in which git looks at this folder alone, and runs no filter that a repository names."""
    environment = {
        **os.environ,
        "GIT_CEILING_DIRECTORIES": str(folder.parent),
        "GIT_ALLOW_PROTOCOL": "",  # an object that is missing stays missing
        "LC_ALL": "C",
    }
    for inherited in ("GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE"):
        environment.pop(inherited, None)
    process = _ask_git(folder, environment, "config", "--null", "--name-only", "--get-regexp", r"^filter\.")
    try:
        names = process.communicate(timeout=30)[0].split("\0")
    finally:
        _end(process)
    drivers = sorted({name.rpartition(".")[0] for name in names if name})
    settings = [
        (f"{driver}.{key}", value)
        for driver in drivers
        for key, value in (("clean", ""), ("process", ""), ("required", "false"))
    ]
    # behind what the user has there already
    first = int(environment.get("GIT_CONFIG_COUNT") or 0)
    environment["GIT_CONFIG_COUNT"] = str(first + len(settings))
    for i, (name, value) in enumerate(settings, first):
        environment |= {f"GIT_CONFIG_KEY_{i}": name, f"GIT_CONFIG_VALUE_{i}": value}
    return environment


def _ask_git(folder: Path, environment: dict[str, str], *question: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        ["git", "--no-optional-locks", "-c", "core.fsmonitor=false", "-C", str(folder), *question],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        errors="replace",
        env=environment,
    )


def _end(process: subprocess.Popen[str]) -> None:
    """Leave neither a process nor a pipe behind, whatever happened."""
    if process.poll() is None:
        process.kill()
    process.wait()
    if process.stdout is not None:
        process.stdout.close()
