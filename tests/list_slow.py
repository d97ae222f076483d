"""Writes slow.txt, the test files that `pytest -m "not slow"` leaves out, from the times of a whole run.

python -m pytest -n auto --junitxml=times.xml && python tests/list_slow.py times.xml
"""

import sys
from collections import defaultdict
from pathlib import Path
from xml.etree import ElementTree

TESTS = Path(__file__).resolve().parent
MEAN_S, TOTAL_S = 0.05, 1.0  # of a file that is slow: per test, and altogether


def slow_files(report):
    """Return the slow files of a JUnit report, relative to this folder."""
    times = defaultdict(list)
    for case in ElementTree.parse(report).iter("testcase"):
        path = TESTS.parent / (case.get("classname").replace(".", "/") + ".py")
        if path.is_file():
            times[path.relative_to(TESTS).as_posix()].append(float(case.get("time")))
    return sorted(name for name, all in times.items() if sum(all) > TOTAL_S and sum(all) > MEAN_S * len(all))


if __name__ == "__main__":
    (TESTS / "slow.txt").write_text("".join(f"{name}\n" for name in slow_files(sys.argv[1])))
