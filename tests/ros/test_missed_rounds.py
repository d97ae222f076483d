"""A drone that joins a swarm in lock step may be a round behind: the others wait for it once or twice only."""

import pytest

from crazychoir_fw.guidance import InProcessTransport, TimeVaryingCommunicator
from crazychoir_fw.ros.wall_timeouts import RoundResync

PATIENCE = 0.5  # [s], the timeout of a round
STEP = 0.01  # [s]


class Wall:
    """A clock that is set by hand."""

    def __init__(self):
        self.now = 0.0

    def __call__(self):
        return self.now


class Member:
    """One drone's rounds, as its node works on them in lock step."""

    def __init__(self, number, transport, wall, makes_up=True):
        self.communicator = TimeVaryingCommunicator(
            number, 3, [i for i in range(3) if i != number], transport=transport
        )
        self.missed = RoundResync(self.communicator, 0.5 * PATIENCE, wall)
        self.makes_up = makes_up
        self.is_open = False

    def begin(self, awaited):
        self.awaited = [i for i in awaited if i in self.communicator.in_neighbors]
        if self.makes_up:
            self.missed.make_up()
        self.communicator.catch_up()
        self.communicator.neighbors_send(0)
        self.is_open = True

    def finish(self):
        self.is_open = False
        self.communicator.collect()
        self.missed.look()

    def look(self):
        """A message came."""
        if not self.is_open:
            self.missed.look()
        elif self.communicator.has_round(self.awaited):
            self.finish()


def step(members, awaited, wall):
    """Run a round of all members; return whether any of them timed out."""
    for member in members:
        member.begin(awaited)
        for other in members:
            other.look()
    wall.now += STEP
    late = [member for member in members if member.is_open]
    if late:
        wall.now += PATIENCE
    for member in late:
        member.finish()
    return bool(late)


def waits_after_joining(order, makes_up):
    """Return for twenty steps whether there was a wait, after the last of three has joined."""
    wall, transport = Wall(), InProcessTransport()
    old = [Member(i, transport, wall, makes_up) for i in (0, 1)]
    assert not any(step(old, [0, 1], wall) for _ in range(7))
    members = [*old, Member(2, transport, wall, makes_up)]
    # the others do not know of it in its first step
    step([members[i] for i in order], [0, 1], wall)
    return [step([members[i] for i in order], [0, 1, 2], wall) for _ in range(20)]


@pytest.mark.parametrize("order", [(2, 0, 1), (0, 2, 1), (0, 1, 2)])
def test_who_joins_is_soon_in_step(order):
    waits = waits_after_joining(order, makes_up=True)
    assert sum(waits) <= 3
    assert not any(waits[5:])


def test_without_making_up_all_wait_for_ever():
    assert all(waits_after_joining((2, 0, 1), makes_up=False))


def test_a_short_pause_is_no_missed_round():
    wall, transport = Wall(), InProcessTransport()
    members = [Member(i, transport, wall) for i in range(3)]
    for pause in (0.0, 0.1, 0.24, 0.1):
        # one begins, and the others do only after a while
        members[0].begin([0, 1, 2])
        members[1].look()
        wall.now += pause
        for member in members[1:]:
            member.begin([0, 1, 2])
        for member in members:
            member.look()
        assert not any(member.is_open for member in members)
    assert {member.communicator.current_label for member in members} == {4}
    assert all(member.communicator.statistics.jumps == 0 for member in members)
