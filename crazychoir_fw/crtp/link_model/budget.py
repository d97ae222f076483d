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

from crazychoir_fw.crtp.link_model.airtime import NULL_BYTES, failed_try, good_try, transmission
from crazychoir_fw.crtp.link_model.config import RadioConfig
from crazychoir_fw.errors import RangeError

SETPOINT_BYTES = 18
"""A position setpoint with its header; a full state has 30."""

LOG_BYTES = 31
"""A full log packet with its header."""

PING_RATE = 10.0
"""So often cflib asks a connected drone for an echo (Hz), crtp-cflib dossier section 3.3; 10 bytes both ways."""

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
    has_up = has_down = busy = 0.0
    for _ in range(ROUNDS):
        has_up = min(up.rate * failing.turns * cycle, 1.0)
        has_down = min(down.rate * failing.turns * cycle, 1.0)
        cycle, busy = _cycle(config, failing, drones, (has_up, up.bytes), (has_down, down.bytes))
    utilization = max(up.rate, down.rate) * failing.turns * cycle

    half_turn = config.turnaround_ms / 2
    air = 1e3 * transmission(round(up.bytes), config.data_rate)
    down_air = 1e3 * (failing.duration(NULL_BYTES, round(down.bytes))) - half_turn
    fits = utilization < 1.0
    to_drone = half_turn + air + 1e3 * failing.tries_before_heard * failed_try(round(up.bytes), config.data_rate)
    ways = config.latency_ms
    cycle_ms = 1e3 * cycle
    again = failing.unheard if config.reliable else 0.0
    again_down = failing.unacknowledged if config.reliable else 0.0
    return Budget(
        drones,
        cycle_ms,
        utilization,
        busy,
        cycle_ms * (0.5 + again / (1.0 - again)) + to_drone + ways if fits and again < 1.0 else math.inf,
        cycle_ms * _waiting(0.95, again) + to_drone + ways if fits and again < 1.0 else math.inf,
        cycle_ms * (0.5 + again_down / (1.0 - again_down)) + down_air + ways
        if fits and again_down < 1.0
        else math.inf,
        0.0 if config.reliable and failing.unheard < 1.0 else failing.unheard,
    )


class _Stream:
    """All packets of a drone in one direction: how many per second, and how long on average."""

    def __init__(self, parts: Sequence[tuple[float, int]]) -> None:
        self.rate = sum(rate for rate, _ in parts)
        self.bytes = sum(rate * size for rate, size in parts) / self.rate if self.rate else float(NULL_BYTES)


class _Failing:
    """How often exchanges fail, and what that costs."""

    def __init__(self, config: RadioConfig) -> None:
        self._config = config
        tries = 1 + config.retries
        lost = 1.0 - (1.0 - config.lost_up) * (1.0 - config.lost_down)  # of one try
        self.unacknowledged = lost**tries
        self.unheard = config.lost_up**tries
        self.failed_tries = sum(lost**k for k in range(1, tries + 1))
        heard = [(1.0 - config.lost_up) * config.lost_up**k for k in range(tries)]
        self.tries_before_heard = sum(k * p for k, p in enumerate(heard)) / sum(heard) if sum(heard) else 0.0
        is_repeated = config.reliable and self.unacknowledged < 1.0
        self.turns = 1.0 / (1.0 - self.unacknowledged) if is_repeated else 1.0
        """Exchanges that a packet needs."""

    def duration(self, up_bytes: int, down_bytes: int) -> float:
        """Return how long an exchange takes on average (s)."""
        rate = self._config.data_rate
        failed = self.failed_tries * failed_try(up_bytes, rate)
        good = (1.0 - self.unacknowledged) * good_try(up_bytes, down_bytes, rate)
        return self._config.turnaround_ms / 1e3 + failed + good


def _cycle(
    config: RadioConfig, failing: _Failing, drones: int, up: tuple[float, float], down: tuple[float, float]
) -> tuple[float, float]:
    """Return the duration of a cycle (s), and the share of it in exchanges that carry something."""
    carried = nothing = 0.0
    for has_up, up_bytes in (up, (1.0 - up[0], -1.0)):
        for has_down, down_bytes in (down, (1.0 - down[0], -1.0)):
            share = has_up * has_down
            sizes = [NULL_BYTES if size < 0 else round(size) for size in (up_bytes, down_bytes)]
            seconds = share * failing.duration(*sizes)
            if up_bytes < 0 and down_bytes < 0:
                nothing += seconds
            else:
                carried += seconds
    cycle = drones * (carried + nothing)
    busy = carried / (carried + nothing)
    pause = config.idle_poll_ms / 1e3
    if pause > cycle:
        # drones with nothing to say are not asked all the time, and the dongle rests
        busy *= cycle / pause
        cycle = pause
    return cycle, busy


def _waiting(share: float, again: float) -> float:
    """Return so many cycles that this share of the packets does not wait longer.

    A packet waits a part of a cycle, evenly spread between zero and one, and one more cycle with probability `again`
    every time.
    """
    left = 1.0 - share
    whole = 0
    while again ** (whole + 1) > left:
        whole += 1
    at_least = again**whole
    return whole + (1.0 if again == 1.0 else min(1.0, (at_least - left) / (at_least * (1.0 - again))))
