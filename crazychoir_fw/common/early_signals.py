"""Ctrl-C while a command imports its modules: the process ends at once, and silently, because nothing has begun yet.

Python would raise `KeyboardInterrupt` in the middle of a module, and show a traceback; extensions even take it for a
mistake of theirs. Other programs that import the package keep their signals.
"""

from __future__ import annotations

import signal
import sys
import threading
from contextlib import suppress
from importlib import import_module
from pathlib import Path

COMMAND = "crazychoir"
"""Name of the script that pip installs."""


def end_at_once() -> None:
    """Have Ctrl-C end this process without a word, if it is a command that begins."""
    is_command = Path((getattr(sys, "argv", None) or [""])[0]).name.removesuffix(".exe") == COMMAND
    is_main = threading.current_thread() is threading.main_thread()
    if is_command and is_main and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def interrupt_again() -> None:
    """Have Ctrl-C raise `KeyboardInterrupt` from now on, as Python does."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_DFL:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def import_first(*names: str) -> None:
    """Import modules, then have Ctrl-C raise `KeyboardInterrupt`; what is not installed, the command complains of."""
    for name in names:
        with suppress(ImportError, OSError):
            import_module(name)
    interrupt_again()
