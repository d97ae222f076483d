"""Tutorials are done as they are printed: files are written, commands and programs executed, in an empty folder."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGES = [DOCS / "first_flight.md", *sorted((DOCS / "tutorials").glob("*.md"))]
BLOCK = re.compile(r"^```(\w+)([^\n]*)\n(.*?)^```", flags=re.MULTILINE | re.DOTALL)
NEEDS = {"rehearsal": "cflib", "campaign": "scipy", "ros": "rclpy"}
"""Library without which a page cannot be done."""


def call(line, folder):
    """Start a command line of a page; `&&` and a final `&` as in a shell."""
    words = [shlex.quote(sys.executable), "-m", "crazychoir_fw"]
    line = re.sub(r"\bcrazychoir (?=\w)", " ".join(words) + " ", line)
    paths = [str(DOCS.parent), *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    return subprocess.Popen(
        line.removesuffix("&") if line.endswith(" &") else line,
        shell=True, cwd=folder, env=environment, text=True, stdout=-1, stderr=subprocess.STDOUT, start_new_session=True,
    )  # fmt: skip


def blocks():
    for page in PAGES:
        found = BLOCK.findall(page.read_text())
        if any("no-test" not in info for _, info, _ in found):
            yield pytest.param(page, found, id=page.stem)


@pytest.mark.parametrize(("page", "found"), list(blocks()))
def test_the_page_is_done_as_printed(page, found, tmp_path):
    if page.stem in NEEDS:
        pytest.importorskip(NEEDS[page.stem])
    servers = []
    try:
        for language, info, text in found:
            title = re.search(r'title="([^"]+)"', info)
            if "no-test" in info:
                continue
            if title:
                (tmp_path / title[1]).write_text(text)
            elif language == "python":
                (tmp_path / "program.py").write_text(text)
                ran = subprocess.run([sys.executable, "program.py"], cwd=tmp_path, capture_output=True, text=True)
                assert ran.returncode == 0, ran.stderr
                assert ran.stdout.strip()
            elif language == "console":
                servers += run_lines(text, tmp_path)
            else:
                raise AssertionError(f"{page.name}: a block of {language} without a title")
    finally:
        for server in servers:
            os.killpg(server.pid, 15)
            server.wait(10)


def run_lines(text, folder):
    """Run the lines of a block; return what goes on in the background."""
    servers = []
    for line in text.splitlines():
        process = call(line, folder)
        if line.endswith(" &"):
            servers.append(process)
            for printed in process.stdout:
                if "19850" in printed:
                    break
            continue
        said, _ = process.communicate(timeout=300)
        # NO-GO and GO are both answers; 2 is a command that cannot be carried out
        allowed = (0, 1, 2) if "campaign" in line and "refly" not in line else (0,)
        assert process.returncode in allowed, f"{line}\n{said}"
        assert "Traceback" not in said, said
    return servers
