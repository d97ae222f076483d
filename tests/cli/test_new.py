"""`crazychoir new`: each starting point flies as it is written."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.cli.new import KINDS


def run(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


@pytest.mark.parametrize("kind", ["mission", "guidance", "controller", "scene"])
def test_a_starting_point_flies(tmp_path, monkeypatch, kind):
    monkeypatch.chdir(tmp_path)
    result = run("new", kind, "my_first")
    assert result.exit_code == 0, result.stderr
    command = result.stdout.splitlines()[-1].removeprefix("fly it with: crazychoir ")
    flown = run(*command.split(), "--no-video", "--out", "out")
    assert flown.exit_code == 0, flown.stdout + flown.stderr
    assert json.loads(Path("out/summary.json").read_text())["success"]
    for file in Path("my_first").iterdir():
        assert "examples/" not in file.read_text()
        assert f"{file}" in result.stdout


def test_an_app_is_written_with_its_script(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run("new", "app", "hopper")
    assert result.stdout.splitlines()[-1] == "fly it with: CRAZYFLIE_FIRMWARE=CHECKOUT python hopper/hopper.py"
    script = Path("hopper/hopper.py").read_text()
    compile(script, "hopper.py", "exec")
    assert 'with_name("hopper.c")' in script
    assert "void appMain(void)" in Path("hopper/hopper.c").read_text()


def test_a_policy_becomes_c_and_flies(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run("new", "policy", "catch")
    assert result.exit_code == 0, result.stderr
    for command in result.stdout.splitlines()[-1].removeprefix("fly it with: ").split(" && "):
        ran = run(*command.split()[1:], *(["--out", "out"] if command.startswith("crazychoir fly") else []))
        assert ran.exit_code == 0, ran.stdout + ran.stderr
    assert json.loads(Path("out/summary.json").read_text())["success"]
    mission = Path("catch/catch.yaml").read_text()
    assert "examples/" not in mission and "hover.c" not in mission


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("wing", "a"), f"there is no kind 'wing', allowed: {', '.join(KINDS)}\n"),
        (("mission", "../a"), "name is '../a', but must be a letter and up to 39 letters, digits and _\n"),
        (("mission", "there"), "there is there already: give another name\n"),
    ],
)
def test_what_cannot_be_written_is_one_sentence(tmp_path, monkeypatch, words, says):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there").mkdir()
    result = run("new", *words)
    assert (result.exit_code, result.stderr) == (2, says)
