"""The log of a flight on the page: what was sampled, in each kind of file."""

import csv
import io
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.flight.agent import DronePhase
from crazychoir_fw.gui.flight_record import check_format, csv_lines, record_of, write_record
from crazychoir_fw.recording.flight_log import FlightLog

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def session(open_flight):
    """Four drones that took off, in simulation, with a variable that a browser plots."""
    return open_flight("draw.yaml", speed=0.0)


@pytest.fixture(scope="module")
def client(session, api, tmp_path_factory):
    return api(session, tmp_path_factory.mktemp("drawings"))


@pytest.fixture(scope="module")
def flown(session, client):
    """The log of a flight with a rewind in it, and when that was."""

    def fly(seconds):
        def step():
            for _ in range(round(seconds / session.experiment.period)):
                session.experiment.step()
                session._sample_plots(session.experiment.time)
                session._remember(session.experiment.time)

        session.ask(step).result(60.0)

    with pytest.raises(StateError, match="nothing has been flown yet"):
        record_of(session)
    begin = session.experiment.time
    client.command(name="takeoff")
    session.watched["browser"] = ((1, "pm.vbat"), (2, "sim.x"))
    fly(2.0)
    session.watched.clear()
    fly(2.0)
    old = record_of(session)
    # to a moment that there is, whatever the machine has time for
    back = max(moment.time for moment in session.branches.present.moments if moment.time < begin + 3.0)
    client.command(name="rewind", branch=0, time=back)
    client.command(name="goto", drones=["agent_0"], x=-1.5, y=0.0, z=1.0)
    fly(3.0)
    assert all(agent.phase is DronePhase.FLYING for agent in session.experiment.agents)
    return old, record_of(session), back


def test_a_branch_has_the_past_of_those_before_it(flown, session):
    old, new, back = flown
    shared = old.time <= back
    assert shared.sum() > 5
    np.testing.assert_array_equal(new.time[: shared.sum()], old.time[shared])
    np.testing.assert_array_equal(new.signals["sim.x"][: shared.sum()], old.signals["sim.x"][shared])
    assert np.diff(new.time).min() > 0.0
    assert new.duration_s > 4.0
    # what was commanded in the other future is not in this one
    assert [event["details"]["text"][:7] for event in new.events if event["kind"] == "command"][-1] == "GO TO ("
    assert "GO TO (" not in str(old.events)
    assert abs(new.signals["sim.y"][-1, 0] - old.signals["sim.y"][-1, 0]) > 0.2
    again = record_of(session, 0)
    np.testing.assert_array_equal(again.time, old.time)
    with pytest.raises(StateError, match="there is no branch 99"):
        record_of(session, 99)


def test_it_says_where_drones_were_and_where_they_should_be(flown, session):
    _, log, _ = flown
    true = session.experiment.backend.world.positions()
    last = log.stack("sim.x", "sim.y", "sim.z")[-1]
    np.testing.assert_allclose(last, true, atol=0.1)
    wanted = log.stack("ctrltarget.x", "ctrltarget.y", "ctrltarget.z")[-1]
    np.testing.assert_allclose(wanted[1], [-0.5, -1.5, 1.0], atol=0.05)
    assert log.metadata["mission"] == "draw"
    voltage = log.signals["pm.vbat"]
    assert np.isnan(voltage[:, [0, 2, 3]]).all()
    assert 3.0 < np.nanmin(voltage[:, 1]) < 4.3
    assert np.isnan(voltage[-1, 1]), "nobody plotted it any more"
    # a plotted variable of that name does not replace what every sample has
    assert np.isfinite(log.signals["sim.x"]).all()


def test_a_table_has_a_row_for_each_drone_and_time(flown):
    _, log, _ = flown
    rows = list(csv.DictReader(io.StringIO("".join(csv_lines(log)))))
    assert len(rows) == 4 * len(log.time)
    assert [row["drone"] for row in rows[:4]] == log.drone_ids
    assert float(rows[-1]["sim.z"]) == pytest.approx(log.signals["sim.z"][-1, 3], rel=1e-5)
    assert rows[0]["pm.vbat"] == ""


