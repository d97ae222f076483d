"""UDP sockets: one per drone, on consecutive ports."""

from __future__ import annotations

import errno
import socket
import struct
from contextlib import suppress

from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.crtp.client_session import Address

RECEIVE_BUFFER_BYTES = 1 << 20
"""A burst of all clients at once; the usual buffer holds 256 packets (docs/reference/crtp-cflib.md#3.4)."""
MAX_PORT = 65535

LONGEST = 64
"""Bytes: more than a packet has; what is longer is no packet, and the rest of it is not wanted."""

_IP_RECVERR = 11  # Linux; the module socket names it in newer versions only
_MAX_REFUSALS = 16  # read at once


def open_sockets(host: str, port: int, count: int) -> list[socket.socket]:
    """Bind a socket per drone, to `port` and those after it; port 0 takes any free ones.

    Raises:
        RangeError: If there are not so many ports, or the host is none of this machine.
        StateError: If a port is taken.
    """
    if not (isinstance(port, int) and not isinstance(port, bool) and port >= 0 and port + count - 1 <= MAX_PORT):
        raise RangeError(f"port {port!r} for {count} drones, allowed: 0 (any free ones) or 1 to {MAX_PORT + 1 - count}")
    opened: list[socket.socket] = []
    try:
        for number in range(count):
            opened.append(_open(host, port + number if port else 0))
    except BaseException:
        for one in opened:
            one.close()
        raise
    return opened


def _open(host: str, port: int) -> socket.socket:
    opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        opened.setblocking(False)
        opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
        opened.bind((host, port))
    except OSError as error:
        opened.close()
        if error.errno == errno.EADDRINUSE:
            raise StateError(
                f"port {port} of {host} is taken, perhaps by another server; another --port or port= helps"
            ) from None
        if error.errno == errno.EACCES:
            raise StateError(f"port {port} of {host} is not for everybody: {error.strerror}") from None
        raise RangeError(f"host '{host}' cannot be served from: {error.strerror or error}") from None
    with suppress(OSError):
        # Linux: the socket hears of clients that are gone; elsewhere a second of silence tells
        opened.setsockopt(socket.IPPROTO_IP, _IP_RECVERR, 1)
    return opened


def open_private(opened: socket.socket, client: Address) -> socket.socket | None:
    """Return a second socket at the port of an open one that hears one client only, or None where that cannot be.

    What others send does not fill its buffer, so that no flood drowns the client's packets.
    """
    private = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        private.setblocking(False)
        private.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
        private.setsockopt(socket.IPPROTO_IP, _IP_RECVERR, 1)
        for one in (opened, private):
            one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        private.bind(opened.getsockname())
        private.connect(client)
    except OSError:
        private.close()
        return None
    finally:
        # the port is for no other process
        with suppress(OSError):
            opened.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 0)
    return private


def turn_to(private: socket.socket, client: Address | None) -> bool:
    """Have a private socket hear another client, or none. Returns False where it has to be opened again.

    It is not closed: with a socket goes what has come to it meanwhile, and that may be the request of a client that
    asks once. What had come is read later, with its sender.
    """
    try:
        # at its own address there is no client
        private.connect(client or private.getsockname())
    except OSError:
        return False
    return True


def is_for_one_address(opened: socket.socket) -> bool:
    """Tell whether a socket is bound to one address of this machine: only then can a private one change its client."""
    return bool(opened.getsockname()[0] != "0.0.0.0")


def receive(opened: socket.socket) -> tuple[bytes, Address] | None:
    """Return a datagram, cut off where it is too long for a packet, and its sender; None when there is none.

    Raises:
        ConnectionError: When there are refusals to be read.
    """
    try:
        return opened.recvfrom(LONGEST)
    except (BlockingIOError, InterruptedError):
        return None


def read_refusals(opened: socket.socket) -> list[Address]:
    """Return the clients whose sockets are closed, as the operating system says."""
    gone: list[Address] = []
    flag = getattr(socket, "MSG_ERRQUEUE", None)
    if flag is None:
        return gone
    for _ in range(_MAX_REFUSALS):
        try:
            _, about, _, address = opened.recvmsg(LONGEST, 256, flag)
        except OSError:
            break
        for level, kind, details in about:
            is_error = (level, kind) == (socket.IPPROTO_IP, _IP_RECVERR) and len(details) >= 4
            if is_error and struct.unpack_from("=I", details)[0] == errno.ECONNREFUSED:
                gone.append(address)
    return gone
