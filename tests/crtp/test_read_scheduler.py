"""The order of read requests, when many drones are read at once."""

from collections import deque

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.crtp import read_scheduler as rules
from crazychoir_fw.crtp.read_scheduler import Reading, ReadScheduler, reading_of

ITEM, TYPE, VALUE = b"\x5c\2\0\0", b"\x2f\7\0\0", b"\x2d\0\0"
VALUES = 20


@pytest.mark.parametrize(
    ("datagram", "reading"),
    [
        (ITEM, Reading.TABLES),
        (b"\x2c\2\0\0", Reading.TABLES),
        (b"\x5c\3", None),  # how many there are
        (b"\x2f\2\0\0", Reading.TYPES),
        (TYPE, Reading.TYPES),
        (b"\x2f\3\0\0", None),  # store it
        (VALUE, Reading.VALUES),
        (b"\x2e\0\0\1", None),  # write it
        (b"\x5d\6\1\1", None),  # begin a log block
        (b"\x8c\3", None),
        (b"", None),
        (b"\x5c", None),
    ],
)
def test_what_a_packet_reads(datagram, reading):
    assert reading_of(datagram) is reading


class Swarm:
    """Clients that ask as cflib does, one question after the other, and a radio."""

    def __init__(self, drones, questions):
        self.turns = ReadScheduler(VALUES)
        self.now = 0.0
        self.left = {drone: deque(questions) for drone in range(drones)}
        self.answers = []  # drone and kind, in order

    def run(self):
        asking = deque(self.left)
        while asking or self.turns.waiting:
            self.now += 0.001
            if asking:
                drone = asking.popleft()
                if not self.left[drone]:
                    continue
                question = self.left[drone].popleft()
                if not self.turns.hold(drone, question, self.now):
                    self.answer(asking, drone, question)
            if self.turns.has_ended or not asking:
                for drone, question in self.turns.release(self.now):
                    self.answer(asking, drone, question)
        return self

    def answer(self, asking, drone, question):
        self.answers.append((drone, reading_of(question)))
        asking.append(drone)

    def last(self, kinds):
        return {drone: k for k, (drone, reading) in enumerate(self.answers) if reading in kinds}


QUESTIONS = [ITEM] * 30 + [TYPE] * 10 + [VALUE] * VALUES


def test_who_is_alone_never_waits():
    swarm = Swarm(1, QUESTIONS).run()
    assert len(swarm.answers) == len(QUESTIONS)
    assert swarm.now < 0.001 * (len(QUESTIONS) + 2)


@pytest.mark.parametrize("drones", [2, 5, 30])
def test_tables_one_drone_after_the_other_and_then_the_values(drones):
    swarm = Swarm(drones, QUESTIONS).run()
    assert len(swarm.answers) == drones * len(QUESTIONS)
    ends = swarm.last((Reading.TABLES,))
    assert list(ends) == sorted(ends, key=ends.get) == list(range(drones))
    first_value = next(k for k, (_, reading) in enumerate(swarm.answers) if reading is Reading.VALUES)
    assert first_value > max(swarm.last((Reading.TABLES, Reading.TYPES)).values())
    assert swarm.now < rules.PATIENCE_S * drones  # handed over at once, and not for want of patience


def test_who_has_the_turn_and_says_no_more_loses_it():
    turns = ReadScheduler(VALUES)
    assert not turns.hold("a", ITEM, 0.0)
    assert turns.hold("b", ITEM, 0.0)
    assert turns.release(rules.IDLE_S) == []
    assert turns.release(1.01 * rules.IDLE_S) == [("b", ITEM)]
    assert turns.hold("a", ITEM, 1.02 * rules.IDLE_S)


def test_a_turn_is_not_for_ever():
    turns = ReadScheduler(VALUES)
    turns.hold("a", ITEM, 0.0)
    now = 0.0
    while not turns.hold("a", ITEM, now):
        turns.hold("b", ITEM, now)
        now += 0.05
        if ("b", ITEM) in turns.release(now):
            break
    assert now == pytest.approx(rules.LONGEST_S, abs=0.11)


def test_nobody_waits_for_long():
    turns = ReadScheduler(VALUES)
    turns.hold("a", ITEM, 0.0)
    for drone in "bcd":
        assert turns.hold(drone, ITEM, 0.5)
    turns.hold("a", ITEM, 1.95)
    assert turns.waiting == ["b", "c", "d"]
    turns._turns["a"].began = turns._turns["a"].asked = 2.5  # as if it had begun late
    assert turns.release(0.5 + 1.01 * rules.PATIENCE_S) == [("b", ITEM), ("c", ITEM), ("d", ITEM)]


def test_values_of_a_drone_that_has_long_been_connected_never_wait():
    turns = ReadScheduler(VALUES)
    turns.hold("a", ITEM, 0.0)
    for k in range(VALUES):
        assert not turns.hold("a", VALUE, 0.001 * k)
    turns.hold("b", ITEM, 1.0)
    assert not turns.hold("a", VALUE, 1.0)
    assert not turns.hold("c", VALUE, 1.0)  # never read a table
    # and one that reads its first value late
    turns.release(2.0)
    turns.hold("d", ITEM, 3.0)
    turns.hold("b", ITEM, 3.1 + rules.SWEEP_S)
    assert not turns.hold("d", VALUE, 3.1 + rules.SWEEP_S)


def test_who_asks_without_waiting_is_not_stored_without_end():
    turns = ReadScheduler(VALUES)
    turns.hold("a", ITEM, 0.0)
    held = [turns.hold("b", ITEM, 0.01) for _ in range(1000)]
    assert sum(held) == rules.MAX_HELD


def test_a_client_that_has_gone_is_owed_nothing():
    turns = ReadScheduler(VALUES)
    turns.hold("a", ITEM, 0.0)
    turns.hold("b", ITEM, 0.0)
    turns.hold("c", ITEM, 0.0)
    turns.forget("b")
    turns.forget("a")
    assert turns.has_ended
    assert turns.release(0.01) == [("c", ITEM)]


def test_all_that_waits_can_be_had_at_once():
    turns = ReadScheduler(VALUES)
    for drone in "abc":
        turns.hold(drone, ITEM, 0.0)
    assert turns.release_all() == [("b", ITEM), ("c", ITEM)]
    assert not turns.hold("c", ITEM, 0.0)


@given(
    st.lists(
        st.tuples(st.integers(0, 4), st.sampled_from([ITEM, TYPE, VALUE, b"\xfcping"]), st.floats(0.0, 0.3)),
        max_size=200,
    )
)
def test_whatever_comes_is_answered_once_in_order_and_soon(packets):
    turns, now = ReadScheduler(VALUES), 0.0
    asked, answered, when = {}, {}, {}

    def answer(drone, number):
        answered.setdefault(drone, []).append(number)
        assert now - when[number] <= rules.PATIENCE_S + 0.35

    waiting = {drone: deque() for drone in range(5)}
    for number, (drone, datagram, pause) in enumerate(packets):
        now += pause
        if waiting[drone]:
            continue  # cflib asks the next question when it has the answer
        when[number] = now
        asked.setdefault(drone, []).append(number)
        if turns.hold(drone, datagram, now):
            waiting[drone].append(number)
        else:
            answer(drone, number)
        for freed, _ in turns.release(now):
            answer(freed, waiting[freed].popleft())
    for _ in range(20):
        now += 0.15
        for freed, _ in turns.release(now):
            answer(freed, waiting[freed].popleft())
    assert answered == asked
    assert not turns.waiting
