"""Count phrases that are private to this project, where the field has a word, and fail above a limit.

    python .ci/language.py               the count of each area, and the limits
    python .ci/language.py --show docs   every place of an area

Looks at Markdown, at comments and docstrings of Python, and at comments of C. Code blocks and code in backquotes are
left out. The limits only go down.
"""

from __future__ import annotations

import argparse
import ast
import io
import re
import subprocess
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

PHRASES = {
    r"\b(?:nobody|somebody|someone|whoever|whomever|no one)\b": "name the component",
    r"(?<![\w'])(?:Who|who) (?:is|are|was|were|does|do|did|has|have|wants?|asks?|needs?|sends?|may|can|flies|"
    r"dies|died|makes?|"
    r"gets?|shall|must|answers?|reads?|writes?|waits?|knows?|comes?|came|left|speaks?|talks?)\b": "name the component",
    r"\b(?:those|the ones?|they) (?:who|that) (?:know|want|ask|need|wait|listen)\b": "name the component",
    r"\banew\b": "again, restart, reset",
    r"\blies? still\b|\blying still\b|\blay still\b": "at rest, asleep",
    r"\bquiet days?\b|\bone day\b|\bnowadays\b": "state the condition, not the story",
    r"\b(?:begin|began|begins|go|goes|come|comes) to nothing\b": "fails",
    r"\bwhat (?:is|was|are|were) (?:handed|asked|told|left|meant|thought)\b": "name the value",
    r"\b(?:is|are|was|were|been) told\b": "receives, is notified",
    r"\b(?:is|are|was|were) heard\b": "received",
    r"\bturned (?:back|out of)\b": "restored, reverted",
    r"\bmade anew\b|\bstarted anew\b": "recreated, restarted",
    r"\bmany a\b|\bsuch a one\b|\bnone of ours\b|\bnone other\b": "plain words",
    r"\bfor ever\b": "forever, indefinitely",
    r"\b(?:at|the) (?:least|most) (?:of|distance|speed|voltage|time|rate|height|battery)\b": "min, max",
    r"\bwaited for no more\b|\bwaited for\b": "timeout, wait for",
    r"\bmend(?:s|ed|ing)?\b": "fix, repair",
    r"\bbefall(?:s|en)?\b|\bhenceforth\b|\bthereof\b|\bwherein\b|\bwhereof\b|\blest\b|\bhitherto\b": "plain words",
    r"\b(?:people|persons?) (?:may|can|do|read|see|type)\b": "users",
}
"""What is counted, and what to write instead."""

LIMITS = {"docs": 2.0, "package": 2.0, "core": 1.0, "tests": 1.0}
"""Most phrases per 10,000 words, by area."""

_PATTERN = re.compile("|".join(f"(?P<p{i}>{phrase})" for i, phrase in enumerate(PHRASES)))
_WORD = re.compile(r"[A-Za-z][A-Za-z'-]+")


def prose_of_markdown(text: str) -> Iterator[tuple[int, str]]:
    """Yield line number and prose of a page."""
    is_code = False
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("```"):
            is_code = not is_code
        elif not is_code and not line.startswith("    "):
            yield number, re.sub(r"`[^`]*`|\]\([^)]*\)", " ", line)


def prose_of_python(text: str) -> Iterator[tuple[int, str]]:
    """Yield line number and prose of comments and docstrings."""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            for offset, line in enumerate(node.value.value.splitlines()):
                yield node.lineno + offset, re.sub(r"``?[^`]*``?", " ", line)


def prose_of_c(text: str) -> Iterator[tuple[int, str]]:
    """Yield line number and prose of comments."""
    for found in re.finditer(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\])*"', text, flags=re.DOTALL):
        if not found[0].startswith('"'):
            begin = text.count("\n", 0, found.start()) + 1
            for offset, line in enumerate(found[0].splitlines()):
                yield begin + offset, line


READERS = {".md": prose_of_markdown, ".py": prose_of_python, ".c": prose_of_c, ".h": prose_of_c}


def area_of(path: Path) -> str | None:
    """Return the area that a file counts for."""
    if path.suffix == ".md":
        return "docs"
    first = path.parts[0]
    return {"crazychoir_fw": "package", "bindings": "core", "tests": "tests"}.get(first, "package")


def main() -> None:
    """Count, and fail above a limit."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--show", metavar="AREA", help=f"print every place: {', '.join(LIMITS)}")
    arguments = parser.parse_args()
    names = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    words, found = dict.fromkeys(LIMITS, 0), dict.fromkeys(LIMITS, 0)
    for name in filter(None, names.split("\0")):
        path = Path(name)
        if path.suffix not in READERS or path.parts[0] == "firmware" or name == ".ci/language.py":
            continue
        if not (ROOT / path).is_file() or (ROOT / path).is_symlink():
            continue
        area = area_of(path)
        for number, line in READERS[path.suffix]((ROOT / path).read_text(encoding="utf-8")):
            words[area] += len(_WORD.findall(line))
            for match in _PATTERN.finditer(line):
                found[area] += 1
                if arguments.show == area:
                    advice = list(PHRASES.values())[int(match.lastgroup[1:])]
                    print(f"{name}:{number}: '{match[0]}' ({advice}): {line.strip()[:150]}")
    is_above = False
    for area, most in LIMITS.items():
        rate = 1e4 * found[area] / max(words[area], 1)
        print(f"{area}: {found[area]} phrases in {words[area]} words, {rate:.1f} per 10,000, allowed: {most:g}")
        is_above |= rate > most
    sys.exit(is_above)


if __name__ == "__main__":
    main()
