"""What tests of builds share: an empty cache, and a tree that tells whether it was written to."""

import hashlib

import pytest


@pytest.fixture
def cache_folder(tmp_path, monkeypatch):
    """An empty cache for one test."""
    folder = tmp_path / "the cache"
    monkeypatch.setenv("CRAZYCHOIR_CACHE", str(folder))
    return folder


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
