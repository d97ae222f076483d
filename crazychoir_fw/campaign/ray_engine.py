"""The flights of a campaign on a Ray cluster (Ray Core). Flights are the unit, and their files travel as a bundle.

What Ray sends between its processes is pickled by Ray: clusters belong into private networks (docs/campaign.md).
"""

from __future__ import annotations

import json
import socket
from collections.abc import Iterable, Iterator
from dataclasses import asdict
from itertools import chain, islice
from typing import TYPE_CHECKING, Any

from crazychoir_fw.campaign.bundle import Bundle, pack
from crazychoir_fw.campaign.campaign import Job
from crazychoir_fw.campaign.engines import MAX_ATTEMPTS, Task
from crazychoir_fw.campaign.flight import CRASHED, Record, fly_job
from crazychoir_fw.common.errors import MissingLibraryError, StateError
from crazychoir_fw.common.kept_memory import keep_freed_memory

if TYPE_CHECKING:
    from crazychoir_fw.campaign.campaign import Campaign

LOCAL = "local"
"""Address of a cluster that is started here."""
_PATIENCE_S = 5.0
_HIGHEST_PORT = 65535
_BATCH = 4  # flights of a task: a task costs a millisecond or two
_PER_CPU = 3  # tasks on their way, for each processor of the cluster


class RayEngine:
    """Flies on a cluster; a node that is lost takes no flight along: Ray gives it to another one."""

    def __init__(self, address: str, campaign: Campaign) -> None:
        """Choose the cluster: its address, ``auto`` for one of this machine, or `LOCAL`."""
        self._address = address
        self._campaign = campaign

    def __enter__(self) -> RayEngine:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def close(self) -> None:
        """Workers belong to the cluster: there is nothing to end."""

    def __call__(self, tasks: Iterable[Task]) -> Iterator[Record]:
        """See `Engine`.

        Raises:
            MissingLibraryError: If Ray is not installed.
            StateError: If there is no such cluster.
        """
        ray = _ray()
        was_ready = ray.is_initialized()
        if not was_ready:
            _connect(ray, self._address)
        try:
            yield from self._fly(ray, iter(tasks))
        finally:
            if not was_ready:
                ray.shutdown()

    def _fly(self, ray: Any, tasks: Iterator[Task]) -> Iterator[Record]:
        campaign = self._campaign
        files = [campaign.file, campaign.mission_file]
        first = next(tasks, None)
        if first is None:
            return
        files += [type(campaign.file)(file) for file in first[0].app or ()]
        bundle = ray.put(asdict(pack(files)))
        remote = ray.remote(max_retries=MAX_ATTEMPTS - 1, num_cpus=1)(fly_batch)
        waiting: dict[Any, list[Task]] = {}
        pending = chain([first], tasks)
        more = True
        try:
            while more or waiting:
                limit = _PER_CPU * max(1, int(ray.cluster_resources().get("CPU", 1)))
                while more and len(waiting) < limit:
                    batch = list(islice(pending, _BATCH))
                    more = len(batch) == _BATCH
                    if batch:
                        texts = [json.dumps([asdict(job), values]) for job, values in batch]
                        waiting[remote.remote(bundle, texts)] = batch
                if not waiting:
                    return
                done, _ = ray.wait(list(waiting), num_returns=1)
                yield from _records(ray, done[0], waiting.pop(done[0]))
        finally:
            for reference in waiting:
                ray.cancel(reference, force=True)


def _records(ray: Any, reference: Any, batch: list[Task]) -> Iterator[Record]:
    """Return the records of a batch; those of one that Ray gave up are crashes."""
    try:
        texts = ray.get(reference)
    except ray.exceptions.RayError as error:
        sentence = f"the cluster gave it up after {MAX_ATTEMPTS} attempts: {type(error).__name__}"
        for job, values in batch:
            yield Record(job.number, CRASHED, dict(values), failures=(sentence,))
        return
    for text in texts:
        given = json.loads(text)
        yield Record(**{**given, "failures": tuple(given["failures"])})


def fly_batch(bundle: dict[str, Any], texts: list[str]) -> list[str]:
    """Fly flights on a worker of the cluster; plain data in and out."""
    keep_freed_memory()
    files = Bundle(**bundle)
    folder, found = files.unpack(), []
    for text in texts:
        given, values = json.loads(text)
        app = None if given["app"] is None else tuple(given["app"])
        job = Job(**{**given, "changes": tuple(given["changes"]), "app": app})
        found.append(json.dumps(asdict(fly_job(files.moved(job, folder), values))))
    return found


def _ray() -> Any:
    try:
        import ray
    except ImportError:
        raise MissingLibraryError("--ray needs Ray: pip install 'crazychoir-fw[ray]'") from None
    return ray


def _check_address(address: str) -> None:
    """Refuse an address at which nothing listens: Ray itself would try for minutes.

    Raises:
        StateError: If there is no such cluster.
    """
    host, colon, port = address.removeprefix("ray://").rpartition(":")
    if not colon or not port.isdecimal() or int(port) > _HIGHEST_PORT:
        raise StateError(f"--ray is {address}, but must be HOST:PORT, ray://HOST:PORT, auto or {LOCAL}")
    try:
        socket.create_connection((host, int(port)), timeout=_PATIENCE_S).close()
    except OSError as error:
        raise StateError(f"--ray {address}: no cluster answers there: {error.strerror or error}") from None


def _connect(ray: Any, address: str) -> None:
    if address not in (LOCAL, "auto"):
        _check_address(address)
    try:
        ray.init(
            address=None if address == LOCAL else address,
            include_dashboard=False if address == LOCAL else None,
            logging_level="ERROR",
            log_to_driver=False,
        )
    except (ConnectionError, ValueError, RuntimeError) as error:
        raise StateError(f"--ray {address}: {str(error).splitlines()[0][:200]}") from None
