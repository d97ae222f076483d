"""The order of a build, with a recipe made by hand; test_bitcraze_build.py has that of a checkout."""

import multiprocessing
import os
import subprocess

import pytest

from crazychoir_fw.common.errors import BuildError, CompileError, LinkError, UnknownNameError
from crazychoir_fw.firmware.build import build, build_provider
from crazychoir_fw.firmware.checkout import Checkout
from crazychoir_fw.firmware.library import Library
from crazychoir_fw.firmware.recipe import Recipe

TEXTS = {
    "checkout/planner.c": '#include "planner.h"\nstatic int calls; int planner(void) { return calls++ + SPEED; }',
    "checkout/planner.h": "#define SPEED 1\n",
    "checkout/vehicle.c": """
        int vehicle(void) { return 2; }
        #ifdef CRAZYFLIE_FW
        int on_vehicle(void) { return 1; }
        #endif
        """,
    "checkout/extra.c": "int extra(void) { return 3; }",
    "ours/adapter.c": """
        #include "planner.h"
        int planner(void); int vehicle(void); int on_vehicle(void); int extra(void);
        __attribute__((visibility("default"))) int sum(void) {
          int total = planner() + vehicle();
        #ifdef CF_WITH_EXTRA
          total += extra();
        #endif
        #ifdef CF_VEHICLE_MODE_VEHICLE
          total += on_vehicle();
        #endif
          return HAVE_SPEED ? total : -total;
        }""",
    "ours/own.c": "int own(void) { return 4; }",
    "ours/HAVE_SPEED.c": '#include "planner.h"\nint speed = SPEED;',
    "ours/HAVE_LEE.c": '#include "planner.h"\nint lee = LEE;',
    "app/law.c": "int law(void) { return 5; }",
}


@pytest.fixture
def place(tmp_path):
    for name, text in TEXTS.items():
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    return tmp_path


@pytest.fixture
def recipe(place, cache_folder):
    def make(**changes):
        root, ours = place / "checkout", place / "ours"
        parts = {
            "name": "toy",
            "platform": "cf2",
            "checkout": Checkout(root),
            "sources": (root / "planner.c", root / "vehicle.c"),
            "extras": (root / "extra.c",),
            "vehicle_mode": frozenset([root / "vehicle.c"]),
            "adapter": (ours / "adapter.c",),
            "own": (ours / "own.c",),
            "apps": (place / "app" / "law.c",),
            "probes": (ours / "HAVE_SPEED.c", ours / "HAVE_LEE.c"),
            "first_include_dirs": (ours,),
            "include_dirs": (root,),
            "flags": ("-O1", "-g", "-gdwarf-4", "-fPIC", "-fvisibility=hidden"),
            "app_flags": ("-Wall",),
            "own_include_dirs": (ours,),
            "generated": {"autoconf.h": "#define CONFIG_A 1\n", "forced.h": '#include "autoconf.h"\n'},
            "settings": {"CONFIG_A": "1"},
            "notes": (),
        }
        return Recipe(**{**parts, **changes})

    return make


@pytest.fixture
def compiled(monkeypatch):
    """Names of the sources that were compiled since this was asked the last time."""
    from crazychoir_fw.firmware.objects import Objects

    names = []
    compile_one = Objects._compile

    def watch(self, unit, key):
        names.append(unit.source.name)
        return compile_one(self, unit, key)

    monkeypatch.setattr(Objects, "_compile", watch)

    def ask():
        asked = sorted(names)
        names.clear()
        return asked

    return ask


def test_a_library_says_what_it_is(recipe, cache_folder):
    library = build(recipe())
    assert library.path.is_relative_to(cache_folder)
    assert (library.name, library.platform) == ("toy", "cf2")
    assert any(size >= 4 for _, size in library.ranges)
    identity = library.identity
    assert identity["features"] == ["speed"]
    assert identity["missing_features"] == ["lee"]
    assert identity["extra_sources"] == ["extra.c"]
    assert identity["host_mode"] == ["planner.c", "extra.c"]
    assert identity["version"] == identity["content"]
    assert identity["sources"] == 4
    assert identity["notes"] == []
    assert Library.load(library.path.parent) == library
    log = (library.path.parent / "build.log").read_text()
    assert "CONFIG_A = 1" in log
    assert "-DCF_WITH_EXTRA" in log


