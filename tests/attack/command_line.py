"""Hostile missions against `crazychoir fly`, in this process: every one is refused in one sentence or would fly."""

import contextlib
import io
import os
import resource
import shutil
import signal
import tempfile
import traceback
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import Any

import pytest
import typer

from crazychoir_fw.cli import app
from crazychoir_fw.common.errors import StateError
from crazychoir_fw.flight import engine

LONGEST = 5
"""Processor time (s) after which a mission counts as a hang."""
MEMORY = 1_500_000_000
"""What a mission may take beyond what the process has (bytes)."""
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
_READY = "the mission is good"


class Hang(BaseException):
    """Something takes longer than `LONGEST`."""


@dataclass
class Campaign:
    """What came of all missions."""

    outcomes: Counter[str] = field(default_factory=Counter)
    failures: list[str] = field(default_factory=list)
    """What was wrong with the answers; the mission is kept beside it as a file."""

    def fail(self, outcome: str, content: bytes, what: str) -> None:
        """Note a failure, and keep the mission."""
        self.outcomes[outcome] += 1
        with tempfile.NamedTemporaryFile(prefix="mutant-", suffix=".yaml", delete=False) as file:
            file.write(content)
        self.failures.append(f"{file.name}: {what}")


@contextlib.contextmanager
def hostile_folder(folder: Path) -> Iterator[Path]:
    """Make a folder the current one, with a pipe, a folder and a loop of links where missions look for files."""
    for name in ("pipe.csv", "pipe.py"):
        os.mkfifo(folder / name)
    (folder / "folder").mkdir()
    (folder / "folder.csv").mkdir()
    (folder / "loop.yaml").symlink_to("loop.yaml")
    shutil.copytree(EXAMPLES, folder / "examples")  # what missions of the examples name
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(engine, "fly", _would_fly)
        yield folder


@contextlib.contextmanager
def limited() -> Iterator[None]:
    """Limit the memory of the process and the processor time of a mission."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + MEMORY, hard))
    before = signal.signal(signal.SIGVTALRM, _hang)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def try_mission(campaign: Campaign, file: Path, content: bytes, *options: str) -> None:
    """Write a mission to a file, ask the command line to fly it, and judge the answer."""
    file.write_bytes(content)
    error: Any = None
    stderr = io.StringIO()
    signal.setitimer(signal.ITIMER_VIRTUAL, LONGEST)
    try:
        with contextlib.redirect_stderr(stderr), contextlib.redirect_stdout(io.StringIO()):
            code = _COMMAND.main(["fly", str(file), "--no-video", "--out", "out", *options], standalone_mode=False)
    except (Exception, Hang, SystemExit) as raised:
        error = raised
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    said = stderr.getvalue()
    if error is not None:
        lines = traceback.format_exception(type(error), error, error.__traceback__)
        campaign.fail("crash", content, "".join(lines)[-3000:])
    elif code != 2 or not _is_answer(said):
        campaign.fail("bad answer", content, f"exit code {code}: {said[:2000]!r}")
    else:
        campaign.outcomes["would fly" if _READY in said else "refused"] += 1


def _is_answer(said: str) -> bool:
    """Return whether stderr has one sentence; a mission that would fly may have sentences of doubt before it."""
    lines = said.removesuffix("\n").split("\n")
    most = 20 if _READY in said else 1
    return said.endswith("\n") and len(lines) <= most and "\x1b" not in said and len(said) <= 1500


def _would_fly(*_: Any, **__: Any) -> None:
    raise StateError(_READY)


def _hang(number: int, frame: FrameType | None) -> None:
    raise Hang(f"longer than {LONGEST} s")


_COMMAND = typer.main.get_command(app)
