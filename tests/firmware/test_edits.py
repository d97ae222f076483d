"""The table "edit this file, see it fly", and edits that cannot fly."""

import re
from dataclasses import replace

import pytest
from edits import EDITS, Edit, height
from level_flights import airborne, world_of

from crazychoir_fw.common.errors import CheckoutError, CompileError, LinkError, MissionError, UnknownNameError
from crazychoir_fw.firmware.build import build_provider
from crazychoir_fw.firmware.levels import ALGORITHMS, ALL, LEVELS, MODULES, STABILIZER, modules_of
from crazychoir_fw.firmware.library import BUILD_LOG
from crazychoir_fw.firmware.providers import load
from crazychoir_fw.mission import parse_mission
from crazychoir_fw.onboard.core import load_library

MODULES_FOLDER = "src/modules/src"


def edit(checkout, file, text, by):
    """Replace a text of a file, which must be there."""
    path = checkout / MODULES_FOLDER / file
    before = path.read_text()
    assert text in before
    path.write_text(before.replace(text, by, 1))
    return path


def loaded(library, name):
    load_library(replace(library, name=name))
    return name


@pytest.fixture(scope="session")
def unedited(level_word):
    """Return what is measured in a flight of the unedited checkout, each flown once."""
    known = {}

    def measure(one: Edit):
        key = (one.observe, one.level, repr(one.settings))
        if key not in known:
            known[key] = one.observe(world_of(level_word("2026.08", one.level), **one.settings))
        return known[key]

    return measure


@pytest.mark.parametrize("one", EDITS, ids=lambda one: one.file)
def test_an_edited_file_flies(one, edited, unedited):
    edit(edited, one.file, one.text, one.by)
    library = build_provider(edited, level=one.level)
    assert library.identity["notes"] == []
    before = unedited(one)
    after = one.observe(world_of(loaded(library, f"edited-{one.file}"), **one.settings))
    assert one.effect(before, after), f"{one.file}: {before} before, {after} after"


def test_every_module_that_can_be_edited_is_in_the_table():
    files = {one.file.rpartition("/")[2] for one in EDITS}
    assert len(EDITS) == len(files) >= 22
    assert {one.level for one in EDITS} == set(LEVELS)


def test_an_edit_compiles_one_file(edited):
    build_provider(edited, level=MODULES)
    path = edit(edited, "supervisor.c", "M2T(2000)", "M2T(2001)")
    library = build_provider(edited, level=MODULES)
    commands = (library.path.parent / BUILD_LOG).read_text().partition("\ncommands:\n")[2].splitlines()
    assert [line.split()[-1] for line in commands if line.startswith("  ")] == [str(path)]


# -- what cannot fly -----------------------------------------------------------------------------------------------


def test_an_edit_that_does_not_compile_is_told_with_its_line_and_changes_nothing_else(edited):
    before = build_provider(edited, level=MODULES)
    path = edit(edited, "supervisor.c", "  return supervisorMem.canFly;", "  return supervisorMem.canFlyy;")
    line = path.read_text().splitlines().index("  return supervisorMem.canFlyy;") + 1
    with pytest.raises(CompileError) as caught:
        build_provider(edited, level=MODULES)
    assert str(caught.value).startswith("1 file does not compile:")
    assert f"{path}:{line}:" in str(caught.value)
    assert "canFlyy" in str(caught.value)
    edit(edited, "supervisor.c", "canFlyy", "canFly")
    assert build_provider(edited, level=MODULES).path == before.path


def test_all_flies_what_compiles_and_tells_what_does_not(edited):
    path = edit(edited, "stabilizer.c", "static bool isInit;", "static bool isInit = nonsense;")
    library = build_provider(edited, level=ALL)
    assert library.identity["level"] == MODULES
    (note,) = library.identity["notes"]
    line = path.read_text().splitlines().index("static bool isInit = nonsense;") + 1
    assert note.startswith("level stabilizer left out: ")
    assert f"{path}:{line}:" in note
    assert "nonsense" in note
    assert height(world_of(loaded(library, "what-compiles"))) == pytest.approx(0.5, abs=0.05)


def test_all_flies_the_algorithms_where_no_module_compiles(edited):
    edit(edited, "commander.c", "static bool             isInit;", "static bool isInit = nonsense;")
    library = build_provider(edited, level=ALL)
    assert library.identity["level"] == ALGORITHMS
    assert [note.partition(":")[0] for note in library.identity["notes"]] == [
        "level stabilizer left out",
        "level modules left out",
    ]
    assert height(world_of(loaded(library, "only-algorithms"))) == pytest.approx(0.5, abs=0.05)


