"""Simulated Crazyradios: what is lost, late, repeated and shared, by statistics with fixed seeds."""

import copy
import io
import json
import math
import random
from itertools import accumulate, pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.crtp.link_model import Direction, PerfectLink, RadioConfig, SimulatedRadios
from crazychoir_fw.crtp.link_model.airtime import failed_try, good_try, transmission
from crazychoir_fw.crtp.link_model.tables import link_tables

UP, DOWN = Direction.UP, Direction.DOWN


def radios(drones=1, seed=1, **config):
    ids = [f"cf{i + 1}" for i in range(drones)]
    return SimulatedRadios([RadioConfig(drones=["*"], **config)], ids, seed)


def stream(link, drones, rate, seconds, directions=(UP,), size=18, droppable=False):
    """Send evenly, drones one after the other, numbered; return all arrivals as (time asked, arrival)."""
    arrived = []
    count = round(seconds * rate)
    for k in range(count):
        for i in range(drones):
            now = (k + i / drones) / rate
            arrived += [(now, arrival) for arrival in link.arrivals(now)]
            for direction in directions:
                link.send(now, f"cf{i + 1}", direction, k.to_bytes(4, "little").ljust(size, b"."), droppable)
    return arrived + drain(link, seconds)


def drain(link, now):
    """Ask as a server does, whenever the link says, until nothing is under way."""
    arrived = []
    while (now := max(now, link.next_arrival())) < math.inf:
        arrived += [(now, arrival) for arrival in link.arrivals(now)]
    return arrived


def numbers(arrived, drone="cf1", direction=UP):
    return [
        int.from_bytes(arrival.datagram[:4], "little")
        for _, arrival in arrived
        if (arrival.drone, arrival.direction) == (drone, direction)
    ]


def within_binomial(count, trials, share, sigmas=4.0):
    return abs(count - trials * share) <= sigmas * math.sqrt(trials * share * (1.0 - share)) + 1e-9


# ---------------------------------------------------------------- airtime


@pytest.mark.parametrize(
    ("size", "rate", "microseconds"),
    [(0, "2M", 36.5), (32, "2M", 164.5), (32, "1M", 329.0), (32, "250K", 1316.0), (1, "250K", 324.0)],
)
def test_frames_are_preamble_address_control_payload_and_checksum(size, rate, microseconds):
    assert transmission(size, rate) * 1e6 == pytest.approx(microseconds)


@pytest.mark.parametrize(("payload", "least", "most"), [(4, 1500, 1700), (28, 1100, 1300)])
def test_a_dongle_echoes_as_many_packets_as_the_client_library_asks_for(payload, least, most):
    link = radios()
    for _ in range(60):
        link.send(0.0, "cf1", UP, bytes(1 + payload))
        link.send(0.0, "cf1", DOWN, bytes(1 + payload))
    last = max(time for time, _ in drain(link, 0.0))
    assert least < 60 / last < most


# ---------------------------------------------------------------- loss


@pytest.mark.parametrize("loss", [0.05, 0.3, 0.8])
def test_without_repetition_the_share_of_lost_packets_is_that_of_lost_transmissions(loss):
    link = radios(loss=loss, retries=0, reliable=False, link_tries=1000000, link_timeout=1000)
    arrived = stream(link, 1, 100, 20)
    tally = link.statistics()["drones"]["cf1"]["up"]
    assert tally["sent"] == 2000 and tally["repeated"] == 0
    assert within_binomial(tally["lost"], 2000, loss)
    assert len(arrived) == tally["delivered"] == 2000 - tally["lost"]


def test_retries_of_the_dongle_save_most_packets():
    link = radios(loss=0.5, retries=3, reliable=False)
    stream(link, 1, 100, 20)
    tally = link.statistics()["drones"]["cf1"]["up"]
    assert within_binomial(tally["lost"], 2000, 0.5**4)


def test_a_reliable_link_loses_nothing_and_keeps_the_order():
    link = radios(3, loss=0.5, retries=1, link_timeout=100, link_tries=100000)
    arrived = stream(link, 3, 30, 10, (UP, DOWN))
    for direction in (UP, DOWN):
        for drone in ("cf1", "cf2", "cf3"):
            assert numbers(arrived, drone, direction) == list(range(300))
    tally = link.statistics()["drones"]["cf2"]["up"]
    assert tally["lost"] == 0 and tally["repeated"] > 100


