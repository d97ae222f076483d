"""What can be said about one simulated Crazyradio."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from statistics import NormalDist
from typing import Any

from pydantic_core import core_schema as schemas

from crazychoir_fw.common.constraints import Constraint, choice, constrained, names, number, refusal_of, switch, whole
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.crtp.link_model.airtime import BITS_PER_SECOND

JITTERS = ("normal", "uniform", "exponential")


def _printable(text: str) -> str:
    if not text.isprintable():
        raise ValueError("not printable")
    return text


_LABEL = Constraint(
    schemas.no_info_after_validator_function(_printable, schemas.str_schema(strict=True, min_length=1, max_length=40)),
    "text of 1 to 40 characters",
)


@dataclass(frozen=True, kw_only=True)
class RadioConfig:
    """One Crazyradio and its drones.

    Defaults are those of a dongle at a desk with good reception. Sources: cflib's radio driver for `retries`,
    `link_tries` and `idle_poll_ms`; the firmware for `link_timeout` (docs/reference/crtp-cflib.md#2); the others are
    typical, and adjustable because of that.

    Raises:
        RangeError: If a value is outside its range; the message names member, value and range.
    """

    drones: Sequence[str] = constrained(names(), MISSING)
    """Ids of its drones, or patterns such as ``cf*`` and ``cf[1-4]``."""

    name: str | None = constrained(_LABEL, None)
    """What it is called in statistics; by default ``radio1``, ``radio2``, …"""

    channel: int | None = constrained(whole(0, 125), None)
    """Radios on one channel disturb each other; at 2M so do neighboring channels. By default one without others."""

    data_rate: str = constrained(choice(*BITS_PER_SECOND), "2M")
    """Bits per second on the air."""

    turnaround_ms: float = constrained(number(0.05, 100.0, "ms"), 0.4)
    """Time of USB and host around every exchange with a drone. With 0.4 ms at 2M a dongle echoes 1200 to 1600 packets
    a second, as the system tests of cflib ask for (docs/reference/crtp-cflib.md#23)."""

    latency_ms: float = constrained(number(0.0, 10000.0, "ms"), 0.5)
    """What else a packet needs one way: threads of the host, and the way between the two processors of the drone."""

    jitter_ms: float = constrained(number(0.0, 10000.0, "ms"), 0.1)
    """How much that varies: standard deviation, half width or mean, see `jitter`."""

    jitter: str = constrained(choice(*JITTERS), "normal")
    """Distribution: `normal` and `uniform` around `latency_ms` and never below zero; `exponential` comes on top."""

    loss: float = constrained(number(0.0, 1.0), 0.0)
    """Share of the transmissions that do not arrive, before anything is repeated."""

    loss_down: float | None = constrained(number(0.0, 1.0), None)
    """The same for the answers of the drones; by default `loss`."""

    retries: int = constrained(whole(0, 15), 3)
    """So often the dongle repeats by itself what is not acknowledged."""

    duplicate: float = constrained(number(0.0, 1.0), 0.0)
    """Share of the packets that arrive twice."""

    reorder: float = constrained(number(0.0, 1.0), 0.0)
    """Share of the packets that are held up, so that later ones may overtake them."""

    reorder_ms: float = constrained(number(0.0, 10000.0, "ms"), 50.0)
    """Such packets are held up for a time between zero and this."""

    queue: int = constrained(whole(1, 1000), 64)
    """So many packets of one drone may wait one way; then those that may be dropped are (logs, console)."""

    reliable: bool = constrained(switch(), True)
    """True: as with safelink, a packet is repeated until it is through or the link is lost. False: it is lost for good
    when the dongle has done its `retries`."""

    link_timeout: float = constrained(number(0.01, 1000.0, "s"), 1.0)
    """A drone that has acknowledged nothing for so long has lost its link (s)."""

    link_tries: int = constrained(whole(1, 1000000), 100)
    """So many exchanges in a row without an acknowledgment lose the link as well."""

    idle_poll_ms: float = constrained(number(0.0, 1000.0, "ms"), 0.0)
    """Pause between polls of a drone that had nothing to say. cflib means to make one of 10 ms, but finds a byte in
    every answer and makes none."""

    def __post_init__(self) -> None:
        for member in fields(self):
            value = getattr(self, member.name)
            if allowed := refusal_of(member, value):
                raise RangeError(f"radio: {member.name} is {value!r}, allowed: {allowed}")

    @property
    def lost_up(self) -> float:
        """Share of the transmissions to the drones that do not arrive."""
        return self.loss

    @property
    def lost_down(self) -> float:
        """Share of the transmissions of the drones that do not arrive."""
        return self.loss if self.loss_down is None else self.loss_down


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
