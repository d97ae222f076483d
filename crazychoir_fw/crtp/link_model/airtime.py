"""How long a Crazyradio takes for what it does.

The radio chip speaks Enhanced ShockBurst: the dongle sends a packet, the drone answers with an acknowledgment that
carries a packet of its own, and what is not acknowledged is sent again. The format of the frames is general knowledge
of that protocol; what is not is marked *typical*, and adjustable in `RadioConfig` or here.
"""

from __future__ import annotations

BITS_PER_SECOND = {"250K": 250e3, "1M": 1e6, "2M": 2e6}

FRAME_BITS = 8 * (1 + 5 + 2) + 9
"""Around the payload: preamble, address of 5 bytes, checksum of 2, and 9 bits of control field."""

SETTLE_S = 130e-6
"""Time of the chip from receiving to sending and back (s)."""

LARGEST_BYTES = 32
"""Largest payload of a frame: an acknowledgment is waited for as long as one of this size would take (typical)."""

NULL_BYTES = 1
"""A null packet of the client, and the answer of a drone with nothing to say (typical: cflib finds a byte in it)."""


def transmission(payload_bytes: float, data_rate: str) -> float:
    """Return how long a frame with so many bytes is on the air (s)."""
    return (FRAME_BITS + 8 * payload_bytes) / BITS_PER_SECOND[data_rate]


def failed_try(up_bytes: float, data_rate: str) -> float:
    """Return how long a try takes that is not acknowledged (s)."""
    return transmission(up_bytes, data_rate) + SETTLE_S + transmission(LARGEST_BYTES, data_rate)


def good_try(up_bytes: float, down_bytes: float, data_rate: str) -> float:
    """Return how long a try takes that is acknowledged (s)."""
    return transmission(up_bytes, data_rate) + SETTLE_S + transmission(down_bytes, data_rate)
