"""The table of what is tested, in docs/optimization.md, has every algorithm, and its tests exist."""

import inspect
import re
from pathlib import Path

import crazychoir_fw.guidance.optimization as optimization

HERE = Path(__file__).parent
PAGE = (HERE.parents[2] / "docs" / "optimization.md").read_text()
ROWS = PAGE.split("### What is tested")[1].split("## Task assignment")[0]


def test_every_algorithm_has_a_row():
    algorithms = {
        name
        for name, kind in inspect.getmembers(optimization, inspect.isclass)
        if issubclass(kind, optimization.Algorithm) and not inspect.isabstract(kind)
    }
    assert set(re.findall(r"^\| `(\w+)` \|", ROWS, flags=re.M)) == algorithms


def test_every_test_exists():
    named = re.findall(r"`(?:(test_\w+\.py)::)?(test_\w+)`", ROWS)
    assert len(named) > 40
    missing = [test for file, test in named if f"def {test}(" not in (HERE / (file or "test_rates.py")).read_text()]
    assert missing == []