def test_answers_get_lost_by_a_share_of_their_own():
    link = radios(loss=0.0, loss_down=0.4, retries=0, reliable=False, link_tries=1000000)
    stream(link, 1, 100, 10, (UP, DOWN))
    figures = link.statistics()["drones"]["cf1"]
    assert figures["up"]["lost"] == 0
    assert within_binomial(figures["down"]["lost"], 1000, 0.4)


def test_what_a_drone_says_waits_until_it_is_asked():
    # unacknowledged, but the drone never heard of it: nothing of the drone is lost
    link = radios(loss=0.4, loss_down=0.0, retries=0, reliable=False, link_tries=1000000, link_timeout=1000)
    stream(link, 1, 100, 10, (DOWN,))
    assert link.statistics()["drones"]["cf1"]["down"]["delivered"] == 1000


def test_nothing_comes_through_a_dead_link_and_it_is_lost():
    link = radios(2, loss=1.0)
    assert not link.is_lost("cf1")
    assert stream(link, 2, 50, 3, (UP, DOWN)) == []
    figures = link.statistics()
    assert link.is_lost("cf1") and link.is_lost("cf2")
    assert figures["radios"]["radio1"]["lost_links"] == 2
    for drone in figures["drones"].values():
        assert drone["up"]["lost"] == drone["up"]["sent"]
        assert drone["down"]["lost"] == drone["down"]["sent"]


@pytest.mark.parametrize(("tries", "timeout", "after"), [(100, 1000.0, "tries"), (1000000, 0.5, "timeout")])
def test_a_link_is_lost_after_so_many_tries_or_so_much_time(tries, timeout, after):
    link = radios(loss=1.0, link_tries=tries, link_timeout=timeout)
    link.send(0.0, "cf1", UP, bytes(18))
    step = (0.4 + 4 * 1e3 * failed_try(18, "2M")) / 1e3
    expected = 100 * step if after == "tries" else 0.5
    link.arrivals(expected - 2 * step)
    assert not link.is_lost("cf1")
    link.arrivals(expected + 3 * step)
    assert link.is_lost("cf1")


def test_a_drone_out_of_reach_takes_no_time_of_the_others_once_its_link_is_lost():
    link = radios(2)
    (dongle,) = link.dongles
    dongle.links[1].is_lost = True
    for _ in range(50):
        link.send(0.0, "cf1", UP, bytes(18))
    last = max(time for time, _ in drain(link, 0.0))
    assert last < 50.5 * (0.4e-3 + good_try(18, 1, "2M")) + 2e-3


# ---------------------------------------------------------------- time


def latencies(**config):
    link = radios(**config)
    rng = random.Random(3)
    now, late = 0.0, []
    for _ in range(2000):
        now += 0.1 + 0.01 * rng.random()  # nothing of the one before is under way
        link.send(now, "cf1", UP, bytes(18))
        late.append(drain(link, now)[0][0] - now)
    return late, link.statistics()["drones"]["cf1"]["up"]


@pytest.mark.parametrize(
    ("shape", "mean", "deviation"), [("normal", 20.0, 2.0), ("uniform", 20.0, 2.0 / 3**0.5), ("exponential", 22.0, 2.0)]
)
def test_latencies_have_the_distribution_that_was_asked_for(shape, mean, deviation):
    late, tally = latencies(latency_ms=20.0, jitter_ms=2.0, jitter=shape)
    # half a turn-around, the packet on the air, and the exchange that is going on when it is sent
    null = 0.4e-3 + good_try(1, 1, "2M")
    own = 1e3 * (0.2e-3 + transmission(18, "2M") + null / 2)
    spread = math.hypot(deviation, 1e3 * null / 12**0.5)
    milliseconds = [1e3 * value for value in late]
    average = sum(milliseconds) / len(milliseconds)
    assert average == pytest.approx(mean + own, abs=4 * spread / 2000**0.5)
    actual = (sum((value - average) ** 2 for value in milliseconds) / 2000) ** 0.5
    assert actual == pytest.approx(spread, rel=0.08)
    assert tally["latency_mean_ms"] == pytest.approx(average)
    assert tally["latency_max_ms"] == pytest.approx(max(milliseconds))
    assert tally["latency_p95_ms"] == pytest.approx(sorted(milliseconds)[1899], rel=0.03)


def test_jitter_alone_changes_no_order():
    arrived = stream(radios(latency_ms=50.0, jitter_ms=50.0), 1, 200, 5)
    assert numbers(arrived) == list(range(1000))


