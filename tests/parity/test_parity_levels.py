"""The modules around the algorithms: flown by both sides, and a verdict on each."""

import pytest
from miniature import lay_out

from crazychoir_fw.firmware.build import build_provider
from crazychoir_fw.firmware.levels import LEVEL_OF_MODULE, MODULES, STABILIZER
from crazychoir_fw.onboard.core import load_library
from crazychoir_fw.parity.deviation import Verdict
from crazychoir_fw.parity.fleet import FLEET, MODULE_FLIGHTS
from crazychoir_fw.parity.flights import compare_flights
from crazychoir_fw.parity.run import run_parity
from crazychoir_fw.parity.side import Side

SECONDS = 6.0


@pytest.fixture(scope="module")
def side(lasting_cache, miniature):
    """Return a function that makes the side of a level."""
    return lambda level: Side(load_library(build_provider(miniature, "cf2", level=level)))


def test_every_module_decides_a_flight():
    assert {name for member in FLEET for name in member.modules} == set(LEVEL_OF_MODULE)


def test_the_modules_of_the_miniature_fly_like_builtin(side):
    flights = compare_flights(Side(), side(MODULES), SECONDS, fleet=MODULE_FLIGHTS)
    assert {flight.name: flight.verdict for flight in flights if flight.verdict is Verdict.DIFFERENT} == {}
    assert not any(flight.failures for flight in flights)
    # one loop, and the same decisions: only MuJoCo's solver may differ, which solves fallen drones together
    for flight in flights:
        moved = [row.signal for row in flight.deviations if row.signal.startswith("true.") and row.max_absolute > 1e-9]
        assert not moved, flight.name


def test_a_loop_of_its_own_is_within_the_tolerance_of_loops(side):
    candidate = side(STABILIZER)
    assert candidate.has_own_loop
    flights = compare_flights(Side(), candidate, SECONDS, fleet=MODULE_FLIGHTS)
    assert {flight.name: flight.verdict for flight in flights if flight.verdict is Verdict.DIFFERENT} == {}
    # and it is another loop, which the comparison sees
    assert any(row.deviating for flight in flights for row in flight.deviations if row.signal.startswith("true."))


def edited(folder, path, old, new):
    """Lay a checkout out in which a line of one file is another."""
    checkout = lay_out(folder)
    text = (checkout / path).read_text()
    assert old in text
    (checkout / path).write_text(text.replace(old, new))
    return checkout


def test_a_test_that_is_never_made_is_found(lasting_cache, tmp_path):
    checkout = edited(tmp_path / "edited", "src/modules/src/health.c", "!supervisorIsFlying()", "supervisorIsFlying()")
    candidate = Side(load_library(build_provider(checkout, "cf2", level=STABILIZER)))
    fleet = [member for member in MODULE_FLIGHTS if "health" in member.modules]
    (flight,) = compare_flights(Side(), candidate, SECONDS, fleet=fleet)
    worst = {row.signal for row in flight.deviations if row.verdict is Verdict.DIFFERENT}
    assert worst == {"outcome of health.motorTestCount", "outcome of health.motorPass"}


def test_an_edited_supervisor_is_found(lasting_cache, tmp_path, short_inputs):
    limit = "COMMANDER_WDT_TIMEOUT_SHUTDOWN"
    checkout = edited(tmp_path / "edited", "src/modules/src/supervisor.c", f"> {limit}", f"> 5 * {limit}")
    candidate = Side(load_library(build_provider(checkout, "cf2", level=MODULES)))
    fleet = [member for member in MODULE_FLIGHTS if member.name in ("forgotten", "switched")]
    algorithms = Side(load_library(build_provider(checkout, "cf2")))
    parity = run_parity(Side(), candidate, SECONDS, inputs=short_inputs, fleet=fleet, algorithms=algorithms)
    verdicts = parity.modules()
    assert verdicts["supervisor"] is Verdict.DIFFERENT
    assert verdicts["controller_table"] is not Verdict.DIFFERENT
    assert parity.as_json()["modules"]["supervisor"] == "different"
    assert parity.functions_of == "bitcraze"