def test_all_of_a_whole_checkout_is_its_loop(edited):
    library = build_provider(edited, level=ALL)
    assert library.identity["level"] == STABILIZER
    assert library.identity["modules"] == modules_of(STABILIZER)
    assert library.identity["notes"] == []


def test_words_of_another_language_are_names_in_c(edited):
    edit(
        edited,
        "supervisor.c",
        "bool supervisorCanFly(void) {\n  return supervisorMem.canFly;",
        "bool supervisorCanFly(void) {\n  const bool new = supervisorMem.canFly, class = new;\n  return class;",
    )
    library = build_provider(edited, level=MODULES)
    assert height(world_of(loaded(library, "keywords"))) == pytest.approx(0.5, abs=0.05)


def test_a_missing_symbol_is_told_with_the_file_that_needs_it(edited):
    path = edit(
        edited,
        "supervisor.c",
        "bool supervisorCanFly(void) {",
        "bool mayIFly(void);\nbool supervisorCanFly(void) {\n  if (!mayIFly()) {\n    return false;\n  }",
    )
    with pytest.raises(LinkError, match=rf"undefined symbol mayIFly, needed by .*{path.name}"):
        build_provider(edited, level=MODULES)
    library = build_provider(edited, level=ALL)
    assert library.identity["level"] == ALGORITHMS
    assert "mayIFly" in library.identity["notes"][0]


def test_a_missing_file_of_a_level_is_named(edited):
    (edited / MODULES_FOLDER / "commander.c").unlink()
    with pytest.raises(CheckoutError, match=r"has no src/modules/src/commander\.c, which level modules needs"):
        build_provider(edited, level=MODULES)


def test_a_missing_submodule_gives_the_command_at_every_level(edited):
    for path in (edited / "vendor" / "CMSIS").rglob("*.[ch]"):
        path.unlink()
    for level in (MODULES, STABILIZER, ALL):
        with pytest.raises(
            CheckoutError, match=r"lacks its submodule vendor/CMSIS: run `git -C .* submodule update --init"
        ):
            build_provider(edited, level=level)


def test_unknown_words_are_told_which_ones_there_are():
    with pytest.raises(UnknownNameError, match=r"allowed after 'bitcraze:': .*modules.*did you mean 'modules'"):
        load("bitcraze:module", "cf2")
    with pytest.raises(UnknownNameError, match="no provider named 'bitcrase:modules'"):
        load("bitcrase:modules", "cf2")


def test_unknown_modules_of_a_mission_are_told_which_ones_there_are():
    mission = {
        "name": "wrong",
        "drones": [{"id": "cf1", "provider": {"bitcraze": {"modules": ["commanders"]}}}],
        "flight": ["land"],
    }
    with pytest.raises(
        MissionError, match=r"no module named 'commanders', allowed: commander, .*did you mean 'commander'"
    ):
        parse_mission(mission)


# -- failures in flight --------------------------------------------------------------------------------------------


FAILURES = {
    "an assertion": ("  ASSERT(supervisorMem.canFly < 0);\n", r"supervisor\.c:\d+"),
    "a null pointer": ("  *(volatile int *)0 = 1;\n", "supervisorUpdate|the firmware's tasks"),
}


@pytest.mark.parametrize("what", FAILURES)
def test_a_failure_in_an_edited_module_stops_its_own_drone(what, edited):
    line, said = FAILURES[what]
    place = "  SupervisorMem_t *this        = &supervisorMem;\n  const uint32_t   currentTick = xTaskGetTickCount();\n"
    edit(edited, "supervisor.c", place, f"{place}  if (tumbleCheckEnabled == 7) {{\n{line}  }}\n")
    edit(edited, "supervisor.c", "static bool            tumbleCheckEnabled", "static uint8_t tumbleCheckEnabled")
    edit(edited, "supervisor.c", '#include "debug.h"', '#include "cfassert.h"\n#include "debug.h"')
    word = loaded(build_provider(edited, level=STABILIZER), f"failing-{what}")
    world = airborne(word, word, "builtin")
    bad, good, ours = world.drones
    bad.param["supervisor.tmblChckEn"] = 7
    world.run(1.0)
    assert re.search(said, bad.failure), bad.failure
    assert list(bad.struct.onboard.motors.list) == [0, 0, 0, 0]
    assert bad.true_position[2] < 0.1
    assert good.failure is None and ours.failure is None
    assert good.true_position[2] == pytest.approx(0.5, abs=0.05)
    assert ours.true_position[2] == pytest.approx(0.5, abs=0.05)