def test_reordering_is_what_was_asked_for():
    link = radios(reorder=0.2, reorder_ms=100.0)
    arrived = stream(link, 1, 100, 20)
    assert sorted(numbers(arrived)) == list(range(2000))
    assert numbers(arrived) != list(range(2000))
    tally = link.statistics()["drones"]["cf1"]["up"]
    order = numbers(arrived)
    overtaken = sum(number < newest for number, newest in zip(order, accumulate(order, max), strict=True))
    assert tally["reordered"] == overtaken
    # one in five is held up by 0 to 100 ms, and is overtaken when that is more than the 10 ms between two packets
    assert within_binomial(overtaken, 2000, 0.2 * 0.9, sigmas=5)


def test_duplicates_are_what_was_asked_for_and_follow_their_original():
    link = radios(duplicate=0.25)
    arrived = numbers(stream(link, 1, 100, 20))
    tally = link.statistics()["drones"]["cf1"]["up"]
    assert within_binomial(tally["duplicated"], 2000, 0.25)
    assert len(arrived) == 2000 + tally["duplicated"]
    assert arrived == sorted(arrived)


# ---------------------------------------------------------------- sharing


def test_drones_in_need_share_a_radio_evenly():
    link = radios(8)
    for k in range(200):
        for i in range(8):
            link.send(k / 200, f"cf{i + 1}", DOWN, bytes(31), droppable=True)
    link.arrivals(1.0)
    got = [drone["down"]["delivered"] for drone in link.statistics()["drones"].values()]
    assert max(got) - min(got) <= 1
    # as many as there are exchanges in a second
    assert sum(got) == pytest.approx(1.0 / (0.4e-3 + good_try(1, 31, "2M")), rel=0.01)
    assert link.statistics()["radios"]["radio1"]["utilization"] > 0.99


def test_a_greedy_drone_starves_nobody():
    link = radios(4)
    for k in range(1000):
        link.send(k / 1000, "cf1", DOWN, bytes(31), droppable=True)
        if k % 20 == 0:
            link.send(k / 1000, "cf2", UP, bytes(18))
    drain(link, 1.0)
    figures = link.statistics()["drones"]
    assert figures["cf1"]["down"]["dropped"] > 400
    assert figures["cf2"]["up"]["delivered"] == 50
    assert figures["cf2"]["up"]["latency_max_ms"] < 6.0


def test_logs_are_dropped_when_the_queue_is_full_and_replies_are_not():
    link = radios(queue=10)
    for k in range(50):
        link.send(0.0, "cf1", DOWN, bytes([1]) * 31, droppable=True)
        link.send(0.0, "cf1", DOWN, bytes([2, k]))
    arrived = [arrival.datagram for _, arrival in drain(link, 0.0)]
    assert [datagram[1] for datagram in arrived if datagram[0] == 2] == list(range(50))
    tally = link.statistics()["drones"]["cf1"]["down"]
    assert tally["dropped"] == 45 and tally["most_waiting"] == 55


def test_a_flood_does_not_fill_the_memory():
    link = radios()
    for _ in range(5000):
        link.send(0.0, "cf1", UP, bytes(31))
    tally = link.statistics()["drones"]["cf1"]["up"]
    assert tally["most_waiting"] == 1000 and tally["dropped"] == 4000


def two_radios(channels, data_rate="2M"):
    configs = [
        RadioConfig(drones=[drone], channel=channel, data_rate=data_rate, retries=0, reliable=False, link_tries=1000000)
        for drone, channel in zip(("cf1", "cf2"), channels, strict=True)
    ]
    link = SimulatedRadios(configs, ["cf1", "cf2"], 1)
    stream(link, 2, 100, 10, (UP, DOWN))
    return link.statistics()["radios"]


@pytest.mark.parametrize(
    ("channels", "data_rate", "disturb"),
    [((80, 80), "2M", True), ((80, 81), "2M", True), ((80, 82), "2M", False), ((80, 81), "250K", False)],
)
def test_radios_on_one_channel_disturb_each_other(channels, data_rate, disturb):
    for figures in two_radios(channels, data_rate).values():
        assert (figures["collisions"] > 50) == disturb
        assert disturb or figures["collisions"] == figures["unanswered"] == 0


def test_radios_without_a_channel_get_one_of_their_own():
    ids = [f"cf{i}" for i in range(30)]
    configs = [RadioConfig(drones=[drone]) for drone in ids[:-1]] + [RadioConfig(drones=ids[-1:], channel=80)]
    link = SimulatedRadios(configs, ids)
    channels = sorted(radio["channel"] for radio in link.statistics()["radios"].values())
    assert 80 in channels
    assert min(b - a for a, b in pairwise(channels)) >= 2
    assert not any(dongle.neighbors for dongle in link.dongles)


