"""`crazychoir info`: which versions, providers and sizes this installation has."""

from typing import Annotated, Any

import typer

from crazychoir_fw.cli.console import console, echo_json
from crazychoir_fw.cli.tables import facts_table


def info(as_json: Annotated[bool, typer.Option("--json", help="Print JSON for programs.")] = False) -> None:
    """Show what is installed: versions, providers, controllers, sizes."""
    from crazychoir_fw.mujoco_models import SCENES
    from crazychoir_fw.onboard.installation import info as facts_of_core

    facts = {**facts_of_core(), "scenes": list(SCENES), **_firmware()}
    if as_json:
        echo_json(facts)
        return
    ready = facts.pop("firmware_libraries")
    # this process has not loaded any
    facts.pop("libraries", None)
    console.print(facts_table({key: _phrase(value) for key, value in facts.items()}))
    for identity in ready:
        console.print()
        details = {key: _phrase(identity[key]) for key in ("features", "compiler", "flags")}
        console.print(facts_table({"library": _name(identity), **details}))


def _firmware() -> dict[str, Any]:
    """Return which checkout of the real firmware would fly, or why none, and what was compiled of it last."""
    from crazychoir_fw.cli.firmware import latest_libraries
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.firmware.cache import cache_root
    from crazychoir_fw.firmware.checkout import open_checkout
    from crazychoir_fw.firmware.library import kept_libraries

    try:
        checkout = open_checkout()
    except CrazychoirError as error:
        return {"firmware": f"none ({error})", "firmware_libraries": []}
    version = checkout.version() or "no repository of its own"
    libraries = [library.identity for library in kept_libraries(cache_root())]
    return {
        "firmware": f"{version} in {checkout.root}",
        "firmware_libraries": latest_libraries(libraries, str(checkout.root)),
    }


def _phrase(value: Any) -> str:
    if value is None or value is False:
        return "no"
    if isinstance(value, list):
        return ", ".join(_phrase(item) for item in value) or "none"
    if isinstance(value, dict):
        # what a provider library was built from
        return _name(value)
    return str(value)


def _name(identity: dict[str, Any]) -> str:
    return " ".join(str(identity[key]) for key in ("provider", "version", "platform") if identity.get(key))
