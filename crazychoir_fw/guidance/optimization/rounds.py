"""Several agents of one process, one round after the other, in one thread."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from crazychoir_fw.guidance.optimization.algorithm import Algorithm


def run_together(
    algorithms: Sequence[Algorithm], iterations: int, until: Callable[[], bool] | None = None, now: float = 0.0
) -> int:
    """Let all agents do rounds in lock step.

    Args:
        algorithms: One per agent, over communicators of one process.
        iterations: How many rounds at most.
        until: Looked at after each; true ends it.
        now: Time (s), for neighbors that change with it.

    Returns:
        How many rounds were done.
    """
    for done in range(iterations):
        for algorithm in algorithms:
            algorithm.begin_round(now)
        for algorithm in algorithms:
            algorithm.finish_round()
        if all(algorithm.is_done for algorithm in algorithms) or (until is not None and until()):
            return done + 1
    return iterations