def test_a_broadcast_is_sent_once_to_all_and_repeated_for_none():
    link = radios(5, loss=0.3)
    for k in range(400):
        link.broadcast(k / 100, "radio1", bytes(30))
    drain(link, 4.0)
    for drone in link.statistics()["drones"].values():
        assert drone["up"]["sent"] == 400 and drone["up"]["repeated"] == 0
        assert within_binomial(drone["up"]["lost"], 400, 0.3)
    figures = link.statistics()["radios"]["radio1"]
    assert figures["utilization"] == pytest.approx(100 * (0.4e-3 + transmission(30, "2M")), rel=0.01)


# ---------------------------------------------------------------- properties

PACKETS = st.lists(
    st.tuples(
        st.floats(0.0, 0.02),  # after the one before
        st.integers(1, 4),
        st.sampled_from([UP, DOWN]),
        st.integers(1, 31),
        st.booleans(),
    ),
    max_size=40,
)
QUALITIES = st.fixed_dictionaries(
    {
        "loss": st.sampled_from([0.0, 0.2, 0.7, 1.0]),
        "retries": st.integers(0, 3),
        "duplicate": st.sampled_from([0.0, 0.3]),
        "reorder": st.sampled_from([0.0, 0.3]),
        "reliable": st.booleans(),
        "queue": st.integers(1, 8),
        "idle_poll_ms": st.sampled_from([0.0, 10.0]),
        "link_tries": st.integers(1, 30),
        "data_rate": st.sampled_from(["250K", "1M", "2M"]),
        "channel": st.sampled_from([None, 80]),
    }
)


def two_dongles(quality, seed=0):
    configs = [RadioConfig(drones=drones, **quality) for drones in (["cf1", "cf2"], ["cf3"])]
    return SimulatedRadios(configs, ["cf1", "cf2", "cf3", "cf4"], seed)  # no radio serves cf4


def carry(link, packets, asked=()):
    """Send; ask for arrivals at every packet and at further times. Return what arrived, in order."""
    arrived, now = [], 0.0
    asked = sorted(asked, reverse=True)
    for number, (pause, drone, direction, size, droppable) in enumerate(packets):
        now += pause
        while asked and asked[-1] <= now:
            arrived += link.arrivals(asked.pop())
        datagram = number.to_bytes(2, "little")[:size].ljust(size, b"\0")
        link.send(now, f"cf{drone}", direction, datagram, droppable)
    return arrived, now


@given(PACKETS, QUALITIES)
def test_everything_is_accounted_for_and_nothing_is_invented(packets, quality):
    link = two_dongles(quality)
    sent = {(f"cf{d}", direction): [] for d in range(1, 5) for direction in Direction}
    for number, (_, drone, direction, size, _) in enumerate(packets):
        sent[f"cf{drone}", direction].append(number.to_bytes(2, "little")[:size].ljust(size, b"\0"))
    arrived, now = carry(link, packets)
    before = link.statistics()["drones"]
    for drone, figures in before.items():
        for direction in Direction:
            tally = figures[direction.value]
            assert tally["sent"] == len(sent[drone, direction])
            assert tally["sent"] == tally["delivered"] + tally["lost"] + tally["dropped"] + tally["under_way"]
            assert tally["under_way"] >= 0
    arrived += [arrival for _, arrival in drain(link, now)]
    for drone, figures in link.statistics()["drones"].items():
        for direction in Direction:
            tally = figures[direction.value]
            got = [a.datagram for a in arrived if (a.drone, a.direction) == (drone, direction)]
            assert tally["under_way"] == 0
            assert len(got) == tally["delivered"] + tally["duplicated"]
            assert set(got) <= set(sent[drone, direction])
            if quality["loss"] == 0.0 and quality["channel"] is None:
                assert tally["lost"] == 0
            if not quality["reorder"]:
                assert tally["reordered"] == 0


@given(PACKETS, QUALITIES, st.lists(st.floats(0.0, 1.0), max_size=20))
def test_what_arrives_does_not_depend_on_when_somebody_asks(packets, quality, asked):
    one, other = two_dongles(quality), two_dongles(quality)
    first, now = carry(one, packets)
    second, _ = carry(other, packets, asked)
    first += one.arrivals(now + 10.0)
    for step in range(1, 101):
        second += other.arrivals(now + step / 10.0)
    assert first == second
    assert one.statistics()["drones"] == other.statistics()["drones"]


