"""Packets for the decoders: bytes from hexadecimal text, and what comes out of a decoder."""

import struct

from crazychoir_fw._core import ffi, lib

BAD_FLOATS = [bytes.fromhex(text) for text in ("0000c07f", "0000807f", "000080ff", "0100807f", "ffffffff")]


def floats(*values: float) -> bytes:
    """Return little-endian float32 numbers."""
    return struct.pack(f"<{len(values)}f", *values)


def decode(function, result, *arguments, data: bytes) -> int:
    """Call a decoder whose last arguments are data and length; the data stands at the end of its memory."""
    block = ffi.new("uint8_t[]", data) if data else ffi.NULL
    return function(result, *arguments, block, len(data)) if result is not None else function(block, len(data))


def refusals(good: bytes) -> list[bytes]:
    """Return a packet cut at every place, and one that is too long."""
    return [good[:length] for length in range(len(good))] + [good + b"\0"]


def reply_of(reply) -> bytes:
    """Return the answer in a cf_packet_reply_t."""
    return bytes(reply.data[0 : reply.length])


def new_reply():
    """Return an empty answer."""
    return ffi.new("cf_packet_reply_t *")


OK, VALUE, UNKNOWN, STATE = lib.CF_OK, lib.CF_ERR_VALUE, lib.CF_ERR_UNKNOWN, lib.CF_ERR_STATE
