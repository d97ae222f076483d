"""Layers are made what they were, in place."""

from collections import deque

import numpy as np
import pytest

from crazychoir_fw.flight.access import open_access
from crazychoir_fw.flight.engine import make_experiment
from crazychoir_fw.gui.memory import Memory
from crazychoir_fw.gui.opening import open_mission


class Slotted:
    __slots__ = ("value",)

    def __init__(self, value):
        self.value = value


class Thing:
    def __init__(self):
        count = 0

        def step():
            nonlocal count
            count += 1
            self.seen.append(count)
            return count

        self.step = step
        self.seen = deque(maxlen=3)
        self.table = {"a": [1, 2], "self": self}
        self.array = np.arange(3.0)
        self.slotted = Slotted([1])
        self.dice = np.random.default_rng(1)


def test_everything_within_reach_is_restored():
    thing = Thing()
    inner = thing.table["a"]
    thing.step()
    memory = Memory([thing])
    first = thing.dice.random()
    thing.step()
    inner.append(3)
    thing.table["new"] = 1
    thing.array[1] = 9.0
    thing.slotted.value.append(2)
    thing.slotted = None
    thing.more = 1
    for _ in range(2):
        memory.restore()
        assert thing.step() == 2
        assert list(thing.seen) == [1, 2]
        assert thing.table["a"] is inner
        assert inner == [1, 2]
        assert set(thing.table) == {"a", "self"}
        assert thing.array.tolist() == [0.0, 1.0, 2.0]
        assert thing.slotted.value == [1]
        assert not hasattr(thing, "more")
        assert thing.dice.random() == first


def test_leaves_stay_as_they_are():
    thing, leaf = Thing(), [1]
    thing.leaf = leaf
    memory = Memory([thing], [leaf])
    leaf.append(2)
    memory.restore()
    assert thing.leaf == [1, 2]


@pytest.mark.parametrize("backend", ["sim", "integrator"])
@pytest.mark.parametrize("name", ["draw", "goto", "formation_rviz"])
def test_a_flight_goes_on_with_the_same_bits(request, name, backend):
    mission = open_mission(request.config.rootpath / "examples" / f"{name}.yaml", backend=backend)
    experiment = make_experiment(mission)
    access = open_access(experiment.backend)
    experiment.takeoff()
    experiment.start()
    experiment.run(0.5)
    roots, leaves = access.memory_roots()
    memory, world = Memory([experiment, *roots], [*leaves, mission, access]), access.remember()
    futures = []
    for _ in range(3):
        experiment.run(0.4)
        futures.append(np.concatenate([experiment.backend.true_positions().ravel(), experiment._commands.ravel()]))
        memory.restore()
        access.recall(world)
    assert futures[0].tobytes() == futures[1].tobytes() == futures[2].tobytes()