@given(PACKETS, QUALITIES)
def test_nothing_comes_before_it_was_foretold(packets, quality):
    link = two_dongles(quality)
    _, now = carry(link, packets)
    link.arrivals(now)
    for _ in range(20):
        foretold = link.next_arrival()
        if foretold == math.inf:
            break
        assert foretold > now
        before = (now + foretold) / 2.0
        assert link.arrivals(before) == []
        assert link.next_arrival() >= foretold
        now = link.next_arrival()
        link.arrivals(now)


def test_seeds_make_the_difference():
    config = {"loss": 0.3, "retries": 0, "reliable": False}
    one, same, other = (stream(radios(seed=seed, **config), 1, 50, 4) for seed in (1, 1, 2))
    assert one == same
    assert one != other


def test_a_copy_goes_on_as_the_original():
    link = radios(2, loss=0.4, reorder=0.1)
    for k in range(40):
        link.send(k / 1000, f"cf{1 + k % 2}", UP, bytes([k]))
    link.arrivals(0.02)
    other = copy.deepcopy(link)
    assert drain(link, 0.05) == drain(other, 0.05)


# ---------------------------------------------------------------- served drones, and what is shown


@pytest.mark.parametrize(
    ("patterns", "error", "words"),
    [
        ([["cf1"], ["cf*"]], RangeError, r"\[1\]\.drones names 'cf1', but radios\[0\] serves it already"),
        ([["cf9"]], UnknownNameError, r"\[0\]\.drones names 'cf9', but there is no such drone \(did you mean 'cf"),
    ],
)
def test_every_drone_has_one_radio_at_most(patterns, error, words):
    with pytest.raises(error, match=words):
        SimulatedRadios([RadioConfig(drones=drones) for drones in patterns], ["cf1", "cf2"])


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"loss": 1.5}, r"radio: loss is 1.5, allowed: a number in \[0, 1\]"),
        ({"data_rate": "3M"}, "radio: data_rate is '3M', allowed: one of 250K, 1M, 2M"),
        ({"channel": 126}, r"radio: channel is 126, allowed: a whole number in \[0, 125\]"),
        ({"name": ""}, "radio: name is '', allowed: text of 1 to 40 characters"),
        ({"jitter": "gauss"}, "radio: jitter is 'gauss', allowed: one of normal, uniform, exponential"),
    ],
)
def test_impossible_radios_are_refused(values, words):
    with pytest.raises(RangeError, match=words):
        RadioConfig(drones=["cf1"], **values)


def test_bad_packets_and_names_are_refused():
    link = radios()
    with pytest.raises(RangeError, match="a packet of 33 bytes, allowed: 32"):
        link.send(0.0, "cf1", UP, bytes(33))
    with pytest.raises(UnknownNameError, match="no drone named 'cf2', there are: cf1"):
        link.send(0.0, "cf2", UP, bytes(3))
    with pytest.raises(UnknownNameError, match="no radio named 'mine', there are: radio1"):
        link.broadcast(0.0, "mine", bytes(3))


def test_drones_without_a_radio_have_a_perfect_link():
    link = SimulatedRadios([RadioConfig(drones=["cf1"], loss=1.0)], ["cf1", "cf2"])
    link.send(1.0, "cf2", UP, b"12")
    assert [arrival.datagram for arrival in link.arrivals(1.0)] == [b"12"]
    assert link.statistics()["drones"]["cf2"]["radio"] is None


def test_statistics_are_plain_and_make_tables():
    link = radios(2, loss=0.2)
    stream(link, 2, 50, 1, (UP, DOWN))
    statistics = link.statistics()
    assert json.loads(json.dumps(statistics)) == statistics
    page = io.StringIO()
    Console(width=80, file=page).print(link_tables(statistics))
    text = page.getvalue()
    assert "radio1" in text and "80, 2M" in text
    assert "…" not in text  # nothing is cut in a narrow terminal
    assert [line.split()[:3] for line in text.splitlines() if line.startswith(" cf")] == [
        ["cf1", "up", "50"],
        ["cf1", "down", "50"],
        ["cf2", "up", "50"],
        ["cf2", "down", "50"],
    ]


def test_a_perfect_link_counts_nothing():
    assert PerfectLink().statistics() == {"radios": {}, "drones": {}}
