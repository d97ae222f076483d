"""How late a packet is that has left the air, by what hosts and processors need."""

from __future__ import annotations

import math
import random
from statistics import NormalDist

from crazychoir_fw.crtp.link_model.config import RadioConfig

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
