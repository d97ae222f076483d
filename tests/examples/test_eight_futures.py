"""examples/eight_futures.py: the best of eight futures comes true."""

import subprocess
import sys
from pathlib import Path

EXAMPLE = Path(__file__).parents[2] / "examples" / "eight_futures.py"


def test_the_best_future_comes_true():
    done = subprocess.run([sys.executable, EXAMPLE], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    *futures, last = done.stdout.splitlines()
    assert len(futures) == 8
    # neither the most timid nor the most eager
    assert not last.startswith(("the best is 1.0,", "the best is 6.0,"))
    assert "which came true with" in last
