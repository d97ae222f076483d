"""A take-off that falls into a reset of the supervisor on the floor, 30 s after the drone became ready, happens."""

import pytest
from flown_layers import hover, mission

from crazychoir_fw._core import lib
from crazychoir_fw.flight.engine import make_experiment

ON_BOARD = {"rate": 100, "guidance": {"class": "SimpleGuidance", "height": 0.5}}
PERIOD_MS = 40


@pytest.fixture(scope="module", params=["cf2", "cf21bl"])
def waited(request):
    """A flight of each kind whose drone has waited on the floor until shortly before the reset, and when that is."""
    flights = {}
    for kind in ("on board", "streamed"):
        data = hover(backend="sim", criteria={"landed": False})
        data["drones"][0]["platform"] = request.param
        if kind == "on board":
            data["layers"] = ON_BOARD
        experiment = make_experiment(mission(data))
        world = experiment.backend.world
        drone = world.drones[0]
        if request.param == "cf21bl" and not drone.can_fly:
            drone.arm()
            world.run(0.1)
        supervisor = drone.struct.onboard.supervisor
        reset = supervisor.arming_tick + supervisor.prefltTimeout + PERIOD_MS
        experiment.run(reset / 1000 - world.time - 0.1)
        flights[kind] = experiment, world.snapshot(), reset
    return flights


def shortly_before(waited, kind, before_ms):
    """Return the flight and its world, so long before the reset."""
    experiment, snapshot, reset = waited[kind]
    world = experiment.backend.world
    world.restore(snapshot)
    world.step(reset - before_ms - world.tick)
    return experiment, world


@pytest.mark.parametrize("before_ms", [61, 41, 40, 39, 21, 1, 0, -1, -39, -41, -79, -81, -121])
@pytest.mark.parametrize("kind", ["on board", "streamed"])
def test_a_takeoff_around_a_reset_happens(waited, kind, before_ms):
    experiment, world = shortly_before(waited, kind, before_ms)
    experiment.takeoff()
    assert experiment.failures == []
    experiment.run(3.5)
    assert experiment.failures == []
    assert world.drones[0].true_position[2] == pytest.approx(0.5, abs=0.1)
    experiment.stop()


def test_a_goal_that_waits_ends_with_a_stop(waited):
    experiment, world = shortly_before(waited, "on board", -1)
    experiment.takeoff()
    experiment.step()
    assert world.drones[0].struct.onboard.supervisor.state != lib.supervisorStateReadyToFly
    experiment.stop()
    experiment.run(1.0)
    assert world.drones[0].true_position[2] < 0.05


def test_a_goal_that_waits_is_forgotten_when_time_is_turned_back(waited):
    experiment, world = shortly_before(waited, "on board", -1)
    experiment.takeoff()
    experiment.step()
    world.restore(waited["on board"][1])
    experiment.backend.advance(0.05)
    experiment.backend.advance(2.0)
    assert world.drones[0].true_position[2] < 0.05
    experiment.stop()


def test_a_drone_that_does_not_get_ready_says_so(waited):
    experiment, world = shortly_before(waited, "on board", -1)
    drone = world.drones[0]
    assert experiment.backend.unlock([0]) == []
    # and then lies on its back
    address = drone.qpos_address
    world.data.qpos[address + 3 : address + 7] = [0.0, 1.0, 0.0, 0.0]
    experiment.backend.advance(1.5)
    assert "the motors may not run" in experiment.backend.failures()[0]
    assert experiment.backend.unlock([0]) == [0]
