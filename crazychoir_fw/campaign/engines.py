"""Where the flights of a campaign are flown: in worker processes here, or by a Ray cluster (`ray_engine`)."""

from __future__ import annotations

import multiprocessing as mp
import os
import signal
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from typing import Any, TypeAlias

from crazychoir_fw.campaign.campaign import Job
from crazychoir_fw.campaign.flight import CRASHED, Record, fly_job
from crazychoir_fw.common.kept_memory import keep_freed_memory
from crazychoir_fw.common.parent_death import end_with_parent

Task: TypeAlias = "tuple[Job, Mapping[str, Any]]"
Engine: TypeAlias = "Callable[[Iterable[Task]], Iterator[Record]]"
"""Flies tasks and hands out records as they come, in any order; closing it ends the flights on their way."""

MAX_ATTEMPTS = 3
"""So many workers may die of a flight."""


def here(tasks: Iterable[Task]) -> Iterator[Record]:
    """Fly one after the other in this process."""
    for job, values in tasks:
        yield fly_job(job, values)


@dataclass
class _Worker:
    """A process, and what it flies."""

    process: mp.process.BaseProcess
    line: Connection
    task: Task | None = None


class Processes:
    """Flies in worker processes; one that dies is replaced, and its flight tried again. They live until `close`."""

    def __init__(self, count: int) -> None:
        """Choose how many."""
        self._count = count
        self._context = mp.get_context("spawn")  # fork would copy threads of MuJoCo and NumPy
        self._workers: list[_Worker] = []

    def __enter__(self) -> Processes:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def close(self) -> None:
        """End all workers."""
        for worker in self._workers:
            worker.process.terminate()
        for worker in self._workers:
            _bury(worker)
        self._workers.clear()

    def __call__(self, tasks: Iterable[Task]) -> Iterator[Record]:
        """See `Engine`."""
        waiting = iter(tasks)
        again: list[Task] = []
        attempts: dict[int, int] = {}
        workers = self._workers
        try:
            workers += [self._hire() for _ in range(self._count - len(workers))]
            for worker in workers:
                _hand_out(worker, again, waiting)
            while busy := [worker for worker in workers if worker.task is not None]:
                ready = wait([worker.line for worker in busy])
                for k, worker in enumerate(workers):
                    task = worker.task
                    if worker.line not in ready or task is None:
                        continue
                    try:
                        record, worker.task = worker.line.recv(), None
                        yield record
                    except (EOFError, OSError):  # it died, and its end of the line with it
                        code = _bury(worker)
                        workers[k] = worker = self._hire()
                        number = task[0].number
                        attempts[number] = attempts.get(number, 0) + 1
                        if attempts[number] < MAX_ATTEMPTS:
                            again.append(task)
                        else:
                            sentence = f"{MAX_ATTEMPTS} workers died of it, the last one with code {code}"
                            yield Record(number, CRASHED, dict(task[1]), failures=(sentence,))
                    _hand_out(worker, again, waiting)
        finally:
            for worker in [worker for worker in workers if worker.task is not None]:  # their results are dropped
                workers.remove(worker)
                worker.process.terminate()
                _bury(worker)

    def _hire(self) -> _Worker:
        line, end = self._context.Pipe()
        process = self._context.Process(target=_work, args=(end, os.getpid()), daemon=True)
        # Ctrl-C reaches all processes of a terminal, also one that still imports; the parent decides
        resource_tracker.ensure_running()  # its start would lift the mask
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            process.start()  # with the mask of this thread
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        end.close()
        return _Worker(process, line)


def _hand_out(worker: _Worker, again: list[Task], waiting: Iterator[Task]) -> None:
    task = again.pop() if again else next(waiting, None)
    if task is not None:
        worker.task = task
        worker.line.send(task)


def _bury(worker: _Worker) -> int | None:
    worker.line.close()
    worker.process.join(timeout=5.0)
    return worker.process.exitcode


def _work(line: Connection, parent: int) -> None:
    """Fly what comes down the line, in a process of its own, which ends with its parent."""
    end_with_parent(parent)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all processes of a terminal; the parent decides
    keep_freed_memory()
    while True:
        try:
            job, values = line.recv()
        except EOFError:
            return
        line.send(fly_job(job, values))
