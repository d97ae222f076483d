"""`crazychoir schema`: the JSON Schema of mission files, for editors."""

import json

import typer


def schema() -> None:
    """Print the JSON Schema of mission files, for completion and hover in editors."""
    from crazychoir_fw.mission.json_schema import mission_schema

    typer.echo(json.dumps(mission_schema(), indent=1))
