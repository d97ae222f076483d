"""A revision of a firmware repository as files of their own: nothing is written into the user's tree."""

from __future__ import annotations

import io
import subprocess
import tarfile
from pathlib import Path

from crazychoir_fw.campaign.bundle import private_folder
from crazychoir_fw.common.errors import StateError


def checkout_at(repository: Path, revision: str) -> Path:
    """Return a folder with the files of a revision, submodules included; made once per commit.

    Args:
        repository: The user's checkout.
        revision: Anything that git takes for a commit.

    Raises:
        StateError: If there is no such repository, revision or submodule.
    """
    commit = _git(repository, "rev-parse", "--verify", "--end-of-options", f"{revision}^{{commit}}").decode().strip()
    folder = private_folder("revisions") / commit
    if not folder.is_dir():
        temporary = folder.with_name(f".{commit}.part")
        _extract(repository, commit, temporary)
        temporary.rename(folder)
    return folder


def _extract(repository: Path, commit: str, into: Path) -> None:
    """Write the files of a commit, then those of the submodules that it names."""
    into.mkdir(parents=True, exist_ok=True)
    with tarfile.open(fileobj=io.BytesIO(_git(repository, "archive", "--format=tar", commit))) as archive:
        archive.extractall(into, filter="data")
    for line in _git(repository, "ls-tree", "-r", commit).decode().splitlines():
        about, _, path = line.partition("\t")
        mode, _, inner = about.split()
        if mode == "160000" and (repository / path / ".git").exists():
            _extract(repository / path, inner, into / path)


def _git(repository: Path, *words: str) -> bytes:
    try:
        return subprocess.run(["git", "-C", str(repository), *words], capture_output=True, check=True).stdout
    except FileNotFoundError:
        raise StateError("revisions need git, which is not installed") from None
    except subprocess.CalledProcessError as error:
        reason = error.stderr.decode(errors="replace").strip().splitlines()
        raise StateError(f"{repository}: git {words[0]}: {reason[-1] if reason else 'failed'}") from None
