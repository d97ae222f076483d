"""`crazychoir app build` and `crazychoir fly --app`."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app

APPS = Path(__file__).parents[1] / "firmware" / "apps"


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments], env={"COLUMNS": "200"})


def test_build_says_what_an_app_brings_and_how_to_fly_it():
    path = APPS / "counting.c"
    result = run("app", "build", path)
    assert result.exit_code == 0, result.output
    rows = dict(line.split(maxsplit=1) for line in result.stdout.splitlines() if line.startswith(" "))
    assert rows["library"].strip() == "builtin+counting cf2"
    assert rows["brings"].strip() == "controller"
    assert rows["state"].strip() == "28 bytes per drone"
    assert rows["parameters"].strip() == "count.scale = 1, count.inits = 0"
    assert rows["logs"].strip() == "count.calls, count.thrust"
    assert f"crazychoir fly MISSION.yaml --app {path}" in result.stdout
    assert result.stderr == ""


def test_warnings_are_shown_as_they_were_printed(tmp_path):
    path = tmp_path / "sloppy.c"
    path.write_text("static int unused;\n" + (APPS / "counting.c").read_text())
    result = run("app", "build", path)
    assert result.exit_code == 0
    assert f"{path}:1:12: warning: " in result.stderr
    assert "    1 | static int unused;" in result.stderr


@pytest.mark.parametrize("arguments", [("app", "build"), ("fly", "MISSION", "--app")], ids=["build", "fly"])
def test_errors_of_the_compiler_are_shown_as_they_were_printed(tmp_path, arguments):
    path, mission = tmp_path / "broken.c", tmp_path / "hop.yaml"
    path.write_text("\tint x = ;\n")
    mission.write_text("drones: {count: 1}\nflight: [takeoff, land]\n")
    words = [mission if word == "MISSION" else word for word in arguments]
    result = run(*words, path, *(["--out", tmp_path / "out"] if "fly" in words else []))
    assert result.exit_code == 2
    assert f"{path}:1:17: error: " in result.stderr or f"{path}:1:10: error: " in result.stderr
    assert "Traceback" not in result.output


@pytest.mark.parametrize(
    ("name", "says"),
    [("gone.c", "gone.c does not exist"), ("notes.txt", "notes.txt is no C source"), ("idle.c", "controllerOutOfTree")],
)
def test_other_mistakes_are_one_sentence(tmp_path, name, says):
    for existing in ("notes.txt", "idle.c"):
        (tmp_path / existing).write_text("")
    result = run("app", "build", tmp_path / name)
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert says in result.stderr


def test_provider_without_a_checkout_is_one_sentence(tmp_path):
    result = run("app", "build", APPS / "counting.c", "--path", tmp_path / "nowhere")
    assert result.exit_code == 2
    assert result.stderr == f"no firmware checkout at {tmp_path / 'nowhere'}: there is no such folder\n"
    assert (
        "allowed around an app: builtin, bitcraze" in run("app", "build", APPS / "counting.c", "--provider", "x").stderr
    )