def test_the_second_time_comes_from_the_cache(recipe, compiled):
    first = build(recipe())
    assert len(compiled()) == 8
    assert build(recipe()) == first
    assert compiled() == []


def test_a_commit_changes_the_version_and_compiles_nothing(recipe, place, compiled):
    def git(*words):
        who = ["-c", "user.name=somebody", "-c", "user.email=somebody@example.com", "-c", "commit.gpgsign=false"]
        subprocess.run(["git", *who, "-C", str(place / "checkout"), *words], check=True, capture_output=True)

    git("init")
    git("add", ".")
    git("commit", "-m", "one")
    git("tag", "v1")
    assert build(recipe()).identity["version"] == "v1"
    (place / "checkout" / "extra.c").write_text("int extra(void) { return 33; }")
    assert build(recipe()).identity["version"] == "v1-dirty"
    compiled()
    git("commit", "-am", "two")
    git("tag", "v2")
    assert build(recipe()).identity["version"] == "v2"
    assert compiled() == []


def test_an_edit_compiles_one_file_and_gives_a_new_library(recipe, place, compiled):
    first = build(recipe())
    compiled()
    (place / "checkout" / "extra.c").write_text("int extra(void) { return 33; }")
    second = build(recipe())
    assert compiled() == ["extra.c"]
    assert second.path != first.path
    assert second.identity["content"] != first.identity["content"]
    assert first.path.is_file()
    # and back: the library of before
    (place / "checkout" / "extra.c").write_text(TEXTS["checkout/extra.c"])
    assert build(recipe()) == first
    assert compiled() == []


def test_force_compiles_everything(recipe, compiled):
    first = build(recipe())
    compiled()
    assert build(recipe(), force=True).path != first.path
    assert len(compiled()) == 8


def test_a_library_that_vanished_is_linked_again(recipe, compiled):
    build(recipe()).path.unlink()
    compiled()
    assert build(recipe()).path.is_file()
    assert compiled() == []


def test_a_new_header_that_hides_another_one_counts(recipe, place):
    first = build(recipe())
    (place / "ours" / "planner.h").write_text("#define SPEED 7\n")
    assert build(recipe()).path != first.path


def test_an_extra_that_does_not_compile_is_left_out(recipe, place):
    (place / "checkout" / "extra.c").write_text("#error not today")
    library = build(recipe())
    assert library.identity["extra_sources"] == []
    assert library.identity["notes"] == ["extra.c does not compile, left out"]


def test_an_extra_that_needs_more_is_left_out(recipe, place):
    (place / "checkout" / "extra.c").write_text("int missing(void); int extra(void) { return missing(); }")
    library = build(recipe())
    assert library.identity["notes"] == ["extra.c left out, it needs missing"]


@pytest.mark.parametrize("trouble", ["#error", "int missing(void); int more(void) { return missing(); }"])
def test_vehicle_mode_is_given_up_when_it_does_not_work(recipe, place, trouble):
    path = place / "checkout" / "vehicle.c"
    path.write_text(path.read_text() + f"\n#ifdef CRAZYFLIE_FW\n{trouble}\n#endif\n")
    library = build(recipe())
    assert "vehicle.c" in library.identity["host_mode"]
    assert len(library.identity["notes"]) == 1
    assert library.identity["notes"][0].startswith("vehicle.c ")


def test_an_extra_in_vehicle_mode_is_first_taken_as_for_the_host(recipe, place):
    extra = place / "checkout" / "extra.c"
    extra.write_text("int missing(void);\n#ifdef CRAZYFLIE_FW\nint extra(void) { return missing(); }\n#else\n"
                     "int extra(void) { return 0; }\n#endif\n")  # fmt: skip
    library = build(recipe(vehicle_mode=frozenset([extra])))
    assert library.identity["extra_sources"] == ["extra.c"]
    assert library.identity["host_mode"] == ["planner.c", "vehicle.c", "extra.c"]


