"""Services of experiments: when they have their turn, and that none of them ends a flight."""

import numpy as np
from flown_layers import hover, mission

from crazychoir_fw.flight.engine import make_experiment
from crazychoir_fw.flight.experiment import Experiment
from crazychoir_fw.flight.services import Service, make_services


class Counter(Service):
    """Remembers its turns."""

    def __init__(self, fails_at=np.inf):
        self.started = []
        self.turns = []
        self.fails_at = fails_at

    def start(self, now):
        self.started.append(now)

    def step(self, now, poses, flying):
        if now >= self.fails_at:
            raise ValueError("no more")
        if not self.turns:
            self.note("hello", 1, "from a service")
        self.turns.append((now, poses.position.copy(), flying.copy()))


def flown(*services):
    made = make_experiment(mission(hover(2)))
    return Experiment(made.backend, made.agents, made.groups, 50, 25, services=services)


def test_a_service_has_its_turn_in_every_round():
    counter = Counter()
    experiment = flown(counter)
    experiment.takeoff("b")
    experiment.run(1.0)
    experiment.start()
    experiment.run(1.0)
    assert len(counter.turns) == 100
    assert counter.started == [1.0]
    now, positions, flying = counter.turns[49]
    assert (round(now, 6), list(flying)) == (0.98, [False, True])
    assert positions[1, 2] > 0.1 > positions[0, 2]
    assert [(h.kind, h.drone, h.details) for h in experiment.events][1] == ("hello", "b", "from a service")


def test_a_service_that_fails_is_left_out_and_the_others_go_on():
    good, bad = Counter(), Counter(fails_at=0.5)
    experiment = flown(bad, good)
    experiment.takeoff()
    experiment.run(1.0)
    assert len(bad.turns) == 25
    assert len(good.turns) == 50
    assert experiment.failures == ["Counter: ValueError: no more (test_services.py:24) (at 0.50 s)"]
    assert [agent.is_up for agent in experiment.agents] == [True, True]
    assert experiment.events[-1].kind == "failure"


def test_a_mission_without_services_has_none():
    experiment = make_experiment(mission(hover(1)))
    assert experiment.services == []
    assert make_services(mission(hover(1)), experiment.agents) == []
