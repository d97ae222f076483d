"""Flying again at every save: the loop by itself, and the command as a user runs it."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from crazychoir_fw.cli.watch import repeat_on_save, seconds_since_save, stamps

APP = Path(__file__).parents[1] / "firmware" / "apps" / "counting.c"


def later(path, text):
    """Write a file and let its time be another one, whatever the resolution of the clock."""
    before = path.stat().st_mtime_ns if path.exists() else 0
    path.write_text(text)
    os.utime(path, ns=(before + 1_000_000_000,) * 2)


def test_every_change_is_one_more_attempt(tmp_path):
    path, other = tmp_path / "a.c", tmp_path / "b.c"
    path.write_text("1")
    edits = [lambda: later(path, "2"), lambda: None, lambda: later(other, "new"), path.unlink]
    told = []

    def wake(folders):
        assert folders == {tmp_path}
        while edits:
            edits.pop(0)()
            yield

    repeat_on_save(told.append, lambda: [path, other], wake)
    assert told == [(), [path], [other], [path]]


def test_change_during_an_attempt_is_not_lost(tmp_path):
    path = tmp_path / "a.c"
    path.write_text("1")
    attempts = []

    def attempt(changed):
        attempts.append(changed)
        if len(attempts) == 1:
            later(path, "2")

    repeat_on_save(attempt, lambda: [path], lambda folders: [None])
    assert attempts == [(), [path]]


@pytest.mark.parametrize("is_written", [False, True])
def test_a_file_that_an_attempt_makes_count_has_not_changed_by_that(tmp_path, is_written):
    mission, app = tmp_path / "m.yaml", tmp_path / "a.c"
    for path in (mission, app):
        path.write_text("")
        os.utime(path, ns=(10**18,) * 2)
    files, attempts = {mission}, []

    def attempt(changed):
        attempts.append(changed)
        files.add(app)
        if is_written and len(attempts) == 1:
            app.write_text("new")
            os.utime(app, ns=(4 * 10**18,) * 2)

    repeat_on_save(attempt, lambda: files, lambda folders: [None])
    assert attempts == ([(), [app]] if is_written else [()])


def test_files_may_change_with_an_attempt(tmp_path):
    mission, app = tmp_path / "m.yaml", tmp_path / "app" / "a.c"
    app.parent.mkdir()
    mission.write_text("")
    app.write_text("")
    files, watched = [mission], []

    def wake(folders):
        watched.append(set(folders))
        if len(watched) <= 2:
            later(app, "x" * len(watched))
        yield

    repeat_on_save(lambda changed: files.append(app), lambda: list(files), wake)
    assert watched[0] == {tmp_path, app.parent}
    assert len(watched) == 3


def test_time_since_a_save_is_told_only_if_it_makes_sense(tmp_path):
    path = tmp_path / "a.c"
    assert seconds_since_save([path]) is None
    path.write_text("")
    assert 0.0 <= seconds_since_save([path]) < 3600.0
    os.utime(path, (0, 0))
    assert seconds_since_save([path]) is None
    assert stamps([path, tmp_path / "gone"]) == {path: (0, 0), tmp_path / "gone": None}


def read_until(process, words):
    """Return what a process prints until a line holds these words."""
    lines = []
    for line in process.stdout:
        lines.append(line)
        if words in line:
            return "".join(lines)
    pytest.fail("".join(["ended without: ", words, "\n", *lines]))


def test_command_flies_again_complains_and_ends_well(tmp_path):
    text = APP.read_text()
    app, mission = tmp_path / "mine.c", tmp_path / "hop.yaml"
    app.write_text(text)
    mission.write_text("drones: {count: 1}\nflight: [takeoff: {height: 0.3, duration: 1}, land: {duration: 1}]\n")
    program = "from crazychoir_fw.cli import app; app()"
    process = subprocess.Popen(
        [sys.executable, "-c", program, "fly", mission, "--app", app, "--watch"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**os.environ, "COLUMNS": "200"},
    )
    try:
        first = read_until(process, "waiting for a change of hop.yaml, mine.c")
        assert "success" in first and "builtin+mine" in first and "crazychoir film" in first
        app.write_text("int x = ;\n" + text)
        broken = read_until(process, "waiting for a change")
        assert "mine.c changed" in broken and f"{app}:1:9: error: " in broken and "success" not in broken
        app.write_text(text.replace("COUNT", "AGAIN"))
        again = read_until(process, "waiting for a change")
        assert "success" in again and " s from save to result" in again
        mission.write_text("drones: []\n")
        assert f"{mission}: drones is []" in read_until(process, "waiting for a change")
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=60) == 0
    finally:
        process.kill()
        process.stdout.close()
        process.wait()