@pytest.mark.parametrize("kind", ["csv", "mcap", "npz"])
def test_downloads_are_the_files(flown, client, tmp_path, kind):
    _, log, _ = flown
    if kind == "mcap":
        pytest.importorskip("mcap")
    answer = client.get(f"/api/log.{kind}")
    assert answer.status_code == 200
    assert answer.headers["content-disposition"] == f'attachment; filename="draw.{kind}"'
    path = tmp_path / f"flight.{kind}"
    write_record(log, path)
    if kind == "csv":
        assert answer.content == path.read_bytes()
        return
    (tmp_path / f"got.{kind}").write_bytes(answer.content)
    if kind == "npz":
        for one in (path, tmp_path / "got.npz"):
            read = FlightLog.load(one)
            np.testing.assert_array_equal(read.signals["sim.x"], log.signals["sim.x"])
            assert read.events == log.events
        return
    from mcap.reader import make_reader

    with (tmp_path / "got.mcap").open("rb") as file:
        counts = {}
        for _, channel, _ in make_reader(file).iter_messages():
            counts[channel.topic] = counts.get(channel.topic, 0) + 1
    assert counts["/agent_0/odom"] == counts["/agent_3/setpoint"] == len(log.time)
    assert counts["/events"] == len(log.events)


@pytest.mark.parametrize(
    ("path", "status", "sentence"),
    [
        ("/api/log.doc", 422, "a log is allowed to be .csv, .mcap, .npz"),
        ("/api/log.csv?branch=x", 422, "?branch=NUMBER"),
        ("/api/log.csv?branch=77", 409, "there is no branch 77"),
    ],
)
def test_what_cannot_be_downloaded_is_said(client, flown, path, status, sentence):
    answer = client.get(path)
    assert answer.status_code == status
    assert sentence in answer.json()["text"]


def test_a_file_that_cannot_be_written_leaves_the_old_one(flown, tmp_path, monkeypatch):
    from crazychoir_fw.gui import flight_record

    _, log, _ = flown
    path = tmp_path / "flight.csv"
    path.write_text("old")

    def broken(log):
        yield "time"
        raise OSError("disk full")

    monkeypatch.setattr(flight_record, "csv_lines", broken)
    with pytest.raises(OSError, match="disk full"):
        write_record(log, path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_page_that_is_ended_writes_its_log(tmp_path):
    path = tmp_path / "logs" / "flight.csv"
    command = [sys.executable, "-c", "from crazychoir_fw.cli import app; app()", "gui", EXAMPLES / "draw.yaml"]
    command += ["--backend", "integrator", "--no-browser", "--port", "0", "--log", path, "--drawings", tmp_path]
    page = subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE, text=True)
    try:
        told = page.stdout.readline()
        port = re.search(r"http://127\.0\.0\.1:(\d+)/", told)[1]
        pressed = CliRunner().invoke(app, ["press", "takeoff", "--port", port])
        for _ in range(100):  # it listens a moment after it said so
            if pressed.exit_code == 0:
                break
            time.sleep(0.1)
            pressed = CliRunner().invoke(app, ["press", "takeoff", "--port", port])
        assert pressed.stdout == "TAKE-OFF: all 4 drones\n"
        page.send_signal(signal.SIGINT)
        rest, _ = page.communicate(timeout=60.0)
    finally:
        page.kill()
    assert page.returncode == 0
    assert " s of flight are in " in rest
    rows = list(csv.DictReader(path.open()))
    assert {row["drone"] for row in rows} == {f"agent_{k}" for k in range(4)}
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize("name", ["flight", "flight.txt", ".mcap"])
def test_other_files_are_refused(name):
    with pytest.raises(RangeError, match=r"allowed to be \.csv, \.mcap, \.npz"):
        check_format(name)
