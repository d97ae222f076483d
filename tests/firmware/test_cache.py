import os
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import BuildError
from crazychoir_fw.firmware.cache import Cache, Fingerprints, cache_root, clean, digest
from crazychoir_fw.firmware.library import Library


def test_remembers_by_content(cache_folder, tmp_path):
    cache = Cache()
    source = tmp_path / "a.c"
    source.write_text("one")
    cache.remember("key", Fingerprints().all_of([str(source)]), {"answer": 1})
    source.write_text("two")
    assert cache.recall("key", Fingerprints()) is None
    cache.remember("key", Fingerprints().all_of([str(source)]), {"answer": 2})
    assert cache.recall("key", Fingerprints()) == {"answer": 2}
    source.write_text("one")
    assert cache.recall("key", Fingerprints()) == {"answer": 1}
    source.unlink()
    assert cache.recall("key", Fingerprints()) is None


def test_remembers_what_was_missing(cache_folder, tmp_path):
    cache = Cache()
    absent = tmp_path / "absent.h"
    cache.remember("key", Fingerprints().all_of([str(absent)]), {})
    assert cache.recall("key", Fingerprints()) == {}
    absent.write_text("")
    assert cache.recall("key", Fingerprints()) is None


def test_a_damaged_record_is_forgotten(cache_folder):
    cache = Cache()
    cache.remember("key", {}, {"answer": 1})
    (record,) = (cache.root / "records").glob("*.json")
    for damage in ('[{"inputs"', '{"a": 1}', '[{"inputs": 3, "value": {}}]', "[null]", ""):
        record.write_text(damage)
        assert cache.recall("key", Fingerprints()) is None


def test_files_written_during_the_build_are_noticed(tmp_path):
    source = tmp_path / "a.c"
    source.write_text("one")
    os.utime(source, ns=(10**18, 10**18))
    fingerprints = Fingerprints()
    assert not fingerprints.changed_meanwhile([str(source)])
    source.write_text("two")
    assert fingerprints.changed_meanwhile([str(source)])
    # a clock that is wrong must not make the cache useless
    os.utime(source, ns=(10**19 // 2, 10**19 // 2))
    assert not fingerprints.changed_meanwhile([str(source)])
    source.unlink()
    assert fingerprints.changed_meanwhile([str(source)])


def test_one_key_is_held_by_one_at_a_time(cache_folder):
    entered, order = threading.Event(), []

    def second():
        entered.wait()
        with Cache().alone("key"):
            order.append("second")

    thread = threading.Thread(target=second)
    thread.start()
    with Cache().alone("key"):
        entered.set()
        thread.join(0.05)
        order.append("first")
    thread.join()
    assert order == ["first", "second"]


def test_clean_deletes_only_what_is_ours(cache_folder):
    assert clean() == 0
    neighbor = cache_folder / "thesis.tex"
    Cache().remember("key", {}, {})
    neighbor.write_text("years of work")
    assert clean() > 0
    assert sorted(cache_folder.iterdir()) == [neighbor]


def test_clean_refuses_a_folder_without_the_mark(cache_folder):
    cache_root().mkdir(parents=True)
    (cache_root() / "thesis.tex").write_text("years of work")
    with pytest.raises(BuildError, match="is not a cache of crazychoir: nothing was deleted"):
        clean()
    assert (cache_root() / "thesis.tex").exists()


def test_a_cache_that_cannot_be_written_says_so(cache_folder):
    cache_folder.write_text("a file is in the way")
    with pytest.raises(BuildError, match="cannot be written .*CRAZYCHOIR_CACHE"):
        Cache()


def test_prune_keeps_what_was_used_last(cache_folder, monkeypatch):
    monkeypatch.setattr("crazychoir_fw.firmware.cache._KEPT_OBJECTS", 2)
    cache = Cache()
    for i, name in enumerate(["old.o", "older.o", "new.o", "fresh.o"]):
        (cache.objects / name).write_text("")
        if name != "fresh.o":
            os.utime(cache.objects / name, ((1000, 10, 2000)[i],) * 2)
    cache.prune()
    assert {path.name for path in cache.objects.iterdir()} == {"new.o", "fresh.o"}


@pytest.mark.parametrize("folder", ["libraries", "modules"])
def test_prune_deletes_whole_folders(cache_folder, monkeypatch, folder):
    monkeypatch.setattr("crazychoir_fw.firmware.cache._KEPT_LIBRARIES", 1)
    cache = Cache()
    for i, name in enumerate(["old", "new"]):
        made = cache.root / folder / name
        made.mkdir()
        (made / "a.so").write_text("")
        os.utime(made, (1000 + i,) * 2)
    cache.prune()
    assert [path.name for path in (cache.root / folder).iterdir()] == ["new"]


def test_a_workspace_is_gone_unless_it_was_renamed(cache_folder):
    cache = Cache()
    with pytest.raises(ValueError), cache.workspace(cache.libraries) as folder:
        (folder / "half").write_text("")
        raise ValueError
    assert list(cache.libraries.iterdir()) == []
    with cache.workspace(cache.libraries) as folder:
        folder.replace(cache.libraries / "whole")
    assert [path.name for path in cache.libraries.iterdir()] == ["whole"]


@given(st.lists(st.binary(max_size=4), max_size=4), st.lists(st.binary(max_size=4), max_size=4))
def test_a_digest_tells_parts_apart(first, second):
    assert (digest(*first) == digest(*second)) == (first == second)


def test_the_cache_is_private(cache_folder):
    root = cache_root()
    root.mkdir(parents=True)
    root.chmod(0o755)  # as it was made by an older version
    cache = Cache()
    for folder in (root, cache.libraries, cache.modules, cache.objects):
        assert folder.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("name", [".", "libraries", "modules"])
def test_a_cache_into_which_others_may_write_is_refused(cache_folder, name):
    Cache()
    (cache_root() / name).chmod(0o777)
    with pytest.raises(BuildError, match=r"may be written by others \(mode 777\).*delete it, or name another with"):
        Cache()


def test_a_cache_of_another_user_is_refused(cache_folder, monkeypatch):
    Cache()
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    with pytest.raises(BuildError, match=f"belongs to user {os.getuid()}"):
        Cache()


def test_a_library_that_is_not_the_one_that_was_built_is_not_loaded(cache_folder):
    folder = Cache().libraries / "mine"
    folder.mkdir()
    (folder / "mine.so").write_bytes(b"built")
    Library(folder / "mine.so", "mine", None, [(0, 1)], [], {"content": "1"}).save()
    assert Library.load(folder).name == "mine"
    (folder / "mine.so").write_bytes(b"other")
    with pytest.raises(BuildError, match=r"mine\.so is not the file that was built"):
        Library.load(folder)
