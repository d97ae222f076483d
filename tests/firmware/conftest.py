"""What tests of builds share: caches, a checkout, and a tree that tells whether it was written to."""

import fcntl
import hashlib
from pathlib import Path

import pytest
from miniature import lay_out

from crazychoir_fw.firmware.build import build_provider


@pytest.fixture
def cache_folder(tmp_path, monkeypatch):
    """An empty cache for one test."""
    folder = tmp_path / "the cache"
    monkeypatch.setenv("CRAZYCHOIR_CACHE", str(folder))
    return folder


@pytest.fixture(scope="session")
def lasting_folder(request):
    """A folder that outlives the session, for what is named by its content."""
    return request.config.cache.mkdir("firmware")


@pytest.fixture(scope="session")
def lasting_cache(lasting_folder):
    """A cache that outlives the session: what has not changed is not compiled again."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CRAZYCHOIR_CACHE", str(lasting_folder / "cache"))
        yield lasting_folder / "cache"


@pytest.fixture(scope="session")
def miniature(lasting_folder):
    """The miniature checkout of the newest release, a repository, laid out once. Not to be written to."""
    parts = [path for path in sorted((Path(__file__).parent / "miniature").rglob("*")) if path.is_file()]
    # some files of the miniature are made from ours
    parts += sorted((Path(__file__).parents[2] / "bindings").rglob("*.[ch]"))
    name = hashlib.sha256(b"".join(path.read_bytes() for path in parts if path.suffix != ".pyc")).hexdigest()[:12]
    root = lasting_folder / f"checkout {name}"
    with (lasting_folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (root / "laid out").exists():
            lay_out(root, git=True)
            (root / "laid out").touch()
    return root


@pytest.fixture(scope="session")
def bitcraze_library(miniature, lasting_cache):
    """The library of the miniature checkout for cf2."""
    return build_provider(miniature, "cf2")


@pytest.fixture
def photograph():
    """Return everything about a tree: names, modes, times and contents."""

    def take(root):
        return {
            str(path.relative_to(root)): (
                path.lstat().st_mode,
                path.lstat().st_mtime_ns,
                hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else "",
            )
            for path in sorted(root.rglob("*"))
        }

    return take
