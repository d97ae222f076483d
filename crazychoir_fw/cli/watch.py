"""`--watch`: do something, and again whenever one of its files was saved."""

import time
from collections.abc import Callable, Collection, Iterable, Iterator
from pathlib import Path

WAKE_UP = 1000  # [ms]; also looks this often, for file systems that report no changes
QUIET = 50  # [ms] without a change: editors write a file in several steps

Stamps = dict[Path, tuple[int, int] | None]


def repeat_on_save(
    attempt: Callable[[Collection[Path]], None],
    files: Callable[[], Collection[Path]],
    wake: "Callable[[Collection[Path]], Iterable[object]] | None" = None,
) -> None:
    """Call *attempt* now, and after every change of one of the files, until it or the wait is interrupted.

    A change during an attempt is not lost: files are compared with how they were when it began.

    Args:
        attempt: What to do; told which files changed, at first none.
        files: Which files count now; an attempt may change the answer.
        wake: Yields now and then, surely after a change in one of the given folders; by default what watchfiles sees.
    """
    wake = _changes if wake is None else wake
    changed: Collection[Path] = ()
    while True:
        began, before = time.time_ns(), stamps(files())
        attempt(changed)
        before = _with_untouched(before, stamps(files()), began)
        for _ in wake({path.parent for path in files()}):
            after = stamps(files())
            if after != before:
                changed = sorted(path for path in before | after if before.get(path) != after.get(path))
                break
        else:
            return


def stamps(files: Iterable[Path]) -> Stamps:
    """Return the time of the last change (ns) and the size (bytes) of each file; None where there is none."""

    def stamp(path: Path) -> tuple[int, int] | None:
        try:
            status = path.stat()
        except OSError:
            return None
        return status.st_mtime_ns, status.st_size

    return {path: stamp(path) for path in files}


def _with_untouched(before: Stamps, now: Stamps, began: int) -> Stamps:
    """Return the stamps from before an attempt, with those of files that the attempt made count but no editor wrote."""
    return {path: stamp for path, stamp in now.items() if stamp is None or stamp[0] < began} | before


def seconds_since_save(files: Iterable[Path]) -> float | None:
    """Return how long ago (s) the latest of the files was saved, or None if no clock can tell."""
    saved = [stamp[0] for stamp in stamps(files).values() if stamp is not None]
    elapsed = time.time() - max(saved) / 1e9 if saved else -1.0
    # files may come with the time of their origin, or from the future of another machine
    return elapsed if 0.0 <= elapsed < 3600.0 else None


def _changes(folders: Collection[Path]) -> Iterator[object]:
    """Yield after every change in one of the folders, and now and then without one."""
    from watchfiles import watch

    existing = sorted(folder for folder in folders if folder.is_dir())
    return watch(
        *existing,
        watch_filter=None,
        recursive=False,
        yield_on_timeout=True,
        rust_timeout=WAKE_UP,
        step=QUIET,
        debounce=10 * QUIET,
    )
