"""Neighboring ports for servers of tests."""

import os
import socket

_FIRST, _PER_WORKER = 20000, 1000  # below those that the system gives out by itself


def free_ports(count):
    """Return the first of `count` consecutive free UDP ports; each worker of pytest gets other ports."""
    worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0")[2:]) % 10
    begin = _FIRST + worker * _PER_WORKER
    for first in range(begin, begin + _PER_WORKER - count, count):
        sockets = []
        try:
            for port in range(first, first + count):
                sockets.append(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
                sockets[-1].bind(("127.0.0.1", port))
        except OSError:
            continue
        else:
            return first
        finally:
            for one in sockets:
                one.close()
    raise RuntimeError(f"no {count} neighboring ports are free from {begin} on")
