"""Followers of a formation on the page: cards say where they are, and they can be sent to places."""

import asyncio
from types import SimpleNamespace

import numpy as np

from crazychoir_fw.gui.words import Words


def test_followers_go_where_they_are_sent_and_to_their_starts(open_flight, api, until, tmp_path):
    session = open_flight("bearing_formation.yaml", speed=20.0, backend="integrator")
    client = api(session, tmp_path)
    starts = session.frame.position[:, :2].copy()
    assert client.command(name="takeoff")["ok"]
    until(lambda: session.frame.position[:, 2].min() > 0.5)
    answer = client.command(name="goto", drones=["agent_2"], x=2.5, y=2.5, z=1.0)
    assert answer["ok"], answer
    until(lambda: np.linalg.norm(session.frame.position[2] - [2.5, 2.5, 1.0]) < 0.1)
    cards = asyncio.run(Words(session, SimpleNamespace(version=0))())["cards"]
    assert np.linalg.norm(np.array(cards[2]["place"]) - [2.5, 2.5, 1.0]) < 0.2
    assert cards[2]["speed"][0] < 1.0
    answer = client.command(name="starts")
    assert answer["ok"] and "all 4 drones" in answer["text"], answer
    until(lambda: np.linalg.norm(session.frame.position[:, :2] - starts, axis=1).max() < 0.1)
    answer = client.command(name="land")
    until(lambda: session.frame.position[:, 2].max() < 0.06)
