"""Does it still fly with so many drones on one radio? An estimate from the figures of the radio, without a simulation.

A dongle asks its drones in turn, so that every drone has its turn once per *cycle*, and one packet may go each way in
it. The cycle is the longer the more drones there are and the more they have to say. What follows from that:

    cycle = n (mean duration of an exchange, given how probable it is that there is a packet to carry)
    P(packet waits for the drone) = packets per second * cycle

This is solved for the cycle. A packet waits between zero and one cycle for its turn, and another one for every time
that its exchange fails. The simulated radio agrees (`tests/crtp/link_model/test_budget.py`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.crtp.link_model.airtime import NULL_BYTES, failed_try, good_try, transmission
from crazychoir_fw.crtp.link_model.config import RadioConfig

SETPOINT_BYTES = 18
"""A position setpoint with its header; a full state has 30."""

LOG_BYTES = 31
"""A full log packet with its header."""

PING_RATE = 10.0
"""So often cflib asks a connected drone for an echo (Hz), docs/reference/crtp-cflib.md#3.3; 10 bytes both ways."""

COMFORTABLE = 0.7
"""Share of its turns that a drone may use; above it, every burst makes a queue."""

ROUNDS = 60


@dataclass(frozen=True)
class LogBlock:
    """A stream of log packets from each drone."""

    rate_hz: float
    packet_bytes: int = LOG_BYTES


@dataclass(frozen=True)
class Budget:
    """What one radio makes of its drones."""

    drones: int
    cycle_ms: float
    """From one turn of a drone to its next, on average."""

    utilization: float
    """Share of its turns that a drone needs, the larger of both directions; from 1 on, queues grow without end."""

    busy: float
    """Share of the time in exchanges that carry a packet (`utilization` of `SimulatedRadios.statistics`)."""

    up_mean_ms: float
    """Mean time from a setpoint's sending to its arrival; infinite when it does not fit."""

    up_p95_ms: float
    """Time that 95 % of the setpoints do not exceed."""

    down_mean_ms: float
    """Mean time of a log packet."""

    lost: float
    """Share of the setpoints that never arrive: none on a reliable link, unless it is lost."""

    @property
    def verdict(self) -> str:
        """`fits`, `tight` or `too much`."""
        if self.utilization >= 1.0:
            return "too much"
        return "fits" if self.utilization <= COMFORTABLE else "tight"


def budget(
    config: RadioConfig,
    drones: int,
    setpoint_hz: float = 10.0,
    setpoint_bytes: int = SETPOINT_BYTES,
    logs: Sequence[LogBlock] = (),
    poses_hz: float = 0.0,
    ping_hz: float = PING_RATE,
) -> Budget:
    """Estimate how a radio copes.

    Args:
        config: The radio; its `drones` do not matter here.
        drones: Number of drones that share it.
        setpoint_hz: Setpoints per second to each drone.
        setpoint_bytes: Size of their packets.
        logs: Streams of log packets from each drone.
        poses_hz: External poses (30 bytes) per second to each drone.
        ping_hz: Echoes per second of each drone.

    Raises:
        RangeError: If there is no drone, or a rate is negative.
    """
    rates = [setpoint_hz, poses_hz, ping_hz, *(block.rate_hz for block in logs)]
    if drones < 1 or not all(0.0 <= rate < math.inf for rate in rates):
        raise RangeError(f"budget of {drones} drones with rates {rates} Hz, allowed: 1 or more, 0 Hz or more")
    up = _Stream([(setpoint_hz, setpoint_bytes), (poses_hz, 30), (ping_hz, 10)])
    down = _Stream([*((block.rate_hz, block.packet_bytes) for block in logs), (ping_hz, 10)])
    failing = _Failing(config)

    cycle = drones * failing.duration(NULL_BYTES, NULL_BYTES)
    busy = 0.0
    for _ in range(ROUNDS):
        has_up = min(up.rate * failing.turns_up * cycle, 1.0)
        has_down = min(down.rate * failing.turns_down * cycle, 1.0)
        cycle, busy = _cycle(failing, drones, (has_up, up.bytes), (has_down, down.bytes))
    up_cycle = cycle
    pause = config.idle_poll_ms / 1e3
    if pause > cycle:
        # the dongle rests, begins at once when there is something to send, and hears of the rest when it asks
        going_up = up.rate * failing.turns_up * failing.duration(up.bytes, NULL_BYTES)
        busy = drones * (going_up + down.rate * failing.turns_down * failing.duration(NULL_BYTES, down.bytes))
        up_cycle = cycle * cycle / pause
        cycle = pause

    half_turn = config.turnaround_ms / 2e3
    tried = failing.tries_before_heard * failed_try(up.bytes, config.data_rate)
    to_drone = half_turn + tried + transmission(up.bytes, config.data_rate) + config.latency_ms / 1e3
    to_host = failing.duration(NULL_BYTES, down.bytes) - half_turn + config.latency_ms / 1e3
    utilization = max(up.rate * failing.turns_up, down.rate * failing.turns_down) * cycle
    failing_up = failing.unheard if config.reliable else 0.0
    failing_down = 1.0 - 1.0 / failing.turns_down
    before_up, before_down = up.is_before(up_cycle * failing.turns_up), down.is_before(cycle * failing.turns_down)
    if utilization >= 1.0 or failing.never:
        up_mean = up_p95 = down_mean = math.inf
    else:
        up_mean = up_cycle * (0.5 + failing_up / (1.0 - failing_up) + before_up) + to_drone
        up_p95 = up_cycle * _cycles_waited(0.95, failing_up, before_up) + to_drone
        down_mean = cycle * (0.5 + failing_down / (1.0 - failing_down) + before_down) + to_host
    lost = 0.0 if config.reliable and not failing.never else failing.unheard
    return Budget(drones, 1e3 * cycle, utilization, busy, 1e3 * up_mean, 1e3 * up_p95, 1e3 * down_mean, lost)


