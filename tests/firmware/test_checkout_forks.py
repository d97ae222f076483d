"""Modified checkouts, and the tree after the newest release: they compile, and fly like a release."""

import re

import numpy as np
import pytest
from flight_inputs import random_inputs
from miniature import FORKS, lay_out
from side_by_side import Drone, complementary_flight, control_of, filter_step, same

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.firmware import levels
from crazychoir_fw.firmware.build import build_provider
from crazychoir_fw.onboard.core import load_library

CHANGED = {**{fork: {"fork": fork} for fork in FORKS}, "after 2026.08": {"release": "after", "setup_py": "2026"}}


@pytest.fixture(scope="module")
def built(releases_folder, lasting_cache):
    """Return the library of one of them, which is built once."""
    libraries = {}

    def build(name):
        if name not in libraries:
            libraries[name] = build_provider(lay_out(releases_folder / name, **CHANGED[name]))
        return libraries[name]

    return build


@pytest.mark.parametrize("name", CHANGED)
def test_a_fork_flies_like_the_builtin_provider(built, name, rng):
    library = built(name)
    assert library.identity["notes"] == []
    assert library.identity["missing_features"] == []
    pair = Drone(0), Drone(load_library(library))
    controls = [ffi.new("control_t *") for _ in pair]
    for number in range(1, 6):
        for drone in pair:
            assert drone.controller_init(number) == lib.CF_OK
        for step in range(1, 60):
            if step % 10 == 1:
                inputs = random_inputs(rng)
            for drone, control in zip(pair, controls, strict=True):
                drone.controller(control, *inputs, step)
            assert control_of(controls[0]) == control_of(controls[1]), (number, step)
    for one, other in complementary_flight(pair, rng, 100):
        assert same(one, other)
    one, other = (filter_step(drone, 10, [], np.array([0, 0.1, 1]), np.ones(3)) for drone in pair)
    assert same(one[0], other[0])
    ours, theirs = (set(drone.variables("parameters")) for drone in pair)
    assert ours <= theirs


def test_the_edits_of_a_fork_are_there(built):
    drone = Drone(load_library(built("fork_edits")))
    assert drone.variable("parameters", "mine.gain")[0] == 1.0
    assert drone.variable("logs", "mine.calls")[0] == 0


@pytest.mark.parametrize("name", CHANGED)
def test_a_fork_compiles_up_to_its_own_loop(built, releases_folder, name):
    built(name)
    identity = build_provider(releases_folder / name, level=levels.STABILIZER).identity
    assert identity["host_mode"] == []
    assert identity["notes"] == []


def test_edits_look_as_editors_leave_them(tmp_path):
    root = lay_out(tmp_path, fork="fork_edits")
    modules, interface = root / "src/modules/src", root / "src/modules/interface"
    types = (interface / "stabilizer_types.h").read_bytes()
    assert types.count(b"\r\n") == types.count(b"\n")
    assert not (modules / "controller/controller_mine.c").read_bytes().endswith(b"\n")
    with pytest.raises(UnicodeDecodeError):
        (modules / "controller/position_controller_pid.c").read_text(encoding="utf-8")
    enumeration = (interface / "controller/controller.h").read_text()
    table = (modules / "controller/controller.c").read_text()
    assert re.findall(r"ControllerType(\w+),", enumeration)[1:5] == ["PID", "Mellinger", "Mine", "INDI"]
    rows = re.findall(r"\.init += controller(\w+)Init,", table)
    assert rows[:4] == ["Pid", "MellingerFirmware", "Mine", "INDI"]


def test_the_tables_of_a_fork_are_old(tmp_path):
    root = lay_out(tmp_path, fork="old_param")
    param = (root / "src/modules/interface/param.h").read_text()
    assert "#ifndef __PARAM_H__\n#define __PARAM_H__" in param
    assert "#include <crtp.h>" in param
    assert "static const struct param_s __params_##NAME[]" in param
    assert "PARAM_ADD_PERSISTENT(TYPE, NAME, ADDRESS, CALLBACK)" in param
    assert not list(root.rglob("param_logic.h"))
