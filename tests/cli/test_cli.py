"""The command line, as far as it goes without flying."""

import json
import re
import subprocess
import sys
from types import ModuleType

import pytest
import typer
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.cli.tables import MANY, flight_tables, verdict
from crazychoir_fw.common.version import __version__
from crazychoir_fw.mujoco_models import SCENES

FACTS = {"version": "1.2.3", "providers": ["builtin"], "parameters": 200, "ros": None}


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def bad_mission(tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_text("drones: {count: 2}\nflight:\n- takeoff: {hieght: 1}\n")
    return path


@pytest.fixture
def installation_with_facts(monkeypatch):
    """An installation that tells a few facts."""
    installation = ModuleType("crazychoir_fw.onboard.installation")
    installation.info = lambda: FACTS
    monkeypatch.setitem(sys.modules, "crazychoir_fw.onboard.installation", installation)


def test_bad_mission_prints_one_sentence_and_exits_with_2(bad_mission):
    result = run("fly", bad_mission)
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert result.stderr.startswith(f"{bad_mission}: flight[0].takeoff has no key 'hieght' (did you mean 'height'?)")
    assert result.stdout == ""


def test_missing_mission_is_one_sentence_too(tmp_path):
    result = run("fly", tmp_path / "gone.yaml")
    assert result.exit_code == 2
    assert result.stderr == f"{tmp_path / 'gone.yaml'} cannot be read: No such file or directory\n"


@pytest.mark.parametrize(
    ("option", "value", "says"),
    [
        ("--seed", "-1", "--seed"),
        ("--seed", "one", "--seed"),
        ("--threads", "0", "--threads"),
        ("--provider", "bit kraze", "provider is 'bit kraze', but must be"),
        ("--provider", "bitkraze", "no provider named 'bitkraze' for cf2, there are "),
    ],
)
def test_bad_option_exits_with_2(tmp_path, option, value, says):
    path = tmp_path / "good.yaml"
    path.write_text("drones: {count: 2}\nflight: [takeoff]\n")
    result = run("fly", path, option, value)
    assert result.exit_code == 2
    assert says in result.stderr
    assert "Traceback" not in result.stderr


def test_output_folder_that_cannot_be_made_is_one_sentence(tmp_path):
    path = tmp_path / "good.yaml"
    path.write_text("drones: {count: 2}\nflight: [takeoff]\n")
    result = run("fly", path, "--out", path / "below_a_file")
    assert result.exit_code == 2
    assert result.stderr == f"{path / 'below_a_file'} cannot be written: Not a directory\n"


def test_the_version_is_shown():
    result = run("--version")
    assert (result.exit_code, result.stdout) == (0, f"crazychoir {__version__}\n")


def test_completion_can_be_installed():
    assert "--install-completion" in run("--help").stdout


def command_lines(group, words=()):
    for name, command in group.commands.items():
        yield from command_lines(command, (*words, name)) if hasattr(command, "commands") else [(*words, name)]


COMMANDS = sorted(command_lines(typer.main.get_command(app)))


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_help_shows_units_and_no_types_of_python(words):
    result = run(*words, "--help")
    assert result.exit_code == 0
    assert not re.findall(r"<(?:int|float|str|bool|path|list).*?>", result.stdout)


def test_help_shows_seconds_and_files():
    assert re.search(r"--seconds +SECONDS", run("run", "--help").stdout)
    assert re.search(r"--out +DIR", run("fly", "--help").stdout)


@pytest.mark.parametrize(("words", "says"), [(("fyl",), "'fly'"), (("firmware", "buld"), "'build'")])
def test_a_mistyped_command_is_answered_with_the_nearest(words, says):
    result = run(*words)
    assert result.exit_code == 2
    assert f"Did you mean {says}?" in result.stderr


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_drones_are_names_wherever_they_are_an_option(words):
    line = next((line for line in run(*words, "--help").stdout.splitlines() if "--drones" in line), None)
    assert line is None or "NAMES" in line


def test_a_log_is_exported_to_files_of_mcap_only(tmp_path):
    result = run("export", tmp_path, "--mcap", tmp_path / "x.csv")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr == f"--mcap is {tmp_path / 'x.csv'}, but must end in .mcap\n"


def test_no_command_shows_the_help():
    result = run()
    assert "fly" in result.output
    assert "info" in result.output


@pytest.mark.usefixtures("installation_with_facts")
def test_info_as_json_is_what_core_says_and_which_firmware_would_fly(monkeypatch, miniature):
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(miniature))
    result = run("info", "--json")
    assert result.exit_code == 0
    facts = json.loads(result.stdout)
    del facts["firmware_libraries"]  # other tests may have built it
    assert facts == {**FACTS, "scenes": list(SCENES), "firmware": f"2026.08 in {miniature}"}


@pytest.mark.parametrize(
    ("words", "where"), [(["firmware", "build"], "CRAZYFLIE_FIRMWARE"), (["firmware", "parity"], "CRAZYFLIE_FIRMWARE")]
)
def test_help_says_where_a_checkout_is_looked_for(words, where):
    assert where in run(*words, "--help").stdout


