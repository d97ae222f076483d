"""The log of the page while it flies."""

from types import SimpleNamespace

import numpy as np

from crazychoir_fw.gui.branches import Sample
from crazychoir_fw.gui.flight_stream import SessionStream
from crazychoir_fw.recording.flight_log import FlightLog


def session_of(knows_truth):
    mission = SimpleNamespace(name="m", description="", backend="sim", seed=1)
    experiment = SimpleNamespace(events=[])
    access = SimpleNamespace(knows_truth=knows_truth)
    return SimpleNamespace(names=["a", "b"], mission=mission, access=access, experiment=experiment)


def sample_at(x):
    place = np.full((2, 3), x, np.float32)
    return Sample(place, np.tile(np.float32([0.0, 0.0, 0.0, 1.0]), (2, 1)), place, place + 1, None)


def test_a_page_that_is_killed_leaves_its_samples(tmp_path):
    stream = SessionStream(tmp_path / "f.stream")
    for k in range(5):
        stream.sample(session_of(False), 0.1 * k, sample_at(k))
    stream.close()
    log = FlightLog.load(tmp_path / "f.stream")
    assert log.signals["stateEstimate.x"][:, 1].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert log.signals["ctrltarget.z"][:, 0].tolist() == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert log.signals["stateEstimate.qw"][4, 0] == 1.0 and "cut off at 0.400 s" in log.metadata["cut"]


def test_after_time_was_turned_back_the_log_is_of_the_new_branch(tmp_path):
    stream, session = SessionStream(tmp_path / "f.stream"), session_of(True)
    past = [(0.1 * k, sample_at(k)) for k in range(5)]
    for time, sample in past:
        stream.sample(session, time, sample)
    stream.begin_again(past[:3])
    stream.sample(session, 0.25, sample_at(9))
    stream.close()
    log = FlightLog.load(tmp_path / "f.stream")
    assert log.signals["sim.x"][:, 0].tolist() == [0.0, 1.0, 2.0, 9.0]


def test_a_page_on_which_nothing_flew_leaves_no_file(tmp_path):
    SessionStream(tmp_path / "f.stream").close()
    assert not list(tmp_path.iterdir())
