"""Campaigns that fly: one table whatever the engine, interruptions that lose nothing, regressions that are found."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import closing
from xml.etree import ElementTree

import pytest

from crazychoir_fw.campaign.campaign import load_campaign
from crazychoir_fw.campaign.compare import compare, variants_of
from crazychoir_fw.campaign.engines import Processes, here
from crazychoir_fw.campaign.flight import CRASHED, fly_whole, record_of
from crazychoir_fw.campaign.regressions import fly_again, read_flights
from crazychoir_fw.campaign.report import write_results
from crazychoir_fw.campaign.run import run
from crazychoir_fw.campaign.search import Search, write_finding
from crazychoir_fw.campaign.sensitivity import blame
from crazychoir_fw.campaign.table import Table, hash_of, read_flight
from crazychoir_fw.common.errors import StateError

VARY = {"defaults.battery": {"uniform": [0.6, 1.0]}, "defaults.mass": {"normal": {"mean": 0.029, "std": 0.0005}}}
WEAK = {"defaults.vehicle.rotors.thrust_scale": {"uniform": [0.3, 1.0]}, "defaults.battery": {"uniform": [0.8, 1.0]}}


def silent(*arguments):
    pass


@pytest.fixture(scope="module")
def pool():
    """Two workers."""
    with Processes(2) as workers:
        yield workers


@pytest.fixture
def table_of(tmp_path):
    """Returns the hash of the table of a campaign."""
    number = iter(range(100))

    def fly(campaign, engine):
        return hash_of(run(campaign, tmp_path / f"out{next(number)}", engine).records)

    return fly


def test_the_table_is_the_same_with_one_worker_with_two_and_with_none(campaign, table_of, pool):
    whole = campaign(vary=VARY, flights=6)
    assert len({table_of(whole, engine) for engine in (here, pool, Processes(1))}) == 1


def test_a_full_disk_ends_a_campaign_with_a_sentence_and_loses_no_flight(campaign, tmp_path, table_of, monkeypatch):
    whole, begin = campaign(vary=VARY, flights=12), Table.__init__

    def cramped(table, folder):
        begin(table, folder)
        table._file.execute("PRAGMA max_page_count=5")

    with monkeypatch.context() as patched:
        patched.setattr(Table, "__init__", cramped)
        with pytest.raises(StateError, match="the disk is full; all flights that are over are kept"):
            run(whole, tmp_path / "full", here)
    with closing(Table(tmp_path / "full")) as table:
        kept = len(table.numbers())
    assert 0 < kept < 12
    again = []

    def noted(tasks):
        for record in here(tasks):
            again.append(record.number)
            yield record

    assert hash_of(run(whole, tmp_path / "full", noted).records) == table_of(whole, here)
    assert len(again) == 12 - kept


def test_workers_that_still_start_leave_ctrl_c_to_their_parent(capfd):
    workers = Processes(1)
    worker = workers._hire()
    os.kill(worker.process.pid, signal.SIGINT)  # while it imports
    workers._workers.append(worker)
    worker.process.join(timeout=0.5)
    assert worker.process.is_alive()
    workers.close()
    assert "KeyboardInterrupt" not in capfd.readouterr().err


def test_a_campaign_that_was_interrupted_goes_on(campaign, tmp_path, table_of):
    whole, flown = campaign(vary=VARY, flights=5), []

    def interrupted(tasks):
        for record in here(tasks):
            if len(flown) == 2:
                raise KeyboardInterrupt
            flown.append(record.number)
            yield record

    outcome = run(whole, tmp_path / "out", interrupted)
    assert outcome.interrupted and outcome.verdict.answer == "UNDECIDED"
    assert [record.number for record in outcome.records] == [0, 1]
    again = run(whole, tmp_path / "out", lambda tasks: here(task for task in tasks if not flown.append(task[0].number)))
    assert flown == [0, 1, 2, 3, 4]  # none twice
    assert hash_of(again.records) == table_of(whole, here)


def test_a_killed_campaign_loses_no_flight_that_was_over(campaign, tmp_path):
    campaign(vary=VARY, flights=400)
    command = [sys.executable, "-c", "from crazychoir_fw.cli import app; app()", "campaign", "campaign.yaml"]
    process = subprocess.Popen([*command, "--workers", "1", "--out", "out"], cwd=tmp_path, stdout=subprocess.DEVNULL)
    end = time.monotonic() + 60.0
    try:
        while time.monotonic() < end:
            time.sleep(0.1)
            if (tmp_path / "out" / "campaign.sqlite").exists() and (
                known := len(Table(tmp_path / "out").numbers())
            ) > 2:
                break
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    records = Table(tmp_path / "out").records()
    assert len(records) >= known > 2
    assert [record.number for record in records] == list(range(len(records)))


def test_flights_of_changed_files_are_not_mixed(campaign, hop, tmp_path):
    run(campaign(vary=VARY, flights=1), tmp_path / "out", here)
    hop.write_text(hop.read_text().replace("height: 0.5", "height: 0.6"))
    with pytest.raises(StateError, match="flights of another campaign, or of files that were changed since"):
        run(campaign(vary=VARY, flights=1), tmp_path / "out", here)


def test_a_flight_is_flown_again_with_the_same_bits(campaign, tmp_path, pool):
    run(campaign(vary=VARY, flights=3), tmp_path / "out", pool)
    record, job = read_flight(tmp_path / "out", 2)
    assert record_of(job, record.values, fly_whole(job)) == record.__class__(
        **{**vars(record), "wall_seconds": pytest.approx(record.wall_seconds, abs=60.0)}
    )


DEADLY = """
import os
from crazychoir_fw.simulation.motor_ctrl import MotorCtrl

