"""A flight that was restored from a checkpoint continues with the same bits."""

import threading
from collections import deque

import numpy as np
import pytest

from crazychoir_fw.common.checkpoint import Checkpoint, Stateful
from crazychoir_fw.common.errors import StateError
from crazychoir_fw.flight.engine import make_experiment
from crazychoir_fw.gui.opening import open_mission


class Inner(Stateful):
    unkept = ("lock",)

    def __init__(self):
        self.lock = threading.Lock()
        self.value = 1


class Law(Stateful):
    def __init__(self):
        self.inner = Inner()
        self.tell = lambda: self.inner.value
        self.state = deque([1], maxlen=3)  # by chance named as the method
        self.table = {"seen": self.state, "self": self}
        self.array = np.arange(3.0)
        self.dice = np.random.default_rng(1)


def test_layers_stay_and_get_their_attributes_back():
    law = Law()
    checkpoint = Checkpoint([law])
    inner, lock, first = law.inner, law.inner.lock, law.dice.random()
    for _ in range(2):
        law.inner.value = 2
        law.table["seen"].append(2)
        law.array[1] = 9.0
        law.more = 1
        checkpoint.restore()
        assert (law.inner, law.inner.lock, law.tell()) == (inner, lock, 1)
        assert list(law.state) == [1] and law.table["seen"] is law.state and law.table["self"] is law
        assert law.array.tolist() == [0.0, 1.0, 2.0]
        assert not hasattr(law, "more")
        assert law.dice.random() == first


def test_what_cannot_be_copied_is_named():
    law = Law()
    law.more = threading.Lock()
    with pytest.raises(StateError, match=r"Law: .*lock.* Law.unkept may name what stays as it is"):
        Checkpoint([law])


def flown(experiment, seconds):
    experiment.run(seconds)
    signals = experiment._signals()
    places = [experiment.backend.true_positions(), experiment._commands, *(signals[name] for name in sorted(signals))]
    events = [event.as_dict() for event in experiment.events]
    return b"".join(place.tobytes() for place in places), events, experiment.communication()


def check(experiment):
    checkpoint = Checkpoint([experiment])
    futures = []
    for _ in range(3):
        futures.append(flown(experiment, 0.4))
        experiment.land()
        experiment.run(0.2)
        checkpoint.restore()
    assert futures[0] == futures[1] == futures[2]


NAMES = ["draw", "goto", "formation_rviz", "containment_time_varying", "mpc", "swap_ten", "collision_vel"]
NAMES += ["aggregative_moving_intruders", "task_assignment", "pickup_delivery"]


@pytest.mark.parametrize(
    ("name", "backend"), [*((name, "integrator") for name in NAMES), *((name, "sim") for name in NAMES[:3])]
)
def test_a_flight_goes_on_with_the_same_bits(request, name, backend):
    mission = open_mission(request.config.rootpath / "examples" / f"{name}.yaml", backend=backend)
    experiment = make_experiment(mission)
    experiment.takeoff()
    experiment.run(0.3)
    check(experiment)
    experiment.start()
    experiment.run(1.0)
    check(experiment)


def test_messages_that_are_lost_or_late_are_so_again(request):
    path = request.config.rootpath / "examples" / "bearing_formation.yaml"
    experiment = make_experiment(open_mission(path, backend="integrator", changes=[
        "layers.communication.loss=0.2", "layers.communication.delay_s=0.015", "layers.odometry=mocap"]))  # fmt: skip
    experiment.takeoff()
    experiment.start()
    experiment.run(0.5)
    check(experiment)
    assert experiment.communication()["total"]["lost"] > 0