def test_sources_that_do_not_compile(recipe, place):
    (place / "checkout" / "planner.c").write_text("int planner(void) { return }\n")
    (place / "checkout" / "vehicle.c").write_text("int vehicle(void) { return 1; \n")
    with pytest.raises(CompileError) as raised:
        build(recipe())
    assert str(raised.value).startswith("2 files do not compile:\n")
    assert f"{place}/checkout/planner.c:1:28: error:" in str(raised.value)
    assert f"{place}/checkout/vehicle.c:" in str(raised.value)


def test_an_app_that_does_not_compile(recipe, place):
    (place / "app" / "law.c").write_text("\n\nint law(void) { return undeclared; }\n")
    with pytest.raises(CompileError, match=r"app/law\.c:3:24: error"):
        build(recipe())


def test_undefined_symbols_of_what_is_needed(recipe, place, cache_folder):
    (place / "app" / "law.c").write_text("int missing(void); int law(void) { return missing(); }")
    with pytest.raises(LinkError, match=f"^undefined symbol missing, needed by {place}/app/law.c$"):
        build(recipe())
    assert list((cache_folder / "provider-libraries" / "libraries").iterdir()) == []


def test_warnings_of_an_app_are_told(recipe, place):
    (place / "app" / "law.c").write_text("int law(void) { int unused; return 5; }\n")
    assert "unused variable" in build(recipe()).identity["warnings"]
    assert "unused variable" in build(recipe()).identity["warnings"]


def test_progress_ends_with_everything_done(recipe):
    told = []
    build(recipe(), progress=lambda *state: told.append(state))
    assert {what for what, _, _ in told} == {"asking", "compiling", "linking"}
    assert told[-1] == ("linking", 1, 1)
    assert all(done <= total for _, done, total in told)


def _build_in_process(made, barrier, answers):
    barrier.wait()
    answers.put(str(build(made).path))


def test_two_processes_at_once_build_it_once(recipe):
    context = multiprocessing.get_context("fork")
    barrier, answers = context.Barrier(2), context.Queue()
    workers = [context.Process(target=_build_in_process, args=(recipe(), barrier, answers)) for _ in range(2)]
    for worker in workers:
        worker.start()
    paths = {answers.get(timeout=60) for _ in workers}
    for worker in workers:
        worker.join()
    assert len(paths) == 1
    assert build(recipe()).path == next(iter(map(type(recipe().apps[0]), paths)))


def test_a_header_that_changes_during_the_build_is_not_kept(recipe, place, compiled):
    header = place / "checkout" / "planner.h"

    def edit(what, done, total):
        if (what, done) == ("linking", 0):
            header.write_text("#define SPEED 2\n")

    build(recipe(), progress=edit)
    compiled()
    build(recipe())
    assert "planner.c" in compiled()
    build(recipe())
    assert compiled() == []


def test_a_build_without_anything_to_build(cache_folder):
    with pytest.raises(BuildError, match="nothing to build"):
        build_provider(None)


def test_a_missing_app(cache_folder, tmp_path):
    with pytest.raises(UnknownNameError, match="there is no app file"):
        build_provider(None, apps=[tmp_path / "none.c"])


def test_a_damaged_manifest_is_built_again(recipe):
    library = build(recipe())
    (library.path.parent / "library.json").write_text("{")
    with pytest.raises(BuildError, match="build it again with --force"):
        Library.load(library.path.parent)
    assert Library.load(build(recipe()).path.parent)


def test_spaces_and_signs_in_every_path(recipe, place, cache_folder):
    odd = place.with_name("a b ü $x #y")
    os.rename(place, odd)  # noqa: PTH104
    moved = {
        name: tuple(odd / path.relative_to(place) for path in value)
        for name, value in vars(recipe()).items()
        if name in ("sources", "extras", "adapter", "own", "apps", "probes", "include_dirs", "own_include_dirs")
    }
    library = build(recipe(**moved, checkout=Checkout(odd / "checkout"), vehicle_mode=frozenset()))
    assert library.identity["features"] == ["speed"]