class Deadly(MotorCtrl):
    def step(self, *arguments):
        os._exit(3)
"""


def test_a_flight_that_kills_its_workers_is_reported_and_the_others_go_on(campaign, tmp_path, pool):
    (tmp_path / "deadly.py").write_text(DEADLY)
    options = [None, None, "deadly.py:Deadly"]
    whole = campaign(vary={"drones[0].motor_ctrl": {"choice": options}}, flights=3, design="grid")
    outcome = run(whole, tmp_path / "out", pool)
    assert [record.outcome for record in outcome.records] == ["passed", "passed", CRASHED]
    assert "3 workers died of it" in outcome.records[2].failures[0]
    assert outcome.verdict.answer == "NO-GO"


def test_results_are_for_people_and_for_machines(campaign, tmp_path):
    whole = campaign(vary=WEAK, flights=16, require={"success": 0.9}, quantiles={"rms_error_m": {"max": 0.001}})
    outcome = run(whole, tmp_path / "out", here)
    page = write_results(outcome).read_text()
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    assert summary["answer"] == "NO-GO" and f"<title>{summary['answer']}" in page
    assert summary["hash"] == hash_of(outcome.records)
    assert "thrust_scale" in summary["influences"][0]["key"]
    suite = ElementTree.parse(tmp_path / "out/junit.xml").getroot()
    assert suite.find("testcase[@name='verdict']/failure").get("message") == "NO-GO"
    assert len(suite) == 17
    rows = (tmp_path / "out/flights.csv").read_text().splitlines()
    assert len(rows) == 17 and rows[0].startswith("flight,outcome,defaults.vehicle.rotors.thrust_scale")


def test_who_is_to_blame_is_named_first(campaign, tmp_path):
    """A planted weakness: half of the thrusts are too small to fly."""
    outcome = run(campaign(vary=WEAK, flights=24), tmp_path / "out", here)
    found = blame(outcome.campaign, outcome.records)
    assert (found[0].key, found[0].figure) == ("defaults.vehicle.rotors.thrust_scale", "failed")
    assert found[0].rank < -0.6


def test_an_early_end_does_not_depend_on_order(campaign, tmp_path, pool):
    whole = campaign(vary=WEAK, flights=60, early_stop={"margin": 0.2, "error": 0.05}, require={"success": 0.75})
    one = run(whole, tmp_path / "one", here)
    two = run(whole, tmp_path / "two", pool)
    assert one.verdict.answer == "NO-GO" and len(one.records) < 60
    assert hash_of(one.records) == hash_of(two.records)


def test_a_search_finds_the_least_deviation_and_keeps_it(campaign, tmp_path):
    weaker = {"defaults.vehicle.rotors.thrust_scale": {"normal": {"mean": 0.95, "std": 0.15}, "low": 0.3, "high": 1.2}}
    whole = campaign(vary={**VARY, **weaker}, search={"budget": 60})
    finding = Search(whole, here, silent).run()
    assert finding.keys == ("defaults.vehicle.rotors.thrust_scale",)
    path = write_finding(whole, finding, tmp_path)
    flown = fly_again(read_flights(path.parent), here)
    assert flown[path].digest == finding.record.digest and not flown[path].passed
    nearer = tuple(0.5 + 0.9 * (share - 0.5) for share in finding.shares)
    assert fly_whole(whole.job(0, whole.values_at(nearer))).success


def test_a_halved_gain_is_found_between_before_and_after(campaign, tmp_path):
    """A planted regression: the drone does not come down where it should any more."""
    gains = ["defaults.parameters.posCtlPid.xKp=0.2", "defaults.parameters.posCtlPid.yKp=0.2"]
    vary = {"drones[0].vehicle.trim.torque[0]": {"uniform": [-1e-3, 1e-3]}}
    whole = campaign(vary=vary, flights=8, compare={"after": {"set": gains}})
    outcomes = [run(side, tmp_path / name, here) for name, side in variants_of(whole).items()]
    both = compare(*outcomes)
    errors = next(one for one in both.differences if one.figure == "endpoint_error_m")
    assert errors.low > 0.0
    assert all(a.values == b.values for a, b in zip(outcomes[0].records, outcomes[1].records, strict=True))


@pytest.mark.parametrize(("flights", "code", "answer"), [(14, 0, "GO"), (3, 1, "NO-GO")])
def test_exit_codes_of_the_command(campaign, tmp_path, flights, code, answer):
    from typer.testing import CliRunner

    from crazychoir_fw.cli import app

    campaign(vary={"seed": {"choice": [1]}}, flights=flights, require={"success": 0.8})
    result = CliRunner().invoke(
        app, ["campaign", str(tmp_path / "campaign.yaml"), "--out", str(tmp_path / "out"), "--workers", "1"]
    )
    assert result.exit_code == code, result.output
    assert answer in result.output


def test_a_mission_without_flights_in_a_folder_of_regressions_is_a_sentence(tmp_path):
    from typer.testing import CliRunner

    from crazychoir_fw.cli import app

    result = CliRunner().invoke(app, ["campaign", str(tmp_path)])
    assert result.exit_code == 2


def test_a_folder_that_is_no_campaign_is_a_sentence(tmp_path):
    with pytest.raises(StateError, match="is no folder of a campaign"):
        read_flight(tmp_path, 0)


def test_a_damaged_table_is_a_sentence(campaign, tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "campaign.sqlite").write_bytes(os.urandom(4096))
    with pytest.raises(StateError, match=r"campaign\.sqlite: file is not a database"):
        run(campaign(vary=VARY, flights=1), folder, here)
    assert load_campaign(tmp_path / "campaign.yaml").settings.flights == 1
