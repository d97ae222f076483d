"""Signals that end what a program does, in order."""

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

_ENDS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextmanager
def stop_at_signals(stop: Callable[[], None]) -> Iterator[None]:
    """Have Ctrl-C, SIGTERM and SIGHUP (the terminal is gone) call a function; a second one ends the program."""

    def handle(number: int, _: object) -> None:
        _leave_terminal(number)
        stop()
        signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)

    with _handled(handle):
        yield


@contextmanager
def unwind_at_signals() -> Iterator[None]:
    """Have SIGTERM and SIGHUP raise an exception, as Ctrl-C does, so that drones in the air are landed on the way out.

    Further signals are ignored, so that none of them interrupts a landing, which takes some seconds.

    Raises:
        KeyboardInterrupt: At Ctrl-C.
        SystemExit: At the others, with the exit code 128 + number of the signal.
    """

    def handle(number: int, _: object) -> None:
        for each in _ENDS:
            signal.signal(each, signal.SIG_IGN)
        _leave_terminal(number)
        if number == signal.SIGINT:
            raise KeyboardInterrupt
        raise _SignaledError(number)

    with _handled(handle):
        try:
            yield
        except _SignaledError as signaled:
            raise SystemExit(128 + signaled.number) from None


class _SignaledError(BaseException):
    """A signal has come; no `SystemExit`, because a user's code may raise that, and then only its drone stops."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


@contextmanager
def held_signals() -> Iterator[None]:
    """Deliver these signals only afterwards: libraries take an interrupt for a mistake of theirs."""
    came: list[int] = []
    with _handled(lambda number, _: came.append(number)):
        yield
    for number in came[:1]:
        signal.raise_signal(number)


@contextmanager
def ignored_signals() -> Iterator[None]:
    """Ignore these signals while something ends that must not be interrupted."""
    with _handled(signal.SIG_IGN):
        yield


@contextmanager
def _handled(handle: Any) -> Iterator[None]:
    """Have a handler called at the signals that end a program; one that is ignored (by nohup) stays so."""
    previous: dict[int, Any] = {}
    for number in _ENDS:
        present = signal.getsignal(number)
        if present is None:
            continue  # not installed by Python, which could not install it again
        if number == signal.SIGINT or present is not signal.SIG_IGN:
            previous[number] = signal.signal(number, handle)
    try:
        yield
    finally:
        for number, earlier in previous.items():
            signal.signal(number, earlier)


def _leave_terminal(number: int) -> None:
    """Stop writing to a terminal that is closed: each line would be an error in the middle of a landing."""
    if number != signal.SIGHUP:
        return
    for stream in (sys.stdout, sys.stderr):
        if stream.isatty():
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
