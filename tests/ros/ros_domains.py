"""ROS domains, so that tests beside each other do not hear each other."""

import fcntl
import os
import tempfile
import zlib
from pathlib import Path

DOMAINS = range(1, 100)  # above, ports meet those that Linux hands out

_LOCKS = []  # open files: a domain is ours as long as this process lives


def reserve_domain() -> int:
    """Return a ROS domain that no other test process has; it is free again when this process ends.

    The first one tried follows from worker and process number.
    """
    folder = Path(tempfile.gettempdir()) / f"ros_domains_of_tests.{os.getuid()}"
    folder.mkdir(exist_ok=True)
    first = zlib.crc32(f"{os.environ.get('PYTEST_XDIST_WORKER', '')} {os.getpid()}".encode())
    for k in range(len(DOMAINS)):
        domain = DOMAINS[(first + k) % len(DOMAINS)]
        # each reservation opens the file again, so that a domain is not reserved twice in one process either
        lock = (folder / str(domain)).open("w")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            lock.close()
            continue
        _LOCKS.append(lock)
        return domain
    raise RuntimeError("all ROS domains are taken by other tests")
