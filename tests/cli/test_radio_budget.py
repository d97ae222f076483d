"""`crazychoir radio-budget`."""

from typer.testing import CliRunner

from crazychoir_fw.cli import app


def run(*options):
    return CliRunner().invoke(app, ["radio-budget", *options])


def verdicts(output):
    rows = [line.split() for line in output.splitlines()]
    return {int(row[0]): " ".join(row[6:]) for row in rows if row and row[0].isdigit()}


def test_it_shows_from_where_on_it_is_too_much():
    found = verdicts(run("--setpoints", "50").output)
    assert list(found) == [1, 2, 4, 6, 8, 10, 12, 15, 20, 25, 30, 40]
    assert list(dict.fromkeys(found.values())) == ["fits", "tight", "too much"]


def test_it_answers_for_one_number_of_drones():
    result = run("--count", "12", "--logs", "10", "--logs", "100", "--poses", "5", "--data-rate", "1M")
    assert result.exit_code == 0
    assert "1M, setpoints 10 Hz, logs 10 + 100 Hz, poses 5 Hz, 0 % loss" in " ".join(result.output.split())
    assert verdicts(result.output) == {12: "too much"}


def test_bad_input_is_refused():
    result = run("--data-rate", "3M")
    assert result.exit_code == 2
    assert "data_rate is '3M', allowed: one of 250K, 1M, 2M" in result.output