class _Stream:
    """All packets of a drone in one direction: how many per second, and how long on average."""

    def __init__(self, parts: Sequence[tuple[float, int]]) -> None:
        self.rate = sum(rate for rate, _ in parts)
        self.bytes = sum(rate * size for rate, size in parts) / self.rate if self.rate else float(NULL_BYTES)
        self._others = sum(rate * (self.rate - rate) for rate, _ in parts) / self.rate if self.rate else 0.0

    def is_before(self, cycle: float) -> float:
        """Return how probable it is that a packet of another stream takes the turn of one; `cycle` in s."""
        return min(self._others * cycle / 2.0, 1.0)


class _Failing:
    """How often exchanges fail, and what that costs."""

    def __init__(self, config: RadioConfig) -> None:
        self._config = config
        tries = 1 + config.retries
        lost = 1.0 - (1.0 - config.lost_up) * (1.0 - config.lost_down)  # of one try
        self.unacknowledged = lost**tries
        self.unheard = config.lost_up**tries
        self.failed_tries = sum(lost**k for k in range(1, tries + 1))
        self.never = self.unacknowledged >= 1.0
        """Whether no exchange succeeds, so that every link is lost."""
        heard = [(1.0 - config.lost_up) * config.lost_up**k for k in range(tries)]
        self.tries_before_heard = sum(k * p for k, p in enumerate(heard)) / sum(heard) if sum(heard) else 0.0
        self.turns_up = 1.0 / (1.0 - self.unacknowledged) if config.reliable and not self.never else 1.0
        """Exchanges that a packet to a drone needs."""
        # what a drone has to say waits until the drone is asked, on any link
        staying = self.unacknowledged if config.reliable else self.unheard
        self.turns_down = 1.0 / (1.0 - staying) if staying < 1.0 else 1.0
        """Exchanges that a packet of a drone needs."""

    def duration(self, up_bytes: float, down_bytes: float) -> float:
        """Return how long an exchange takes on average (s)."""
        rate = self._config.data_rate
        failed = self.failed_tries * failed_try(up_bytes, rate)
        good = (1.0 - self.unacknowledged) * good_try(up_bytes, down_bytes, rate)
        return self._config.turnaround_ms / 1e3 + failed + good


def _cycle(failing: _Failing, drones: int, up: tuple[float, float], down: tuple[float, float]) -> tuple[float, float]:
    """Return the duration of a cycle (s), and the share of it in exchanges that carry something.

    Args:
        failing: What fails.
        drones: Number of drones.
        up: How probable it is that a packet waits for a drone, and its bytes.
        down: The same for what a drone has to say.
    """
    (has_up, up_bytes), (has_down, down_bytes) = up, down
    nothing = (1.0 - has_up) * (1.0 - has_down) * failing.duration(NULL_BYTES, NULL_BYTES)
    carried = (
        has_up * has_down * failing.duration(up_bytes, down_bytes)
        + has_up * (1.0 - has_down) * failing.duration(up_bytes, NULL_BYTES)
        + (1.0 - has_up) * has_down * failing.duration(NULL_BYTES, down_bytes)
    )
    return drones * (carried + nothing), carried / (carried + nothing)


def _cycles_waited(share: float, failing: float, before: float) -> float:
    """Return so many cycles that this share of the packets does not wait longer.

    A packet waits a part of a cycle, evenly spread between zero and one; with the probability `before` it is the later
    of two in its cycle, and waits for the next turn; and every turn fails with the probability `failing`.
    """
    most = 2.0 + (math.log(1e-6) / math.log(failing) if failing > 0.0 else 0.0)
    failures = [(turn, failing**turn * (1.0 - failing)) for turn in range(int(most))]
    low, high = 0.0, most
    for _ in range(ROUNDS):
        middle = (low + high) / 2.0
        if sum(chance * _waits_longer(middle - turn, before) for turn, chance in failures) > 1.0 - share:
            low = middle
        else:
            high = middle
    return high


def _waits_longer(cycles: float, before: float) -> float:
    """Return the share of the packets that wait longer than so many cycles, as long as nothing fails."""
    if cycles >= 1.0:
        return before * max(2.0 - cycles, 0.0) ** 2  # the later of two is nearer to the first turn
    first = 1.0 - max(cycles, 0.0)
    return before + (1.0 - before) * first if cycles > 0.0 else 1.0
