"""The past of a flight, as the server sends it to browsers."""

import json

import numpy as np

from crazychoir_fw.gui.branches import Branches, Moment, Sample
from crazychoir_fw.gui.session import MOMENT_S


def test_who_was_not_heard_of_is_nowhere():
    branches = Branches()
    unknown = np.full((2, 3), np.nan, np.float32)
    for time, place in ((0.0, np.nan), (0.1, 0.5)):
        position = np.array([[place, place, place], [1.0, 2.0, 0.25]], np.float32)
        sample = Sample(position, np.zeros((2, 4), np.float32), unknown, unknown, None)
        branches.present.sample(time, sample)
    path = json.loads(json.dumps(branches.path(0), allow_nan=False))
    assert path["positions"] == [[None, [1.0, 2.0, 0.25]], [[0.5, 0.5, 0.5], [1.0, 2.0, 0.25]]]
    assert path["times"] == [0.0, 0.1]


def test_what_was_at_the_moment_that_a_branch_begins_at_is_its_past():
    branches = Branches()
    nothing = Sample(*(np.zeros((1, 3), np.float32),) * 4, None)
    for time in (0.0, 0.1, 0.2):
        branches.present.sample(time, nothing)
    branches.leave(branches.present, Moment(0.1, None, None)).sample(0.11, nothing)
    assert branches.lineage(1)[0] == [0.0, 0.1, 0.11]
    assert branches.lineage(0)[0] == [0.0, 0.1, 0.2]


def test_one_can_go_back_to_before_the_first_command(open_flight, api, until, tmp_path):
    session = open_flight("draw.yaml", speed=0.0, backend="integrator")
    client = api(session, tmp_path)
    begin = session.experiment.time
    assert client.command(name="takeoff")["ok"]  # while time stands still
    client.command(name="speed", factor=20.0)
    until(lambda: session.experiment.time > begin + 1.0)
    client.command(name="speed", factor=0.0)
    assert client.command(name="rewind", branch=0, time=begin)["ok"]
    assert session.experiment.time == begin
    assert not any(agent.is_up for agent in session.experiment.agents)
    assert not client.command(name="goto", drones=["agent_0"], x=0.0, y=0.0, z=1.0)["ok"]


def test_without_a_branch_one_goes_back_in_the_one_that_flies(open_flight, api, until, tmp_path):
    session = open_flight("draw.yaml", speed=0.0, backend="integrator")
    client = api(session, tmp_path)
    begin = session.experiment.time

    def fly_on():
        client.command(name="speed", factor=20.0)
        until(lambda: session.experiment.time > begin + 2.0)
        client.command(name="speed", factor=0.0)

    assert client.command(name="takeoff")["ok"]
    fly_on()
    assert client.command(name="rewind", time=begin)["ok"]
    fly_on()  # on the floor
    assert client.command(name="rewind", time=begin + 1.5)["ok"]
    assert session.branches.present.parent == 1
    # at the latest moment before, and these may be two seconds apart
    assert begin + MOMENT_S <= session.experiment.time <= begin + 1.5
    assert not any(agent.is_up for agent in session.experiment.agents)
