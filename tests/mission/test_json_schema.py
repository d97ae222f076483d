"""Editors check a mission as the loader does."""

import importlib.util
import json
from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.mission.json_schema import mission_schema, models

jsonschema = pytest.importorskip("jsonschema")
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def validator():
    validator = jsonschema.Draft202012Validator(mission_schema())
    validator.check_schema(validator.schema)
    return validator


MISSIONS = [
    path
    for path in sorted((ROOT / "examples").rglob("*.yaml"))
    if {"drones", "extends"} & (keys := (yaml.safe_load(path.read_text()) or {}).keys()) and "flights" not in keys
]


@pytest.mark.parametrize("path", MISSIONS, ids=lambda path: path.stem)
def test_examples_are_valid(validator, path):
    assert [error.message for error in validator.iter_errors(yaml.safe_load(path.read_text()))] == []


FLIGHT = [{"takeoff": {"height": 1.0}}, "land"]
UP = {"name": "up", "drones": {"count": 2}, "flight": FLIGHT}


@pytest.mark.parametrize(
    "change",
    [
        {"flight": [{"takeoff": {"height": 1000.0}}]},
        {"flight": [{"takeoff": {"heihgt": 1.0}}]},
        {"flight": [{"fly": {}}]},
        {"flight": [{"hover": {"duration": 1.0}, "land": {}}]},
        {"flight": []},
        {"seed": -1},
        {"seed": "one"},
        {"droms": {}},
        {"drones": {"count": 0}},
        {"defaults": {"platform": "cf3"}},
        {"faults": [{"motor": {"att": 1.0}}]},
        {"faults": [{"motor": {"at": -1.0}}]},
        {"backend": "hardware"},
    ],
)
def test_mistakes_are_found_while_they_are_typed(validator, change):
    assert validator.is_valid(UP)
    assert not validator.is_valid({**UP, **change})


def test_every_section_says_what_its_keys_mean(validator):
    parts = validator.schema["$defs"]
    assert len(models()) > 25
    silent = [
        f"{name}.{key}"
        for name, part in parts.items()
        for key, entry in (part["anyOf"][1] if "anyOf" in part else part).get("properties", {}).items()
        if not entry.get("description") and "anyOf" not in part
    ]
    assert silent == []
    assert "m/s" in parts["Tolerance"]["properties"]["collision_speed"]["description"]


def test_the_command_prints_it(validator):
    assert json.loads(CliRunner().invoke(app, ["schema"]).output) == json.loads(json.dumps(validator.schema))


def test_pages_of_commands_and_keys_are_up_to_date():
    spec = importlib.util.spec_from_file_location("make_reference", ROOT / "docs/make_reference.py")
    reference = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(reference)
    for name, make in reference.PAGES.items():
        assert (ROOT / "docs" / name).read_text() == make(), "run python docs/make_reference.py"
