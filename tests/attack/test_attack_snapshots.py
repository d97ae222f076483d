"""Tampered snapshots: refused in one sentence, or flown on without harm. `ATTACK_SNAPSHOTS=10000` tries so many."""

import os
import random
from pathlib import Path

import numpy as np
import pytest

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.simulation import DroneConfig, Snapshot, World

COUNT = int(os.environ.get("ATTACK_SNAPSHOTS", "200"))
SEED = int(os.environ.get("ATTACK_SEED", "1"))
KINDS = (
    {},
    {"positioning": "lighthouse"},
    {"positioning": "flow"},
    {"estimator": "complementary"},
    {"platform": "cf21bl"},
)
WORDS = (0, 1, 0x7F, 0xFF, 0x7FFFFFFF, 0xFFFFFFFF, 0x80000000, 0x7F800000, 0x7FC00000, 0xFF7FFFFF)


@pytest.fixture(scope="module")
def world(tmp_path_factory):
    here = Path.cwd()
    os.chdir(tmp_path_factory.mktemp("attack"))  # MuJoCo writes its warnings beside
    world = World([DroneConfig(f"cf{i}", (float(i), 0.0), **kind) for i, kind in enumerate(KINDS)], visuals=False)
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(0.5, 0.5)
    world.run(0.3)
    yield world
    os.chdir(here)


def spoil_state(state, dice):
    """Change a few words, bytes or numbers of a state, most of which are memory of drones."""
    for _ in range(dice.choice((1, 1, 1, 2, 10, 100))):
        how = dice.randrange(3)
        if how == 0:
            state.view(np.uint32)[dice.randrange(2 * len(state))] = dice.choice(WORDS)
        elif how == 1:
            state.view(np.uint8)[dice.randrange(8 * len(state))] = dice.randrange(256)
        else:
            state[dice.randrange(len(state))] = dice.choice((np.nan, np.inf, -1.0, 1e300, 0.0))


@pytest.mark.timeout(120 + COUNT // 5)
def test_tampered_states_are_refused_or_flown(world, tmp_path):
    dice, outcomes = random.Random(SEED), {"refused": 0, "flown": 0}
    good = world.snapshot()
    good.save(tmp_path / "good.npz")
    loaded = Snapshot.load(tmp_path / "good.npz")
    for _ in range(COUNT):
        spoilt = Snapshot(loaded.state.copy(), loaded.beside, loaded.fingerprint, loaded.time, is_trusted=False)
        spoil_state(spoilt.state, dice)
        try:
            world.restore(spoilt)
            world.step(30)
            outcomes["flown"] += 1
        except CrazychoirError as error:
            assert "\n" not in str(error)
            assert len(str(error)) < 500
            outcomes["refused"] += 1
    print(f"{COUNT} tampered states: {outcomes}")
    assert min(outcomes.values()) > COUNT // 20
    # the world is as good as before
    world.restore(good)
    world.step(30)
    twin = world.snapshot().tobytes()
    world.restore(good)
    world.step(30)
    assert world.snapshot().tobytes() == twin


@pytest.mark.timeout(120 + COUNT // 5)
def test_tampered_files_are_refused_or_read(world, tmp_path):
    dice = random.Random(SEED)
    world.snapshot().save(tmp_path / "good.npz")
    content = (tmp_path / "good.npz").read_bytes()
    path, refused = tmp_path / "spoilt.npz", 0
    for _ in range(COUNT):
        spoilt = bytearray(content)
        for _ in range(dice.choice((1, 1, 3, 30))):
            spoilt[dice.randrange(len(spoilt))] = dice.randrange(256)
        where = dice.randrange(len(spoilt))
        path.write_bytes(dice.choice((spoilt, spoilt, spoilt[:where], spoilt[where:], spoilt + spoilt)))
        try:
            world.restore(Snapshot.load(path))
        except CrazychoirError as error:
            refused += 1
            assert "\n" not in str(error)
    print(f"{COUNT} tampered files: {refused} refused")
    assert refused > COUNT // 2


def test_an_archive_that_unpacks_to_too_much_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("crazychoir_fw.simulation.snapshot.LARGEST", 10**6)
    np.savez_compressed(tmp_path / "bomb.npz", about="{}", state=np.zeros(10**6))
    with pytest.raises(CrazychoirError, match="it unpacks to 80[0-9]+ bytes, allowed: at most 1000000"):
        Snapshot.load(tmp_path / "bomb.npz")
