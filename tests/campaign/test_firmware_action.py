"""The action for firmware repositories: what it says, and what its steps do; `crazychoir` itself is a stand-in."""

import json
import os
import subprocess
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / ".github/actions/campaign"
ACTION = yaml.safe_load((FOLDER / "action.yml").read_text())
STEPS = {step["name"]: step for step in ACTION["runs"]["steps"] if "run" in step}

STAND_IN = """#!/usr/bin/env python3
import json, os, pathlib, sys
there = pathlib.Path(os.environ["RUNNER_TEMP"])
with (there / "calls.jsonl").open("a") as file:
    file.write(json.dumps(sys.argv[1:]) + "\\n")
if sys.argv[1] == "campaign":
    out = pathlib.Path(sys.argv[sys.argv.index("--out") + 1])
    out.mkdir(parents=True)
    said = {"answer": os.environ["ANSWER"], "sentence": "3 flights broke"}
    (out / "compare.json").write_text(json.dumps(said))
sys.exit(int(os.environ.get("CODE", 0)))
"""


def git(folder, *words):
    who = {"GIT_AUTHOR_NAME": "a", "GIT_AUTHOR_EMAIL": "a@b", "GIT_COMMITTER_NAME": "a", "GIT_COMMITTER_EMAIL": "a@b"}
    subprocess.run(["git", "-C", str(folder), *words], check=True, capture_output=True, env={**os.environ, **who})


@pytest.fixture
def runner(tmp_path):
    """Runs a step as GitHub does, in a repository of two commits."""
    for name in ("checkout", "temp", "bin"):
        (tmp_path / name).mkdir()
    checkout, temp = tmp_path / "checkout", tmp_path / "temp"
    git(tmp_path, "init", "--quiet", str(checkout))
    for content in ("before", "after"):
        (checkout / "pid.c").write_text(content)
        git(checkout, "add", ".")
        git(checkout, "commit", "--quiet", "--message", content)
    tool = tmp_path / "bin/crazychoir"
    tool.write_text(STAND_IN)
    tool.chmod(0o755)

    def step(name, **environment):
        files = {"GITHUB_STEP_SUMMARY": str(temp / "summary.md"), "GITHUB_OUTPUT": str(temp / "output")}
        path = f"{tmp_path / 'bin'}:{os.environ['PATH']}"
        given = {**os.environ, **files, "PATH": path, "RUNNER_TEMP": str(temp), "CHECKOUT": ".", **environment}
        command = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", STEPS[name]["run"]]
        return subprocess.run(command, cwd=checkout, env=given, capture_output=True, text=True)

    step.temp, step.checkout = temp, checkout
    return step


def calls(temp):
    return [json.loads(line) for line in (temp / "calls.jsonl").read_text().splitlines()]


def test_the_action_is_one():
    assert ACTION["runs"]["using"] == "composite"
    assert ACTION["inputs"]["mission"]["required"] is True
    for step in ACTION["runs"]["steps"]:
        assert ("run" in step) != ("uses" in step)
        assert "run" not in step or step["shell"] == "bash"
    names = set(ACTION["inputs"])
    text = (FOLDER / "action.yml").read_text()
    used = {word.split(" ")[0].rstrip("}") for word in text.split("inputs.")[1:]}
    assert used == names


@pytest.mark.parametrize("name", STEPS)
def test_steps_are_shell_that_no_input_can_change(name):
    script = STEPS[name]["run"]
    assert "${{" not in script  # what a pull request is called would become code
    checked = subprocess.run(["bash", "-n"], input=script, text=True, capture_output=True)
    assert checked.returncode == 0, checked.stderr


def test_the_workflow_calls_the_action():
    workflow = yaml.safe_load((FOLDER / "workflow.yml").read_text())
    triggers = workflow[True]  # `on` of YAML 1.1
    assert "pull_request" in triggers
    assert workflow["permissions"] == {"contents": "read"}
    checkout, action = workflow["jobs"]["campaign"]["steps"]
    assert checkout["with"] == {"fetch-depth": 0, "submodules": "recursive"}
    assert action["uses"].endswith("/crazychoir_fw/.github/actions/campaign@main")
    assert set(action["with"]) <= set(ACTION["inputs"])
    needed = {name for name, one in ACTION["inputs"].items() if one.get("required")}
    assert needed <= set(action["with"])


def test_the_base_is_laid_out_beside_the_checkout(runner):
    missing = runner("Lay out the base revision", BASE="--upload-pack=x")
    assert missing.returncode == 2
    assert "::error::there is no revision '--upload-pack=x' here" in missing.stdout
    done = runner("Lay out the base revision", BASE="HEAD~1")
    assert done.returncode == 0, done.stderr
    assert (runner.temp / "base/pid.c").read_text() == "before"
    assert (runner.checkout / "pid.c").read_text() == "after"


@pytest.mark.parametrize(
    ("parity", "code", "ends"), [("report", 0, 0), ("report", 1, 0), ("fail", 1, 1), ("report", 2, 2)]
)
def test_differences_are_reported_or_fail(runner, parity, code, ends):
    done = runner("Compare functions and flights", PARITY=parity, PLATFORM="cf2", CODE=str(code))
    assert done.returncode == ends
    base = str(runner.temp / "base")
    assert calls(runner.temp)[0][:6] == ["firmware", "parity", "--base", base, "--checkout", "."]
    assert "### Functions and flights against the base" in (runner.temp / "summary.md").read_text()


@pytest.mark.parametrize(("answer", "code"), [("GO", 0), ("NO-GO", 1)])
def test_the_answer_is_that_of_the_campaign(runner, answer, code):
    words = {"MISSION": "missions/a b.yaml", "FLIGHTS": "20", "SUCCESS": "0.9", "ANSWER": answer, "CODE": str(code)}
    done = runner("Fly the campaign before and after", **words)
    assert done.returncode == code, done.stderr
    written = yaml.safe_load((runner.temp / "campaign.json").read_text())
    assert written["extends"] == str(runner.checkout / "missions/a b.yaml")
    assert written["compare"]["before"]["checkout"] == str(runner.temp / "base")
    assert written["compare"]["after"]["checkout"] == str(runner.checkout)
    assert f"### Campaign: {answer}\n3 flights broke" in (runner.temp / "summary.md").read_text()
    assert (runner.temp / "output").read_text() == f"answer={answer}\n"
