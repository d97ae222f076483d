"""Forks go on from the present instant, independent of each other, also in threads."""

import threading

import pytest
from worlds import make_world

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.simulation import set_threads

COUNT = 6  # enough drones for two threads to share


def airborne(threads=None):
    world = make_world(COUNT, seed=9, threads=threads)
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(0.5, 1.0)
    world.run(1.0)
    return world


def go(world, number):
    for drone in world.drones:
        drone.high_level_commander.go_to(0.1, 0.05 * number, 0.1 * number, 0.0, 0.5, relative=True)
    world.run(0.7)
    return world.snapshot().tobytes()


@pytest.fixture(scope="module")
def expected():
    """Return the snapshots after three futures, each from a world that was flown there separately."""
    set_threads(1)
    return [go(airborne(), number) for number in range(3)]


def test_forks_are_bit_equal_to_worlds_flown_anew(expected):
    world = airborne()
    here = world.snapshot().tobytes()
    assert [go(fork, number) for number, fork in enumerate(world.fork(3))] == expected
    assert world.snapshot().tobytes() == here  # nothing of that was felt here
    assert go(world, 1) == expected[1]


@pytest.mark.parametrize("pool", [1, 2, 3])
def test_forks_may_be_stepped_in_threads_of_their_own(expected, pool):
    """The threads of the pool serve one world at a time; the others help themselves."""
    forks = airborne(threads=pool).fork(6)
    results = [None] * len(forks)

    def fly(number):
        results[number] = go(forks[number], number % 3)

    threads = [threading.Thread(target=fly, args=(number,)) for number in range(len(forks))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == expected + expected


def test_python_goes_on_while_a_world_is_stepped():
    """One call of MuJoCo makes 3000 steps; if it held Python's lock, this thread could not count meanwhile."""
    thread = threading.Thread(target=airborne().run, args=(3.0,))
    thread.start()
    count = 0
    while thread.is_alive():
        count += 1
    assert count > 100


def test_forks_of_forks_and_forks_made_in_threads(expected):
    world = airborne(threads=2)
    results = [None] * 4

    def fly(number):
        results[number] = go(world.fork()[0].fork()[0], number % 3)

    threads = [threading.Thread(target=fly, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [*expected, expected[0]]


def test_a_fork_takes_history_along_and_keeps_its_future_to_itself():
    world = airborne()
    world.note("gust", speed=3)
    (fork,) = world.fork()
    fork.drones[0].high_level_commander.land(0.0, 1.0)
    fork.note("landing", "cf1")
    assert [event.kind for event in fork.events] == ["gust", "landing"]
    assert [event.kind for event in world.events] == ["gust"]
    assert len(fork.journal) == len(world.journal) + 1
    assert fork.journal.recipe == world.journal.recipe
    assert fork.seed == world.seed
    assert fork.scene == world.scene
    assert fork.model is world.model
    assert [drone.config for drone in fork.drones] == [drone.config for drone in world.drones]
    fork.restore(world.snapshot())
    assert [event.kind for event in fork.events] == ["gust"]


def test_the_agenda_stays_behind_unless_somebody_carries_it_over():
    world = airborne()
    seen = []

    def appoint(other):
        other.agenda.at(1900 + other.tick, lambda: seen.append(other))

    world.agenda.every(10, lambda: seen.append("periodic"))
    (bare,) = world.fork()
    bare.run(0.1)
    assert seen == []
    world.when_forked.append(appoint)
    (first,) = world.fork()
    (second,) = first.fork()
    for fork in (first, second):
        fork.run(2.0)
    assert seen == [first, second]


def test_client_settings_go_along():
    world = airborne()
    world.drones[2].commander.set_client_xmode(True)
    fork = world.fork()[0]
    assert [drone.commander.is_client_xmode for drone in fork.drones] == [k == 2 for k in range(COUNT)]


@pytest.mark.parametrize("count", [0, -1, 1.5])
def test_an_impossible_number_of_forks_is_refused(count):
    with pytest.raises(RangeError, match=r"allowed: 1 or more worlds"):
        make_world().fork(count)
