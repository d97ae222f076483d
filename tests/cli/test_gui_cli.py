"""`crazychoir gui` and `crazychoir press`, as far as they go without a browser."""

import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.cli.press import command_of


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_another_host_without_a_token_is_refused(tmp_path):
    result = run("gui", tmp_path / "mission.yaml", "--host", "0.0.0.0")
    assert result.exit_code == 2
    assert "give a --token" in result.stderr


def test_a_mission_that_is_not_there_is_one_sentence(tmp_path):
    result = run("gui", tmp_path / "mission.yaml", "--no-browser")
    assert result.exit_code == 2
    assert "mission.yaml cannot be read" in result.stderr


@pytest.mark.parametrize(
    ("words", "command"),
    [
        ("takeoff", {"name": "takeoff"}),
        ("disarm", {"name": "arm", "armed": False}),
        ("pause", {"name": "speed", "factor": 0.0}),
        ("goto 1 -2 0.5", {"name": "goto", "x": 1.0, "y": -2.0, "z": 0.5}),
        ("set posCtlPid.xKp 2", {"name": "set_parameter", "parameter": "posCtlPid.xKp", "value": 2.0}),
        ("rewind 3", {"name": "rewind", "time": 3.0, "branch": 0}),
    ],
)
def test_words_become_commands(words, command):
    button, *values = words.split()
    assert command_of(button, values) == command


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("explode", "there is no button 'explode', allowed: takeoff"),
        ("goto 1 2", "goto does not take 1 2"),
        ("goto 1 2 up", "1 2 up: allowed: numbers"),
        ("takeoff", "there is no page at"),
    ],
)
def test_what_cannot_be_pressed_is_one_sentence(words, sentence):
    result = run("press", *words.split(), "--address", "http://127.0.0.1:9")
    assert result.exit_code == 2
    assert sentence in result.stderr
