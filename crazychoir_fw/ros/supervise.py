"""Supervised processes: started by fork, so that a hundred of them start in seconds, and never orphaned.

The supervising process imports the modules that its processes need, and starts no threads; a fork copies its memory.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime
from multiprocessing import connection, get_context
from pathlib import Path
from typing import Any

from honcho.colour import get_colours
from honcho.printer import Message, Printer

from crazychoir_fw.common.parent_death import end_with_parent
from crazychoir_fw.common.replacing import replacing

LANDING_S = 15.0
"""Longest time that the process of the drones may take to land them (s)."""

_FORK: Any = get_context("fork")


@dataclass
class Child:
    """One process."""

    name: str
    work: Callable[[], int | None]
    """Main function; returns the exit code."""
    colour: str
    captured: bool = True
    process: Any = None
    output: Any = None
    """Reading end of the pipe with its output; None without one."""
    starts: int = 0
    unread: bytes = b""
    ended: bool = False

    @property
    def is_alive(self) -> bool:
        """Whether it runs."""
        return self.process is not None and not self.ended


@dataclass
class Supervisor:
    """Starts processes, prints their output under their names, and reports those that end."""

    quiet: bool = False
    """Whether to print no output of processes, but only their ends."""
    children: dict[str, Child] = field(default_factory=dict)
    register: Path | None = None
    """File (JSON) that maps names to process ids; None writes none."""

    def __post_init__(self) -> None:
        self._colours = get_colours()
        self._printer = Printer(sys.stdout)

    def start(self, name: str, work: Callable[[], int | None], captured: bool = True) -> Child:
        """Start a process.

        Args:
            name: Name of the process in the output.
            work: Main function; returns the exit code.
            captured: Whether its output goes through the supervisor; otherwise it has the terminal.
        """
        child = Child(name, work, next(self._colours), captured)
        self.children[name] = child
        self._printer.width = max(self._printer.width, len(name))
        self._begin(child)
        return child

    def restart(self, name: str) -> None:
        """Start a process again that has ended."""
        self._begin(self.children[name])

    def _begin(self, child: Child) -> None:
        sys.stdout.flush()
        sys.stderr.flush()
        reading, writing = os.pipe() if child.captured else (None, None)
        child.process = _FORK.Process(target=_run, args=(child.work, writing, reading, os.getpid()), name=child.name)
        child.process.start()
        if writing is not None:
            os.close(writing)
        child.output, child.unread, child.ended = reading, b"", False
        child.starts += 1
        if self.register is not None:
            numbers = {one.name: one.process.pid for one in self.children.values()}
            with replacing(self.register) as file:
                file.write_text(json.dumps(numbers, indent=2) + "\n")

    def watch(self, timeout: float) -> list[Child]:
        """Print output that comes, or wait up to a timeout (s) for some; returns the processes that have ended."""
        alive = [child for child in self.children.values() if child.is_alive]
        by_handle: dict[Any, Child] = {child.process.sentinel: child for child in alive}
        by_handle.update({child.output: child for child in alive if child.output is not None})
        ended = []
        for handle in connection.wait(list(by_handle), timeout):
            child = by_handle[handle]
            if handle == child.output:
                self._read(child)
            elif not child.ended:
                child.ended = True
                child.process.join()
                while child.output is not None and connection.wait([child.output], 0):
                    self._read(child)
                self._forget_output(child)
                ended.append(child)
        return ended

    def _read(self, child: Child) -> None:
        chunk = os.read(child.output, 65536)
        if not chunk:
            self._forget_output(child)
            return
        *lines, child.unread = (child.unread + chunk).split(b"\n")
        for line in lines:
            self._print(child, line)

    def _forget_output(self, child: Child) -> None:
        if child.output is not None:
            os.close(child.output)
            child.output = None
        if child.unread:
            self._print(child, child.unread)
            child.unread = b""

    def _print(self, child: Child, line: bytes) -> None:
        if not self.quiet:
            text = line.decode(errors="replace") + "\n"
            self._printer.write(Message("line", text, datetime.now(), child.name, child.colour))

    def say(self, text: str) -> None:
        """Print a line of the supervisor itself."""
        self._printer.write(Message("line", text + "\n", datetime.now(), "manager", None))

    def stop(self, patience: float = 5.0) -> None:
        """End all processes by SIGINT, the first one, which lands the drones, before the others; then by SIGKILL.

        Args:
            patience: How long the others may take to end (s).
        """
        everybody = list(self.children.values())
        for sign, chosen, longest in (
            (signal.SIGINT, everybody[:1], LANDING_S),
            (signal.SIGINT, everybody[1:], patience),
            (signal.SIGKILL, everybody, patience),
        ):
            for child in chosen:
                if child.is_alive:
                    os.kill(child.process.pid, sign)
            deadline = time.monotonic() + longest
            while any(child.is_alive for child in chosen) and time.monotonic() < deadline:
                self.watch(0.1)


def _run(work: Callable[[], int | None], writing: int | None, reading: int | None, parent: int) -> None:
    """Run the main function of a process: output goes to the supervisor, and the process ends with it."""
    if writing is not None and reading is not None:
        os.close(reading)
        os.dup2(writing, 1)
        os.dup2(writing, 2)
        os.close(writing)
        sys.stdout = os.fdopen(1, "w", buffering=1, closefd=False)
        sys.stderr = os.fdopen(2, "w", buffering=1, closefd=False)
    os.setpgid(0, 0)  # Ctrl-C signals the supervisor alone
    end_with_parent(parent)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        code = work() or 0
    except KeyboardInterrupt:
        code = 0
    sys.stdout.flush()
    sys.stderr.flush()
    sys.exit(code)
