import json

import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app


@pytest.fixture
def run(cache_folder, tmp_path):
    def call(*words):
        return CliRunner().invoke(app, ["firmware", *map(str, words)])

    return call


def test_a_checkout_that_is_none_exits_with_2_and_one_sentence(run, tmp_path):
    (tmp_path / "README.md").write_text("")
    result = run("build", "--path", tmp_path)
    assert result.exit_code == 2
    assert result.stderr.startswith(f"{tmp_path} is not a checkout of the Crazyflie firmware")
    assert result.stderr.count("\n") == 1


def test_show_without_a_checkout_is_no_error(run, tmp_path):
    result = run("show", "--path", tmp_path / "none")
    assert result.exit_code == 0
    assert "there is no such folder" in result.stdout
    facts = json.loads(run("show", "--path", tmp_path / "none", "--json").stdout)
    assert facts["libraries"] == []
    assert facts["version"] is None


def test_clean_says_how_much_it_was(run, cache_folder):
    result = run("clean")
    assert result.exit_code == 0
    assert "0.0 MB deleted" in result.stdout


def test_clean_of_a_foreign_folder_is_refused(run, cache_folder):
    (cache_folder / "provider-libraries").mkdir(parents=True)
    result = run("clean")
    assert result.exit_code == 2
    assert "nothing was deleted" in result.stderr
