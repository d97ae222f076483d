"""`crazychoir info`: which versions, providers and sizes this installation has."""

from typing import Annotated, Any

import typer

from crazychoir_fw.cli.console import console, echo_json
from crazychoir_fw.cli.tables import facts_table


def info(as_json: Annotated[bool, typer.Option("--json", help="Print JSON for programs.")] = False) -> None:
    """Show what is installed: versions, providers, controllers, sizes."""
    from crazychoir_fw.core import info as facts_of_core

    facts = {**facts_of_core(), "firmware": _firmware()}
    if as_json:
        echo_json(facts)
        return
    console.print(facts_table({key: _phrase(value) for key, value in facts.items()}))


def _firmware() -> str:
    """Return which checkout of the real firmware would fly, or why none."""
    from crazychoir_fw.errors import CrazychoirError
    from crazychoir_fw.firmware.checkout import open_checkout

    try:
        checkout = open_checkout()
    except CrazychoirError as error:
        return f"none ({error})"
    return f"{checkout.version() or 'no repository of its own'} in {checkout.root}"


def _phrase(value: Any) -> str:
    if value is None or value is False:
        return "no"
    if isinstance(value, list):
        return ", ".join(_phrase(item) for item in value) or "none"
    if isinstance(value, dict):
        # what a provider library was built from
        return " ".join(str(value[key]) for key in ("provider", "version", "platform") if value.get(key))
    return str(value)
