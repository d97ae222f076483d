"""What can be said about one simulated Crazyradio."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from statistics import NormalDist
from typing import Any

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.crtp.link_model.airtime import BITS_PER_SECOND
from crazychoir_fw.simulation.faults.rules import Names, Number, Rule, Switch, Whole, Word, ruled

JITTERS = ("normal", "uniform", "exponential")


class _Label(Rule):
    """What people call something."""

    def __str__(self) -> str:
        return "text of 1 to 40 characters"

    def allows(self, value: Any) -> bool:
        return isinstance(value, str) and 0 < len(value) <= 40 and value.isprintable()


@dataclass(frozen=True, kw_only=True)
class RadioConfig:
    """One Crazyradio and its drones.

    Defaults are those of a dongle at a desk with good reception. Sources: cflib's radio driver for `retries`,
    `link_tries` and `idle_poll_ms`; the firmware for `link_timeout` (docs/reference/crtp-cflib.md#2); the others are
    typical, and adjustable because of that.

    Raises:
        RangeError: If a value is outside its range; the message names member, value and range.
    """

    drones: Sequence[str] = ruled(Names(), MISSING)
    """Ids of its drones, or patterns such as ``cf*`` and ``cf[1-4]``."""

    name: str | None = ruled(_Label(), None)
    """What it is called in statistics; by default ``radio1``, ``radio2``, …"""

    channel: int | None = ruled(Whole(0, 125), None)
    """Radios on one channel disturb each other; at 2M so do neighboring channels. By default one without others."""

    data_rate: str = ruled(Word(tuple(BITS_PER_SECOND)), "2M")
    """Bits per second on the air."""

    turnaround_ms: float = ruled(Number(0.05, 100.0, "ms"), 0.4)
    """Time of USB and host around every exchange with a drone. With 0.4 ms at 2M a dongle echoes 1200 to 1600 packets
    a second, as the system tests of cflib ask for (docs/reference/crtp-cflib.md#23)."""

    latency_ms: float = ruled(Number(0.0, 10000.0, "ms"), 0.5)
    """What else a packet needs one way: threads of the host, and the way between the two processors of the drone."""

    jitter_ms: float = ruled(Number(0.0, 10000.0, "ms"), 0.1)
    """How much that varies: standard deviation, half width or mean, see `jitter`."""

    jitter: str = ruled(Word(JITTERS), "normal")
    """Distribution: `normal` and `uniform` around `latency_ms` and never below zero; `exponential` comes on top."""

    loss: float = ruled(Number(0.0, 1.0), 0.0)
    """Share of the transmissions that do not arrive, before anything is repeated."""

    loss_down: float | None = ruled(Number(0.0, 1.0), None)
    """The same for the answers of the drones; by default `loss`."""

    retries: int = ruled(Whole(0, 15), 3)
    """So often the dongle repeats by itself what is not acknowledged."""

    duplicate: float = ruled(Number(0.0, 1.0), 0.0)
    """Share of the packets that arrive twice."""

    reorder: float = ruled(Number(0.0, 1.0), 0.0)
    """Share of the packets that are held up, so that later ones may overtake them."""

    reorder_ms: float = ruled(Number(0.0, 10000.0, "ms"), 50.0)
    """Such packets are held up for a time between zero and this."""

    queue: int = ruled(Whole(1, 1000), 64)
    """So many packets of one drone may wait one way; then those that may be dropped are (logs, console)."""

    reliable: bool = ruled(Switch(), True)
    """True: as with safelink, a packet is repeated until it is through or the link is lost. False: it is lost for good
    when the dongle has done its `retries`."""

    link_timeout: float = ruled(Number(0.01, 1000.0, "s"), 1.0)
    """A drone that has acknowledged nothing for so long has lost its link (s)."""

    link_tries: int = ruled(Whole(1, 1000000), 100)
    """So many exchanges in a row without an acknowledgment lose the link as well."""

    idle_poll_ms: float = ruled(Number(0.0, 1000.0, "ms"), 0.0)
    """Pause between polls of a drone that had nothing to say. cflib means to make one of 10 ms, but finds a byte in
    every answer and makes none."""

    def __post_init__(self) -> None:
        for member in fields(self):
            value = getattr(self, member.name)
            allowed = refusal_of(member.name, value)
            if allowed is not None:
                raise RangeError(f"radio: {member.name} is {value!r}, allowed: {allowed}")

    @property
    def lost_up(self) -> float:
        """Share of the transmissions to the drones that do not arrive."""
        return self.loss

    @property
    def lost_down(self) -> float:
        """Share of the transmissions of the drones that do not arrive."""
        return self.loss if self.loss_down is None else self.loss_down


def refusal_of(key: str, value: Any) -> str | None:
    """Return what is allowed for a member of `RadioConfig`, or None when *value* is."""
    member = MEMBERS[key]
    rule = member.metadata["rule"]
    return None if (value is None and member.default is None) or rule.allows(value) else str(rule)


MEMBERS: Mapping[str, Any] = {member.name: member for member in fields(RadioConfig)}


_NORMAL = NormalDist()


def draw_delay(config: RadioConfig, source: random.Random) -> float:
    """Return the delay of one packet (s), by the latency and jitter of a radio."""
    latency, jitter = config.latency_ms, config.jitter_ms
    if jitter:
        draw = source.random()
        if config.jitter == "uniform":
            latency += jitter * (2.0 * draw - 1.0)
        elif config.jitter == "exponential":
            latency -= jitter * math.log(1.0 - draw)
        elif draw > 0.0:
            latency += jitter * _NORMAL.inv_cdf(draw)
    return max(latency, 0.0) / 1e3
