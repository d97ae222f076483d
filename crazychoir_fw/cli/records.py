"""The folder of a flight: written while it flies, and as a whole at its end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from crazychoir_fw.cli.console import complaints

if TYPE_CHECKING:
    from crazychoir_fw.recording.log_stream import LogStream

SUMMARIES = ("summary.json", "statistics.json")
"""Files that say what the others in a folder are."""


@contextmanager
def writing(folder: Path) -> Iterator[LogStream]:
    """Give the stream of a flight in a folder.

    A flight that is cut off, by Ctrl-C or a signal, leaves `log.npz`, made of the stream; if that is not to be written,
    the stream stays.

    Raises:
        OSError: If the folder cannot be written.
        StateError: If another flight is writing there.
    """
    from crazychoir_fw.recording.log_stream import STREAM, LogStream

    stream = LogStream(folder / STREAM)
    try:
        yield stream
    except BaseException:
        if stream.has_rows:
            _keep_cut(folder, stream)
        else:
            stream.close(remove=True)
        raise
    finally:
        stream.close()


def _keep_cut(folder: Path, stream: LogStream) -> None:
    """Make a log of what was flown until now."""
    from crazychoir_fw.recording.flight_log import FlightLog

    try:
        log = FlightLog.load(stream.path)
    except (OSError, ValueError) as error:
        sentence: str | None = str(error)
    else:
        if not log.duration_s:  # what was refused at its first sample, as a camera that is not there, is no flight
            stream.close(remove=True)
            return
        sentence = write_together(folder, lambda new: log.save(new / "log.npz"), stream)
    said = f"{log.duration_s:.1f} s of flight are in {folder}/log.npz" if sentence is None else sentence
    complaints.print(said, markup=False, highlight=False, soft_wrap=True)


def write_together(folder: Path, write: Callable[[Path], None], stream: LogStream) -> str | None:
    """Write the files of a flight, all or none, and remove the stream in their favor.

    Args:
        folder: Where.
        write: Writes them into another folder.
        stream: What was written while it flew; it stays if they cannot be written.

    Returns:
        Why they are not written, a sentence; None when they are.
    """
    from crazychoir_fw.common.replacing import replacing_together

    try:
        with replacing_together(folder, SUMMARIES) as new:
            write(new)
    except OSError as error:
        kept = f"; what was flown is in {stream.path}" if stream.has_rows and stream.failure is None else ""
        return f"{folder} cannot be written: {error.strerror or error}{kept}"
    stream.close(remove=True)
    return None