@pytest.mark.usefixtures("installation_with_facts")
def test_info_says_why_there_is_no_firmware(monkeypatch, tmp_path):
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(tmp_path))
    facts = json.loads(run("info", "--json").stdout)
    assert facts["firmware"].startswith("none (")
    assert str(tmp_path) in facts["firmware"]


@pytest.mark.usefixtures("installation_with_facts")
def test_info_is_a_table_for_people():
    result = run("info")
    assert result.exit_code == 0
    lines = [line.split() for line in result.stdout.splitlines()]
    assert ["version", "1.2.3"] in lines
    assert ["ros", "no"] in lines


def test_command_line_starts_without_the_slow_imports():
    code = (
        "import sys, crazychoir_fw; before = set(sys.modules); import crazychoir_fw.cli\n"
        "slow = {'mujoco', 'matplotlib', 'pydantic', 'yaml', 'imageio', 'numpy'}\n"
        "print(sorted((set(sys.modules) - before) & slow))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def summary_of(count):
    drone = {
        "rms_error_m": 0.012,
        "max_error_m": 0.034,
        "endpoint_error_m": 0.001,
        "estimator_rms_m": None,
        "hover_thrust_percent": 59.27,
        "battery_V": 3.914,
        "supervisor_state": "Landed",
    }
    drones = [drone | {"id": f"cf{i}", "max_error_m": 0.001 * i} for i in range(1, count + 1)]
    head = {"mission": "hop", "provider": "builtin", "success": True, "sim_seconds": 10.0, "wall_seconds": 0.5}
    return head | {"real_time_factor": 20.0, "drones": drones, "backend": "sim", "criteria": []}


def cells(table, row):
    return [list(column.cells)[row] for column in table.columns]


def test_table_has_a_row_per_drone_in_centimeters():
    (table,) = flight_tables(summary_of(4))
    assert table.row_count == 4
    assert cells(table, 1) == ["cf2", "1.2", "0.2", "0.1", "-", "59.3", "3.91", "Landed"]


def test_table_of_a_large_swarm_shows_the_worst():
    (table,) = flight_tables(summary_of(1000))
    assert table.row_count == MANY
    assert cells(table, 0)[0] == "cf1000"


def test_verdict_says_how_it_went_how_fast_and_where(tmp_path):
    assert verdict(summary_of(1), tmp_path).plain == (
        f"success: 10.0 s flown in 0.5 s (20.0 x real time), see {tmp_path}/"
    )


def test_variables_lists_parameters_with_their_factory_values():
    result = run("variables", "pid_rate.*", "--platform", "cf21bl", "--json")
    rows = {row["name"]: row for row in json.loads(result.stdout)}
    assert all(name.startswith("pid_rate.") for name in rows)
    assert rows["pid_rate.roll_kp"] == {
        "name": "pid_rate.roll_kp",
        "type": "float32",
        "value": 200.0,
        "read_only": False,
        "persistent": True,
        "core": False,
    }


def test_variables_lists_logs_as_a_table():
    result = run("variables", "pm.*", "--logs")
    assert result.exit_code == 0
    assert "pm.vbat " in result.stdout
    assert "float32" in result.stdout


def test_variables_of_the_firmware_are_those_that_its_sources_declare(monkeypatch, lasting_cache, miniature):
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(miniature))
    rows = json.loads(run("variables", "pid_rate.roll_kp", "--provider", "bitcraze", "--json").stdout)
    assert [row["value"] for row in rows] == [250.0]


def test_variables_of_an_unknown_platform_are_refused():
    result = run("variables", "--platform", "cf3")
    assert result.exit_code == 2
    assert result.stderr == "no platform named 'cf3', allowed: cf2, cf21bl\n"


def test_vehicle_shows_what_a_named_one_changes():
    rows = json.loads(run("vehicle", "kit", "battery.*", "--json").stdout)
    assert [(row["name"], row["value"], row["source"]) for row in rows][:2] == [
        ("battery.capacity", 350.0, "BHW"),
        ("battery.resistance", 0.1, "BDOC"),
    ]
    assert "Vehicles that change cf2 in part: kit, legacy, nanobench" in run("vehicle").stdout


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["nope.*"], "no vehicle 'nope.*', there are: cf2, cf21bl, kit, legacy, nanobench; names of parameters come"),
        (
            ["cf2", "nope.*"],
            "cf2 has no parameter 'nope.*', there are: mass, inertia, products_of_inertia, landed_height,",
        ),
        (["legacy", "imu.*"], "legacy has no parameter 'imu.*', there are: mass, rotors.*, drag.*"),
    ],
)
@pytest.mark.parametrize("json_or_not", [[], ["--json"]])
def test_vehicle_says_what_there_is(arguments, sentence, json_or_not):
    result = run("vehicle", *arguments, *json_or_not)
    assert result.exit_code == 2
    assert result.stderr.startswith(sentence)
