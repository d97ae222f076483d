"""`crazychoir firmware parity`."""

import json

import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.parity import run as parity
from crazychoir_fw.parity.cases import all_cases


@pytest.fixture
def run(tmp_path, monkeypatch):
    # a tenth of the cases, which have tests of their own
    monkeypatch.setattr(parity, "all_cases", lambda inputs: all_cases(inputs)[::10])

    def call(*words):
        words = ["firmware", "parity", *words, "--out", str(tmp_path / "report")]
        return CliRunner().invoke(app, [str(word) for word in words])

    return call


def test_builtin_against_itself_is_identical_and_kept(run, tmp_path):
    inputs = tmp_path / "inputs.npz"
    result = run("--candidate", "builtin", "--seconds", 0.2, "--no-flights", "--record", inputs)
    assert result.exit_code == 0, result.output
    assert "identical" in result.stdout
    assert (tmp_path / "report" / "parity.html").is_file()
    first = json.loads((tmp_path / "report" / "parity.json").read_text())

    again = run("--candidate", "builtin", "--seconds", 0.2, "--no-flights", "--inputs", inputs, "--json")
    assert again.exit_code == 0, again.output
    second = json.loads(again.stdout)
    assert second == first
    assert second["inputs"]["sha256"] == first["inputs"]["sha256"]


def test_a_checkout_is_compared_with_another_one(run, miniature, bitcraze_library):
    result = run("--base", miniature, "--checkout", miniature, "--seconds", 0.1, "--json")
    said = json.loads(result.stdout)
    assert said["reference"]["content"] == said["candidate"]["content"] == bitcraze_library.identity["content"]
    # but for a filter that loses its way in both
    assert {item["verdict"] for item in said["flights"] if not item.get("failures")} == {"identical"}
    assert {item["verdict"] for item in said["functions"]} == {"identical"}


def test_what_cannot_be_compared_exits_with_2_and_one_sentence(run, tmp_path):
    unknown = run("--candidate", "bitkraze")
    assert unknown.exit_code == 2
    assert "bitkraze" in unknown.stderr
    assert unknown.stderr.strip().count("\n") == 0
    missing = run("--checkout", tmp_path / "none")
    assert missing.exit_code == 2
    assert "there is no such folder" in missing.stderr
    no_inputs = run("--candidate", "builtin", "--inputs", tmp_path / "none.npz")
    assert no_inputs.exit_code == 2
    assert "cannot be read" in no_inputs.stderr


def test_an_unknown_platform_is_one_sentence(run):
    result = run("--candidate", "builtin", "--platform", "cf3")
    assert result.exit_code == 2
    assert "no platform named 'cf3'" in result.stderr
