"""The list `radios` of a mission file: which Crazyradio serves which drones, and how good it is.

Keys, ranges and defaults are those of `crazychoir_fw.crtp.link_model.RadioConfig`, which is the only place where they
are written. Without the list, every drone has a perfect link.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator

from crazychoir_fw.common.constraints import refusal_of
from crazychoir_fw.common.errors import CrazychoirError, MissionError
from crazychoir_fw.mission.values import refusal, unknown_key

if TYPE_CHECKING:
    from crazychoir_fw.crtp.link_model import RadioConfig


def _radio(value: Any) -> RadioConfig:
    """Return one entry."""
    # a mission without radios is checked before the simulation is loaded
    from crazychoir_fw.crtp.link_model.config import MEMBERS, RadioConfig

    if isinstance(value, RadioConfig):
        return value
    if not isinstance(value, Mapping):
        raise refusal("a mapping such as {drones: [cf1, cf2], loss: 0.05}")
    for key, item in value.items():
        if key not in MEMBERS:
            raise unknown_key(key, MEMBERS)
        if allowed := refusal_of(MEMBERS[key], item):
            raise refusal(f"{allowed}", f".{key}", value=item, known=" ".join(allowed.known))
    if "drones" not in value:
        raise refusal("a mapping that names its drones, such as {drones: [cf1, cf2]}")
    return RadioConfig(**{key: tuple(item) if isinstance(item, list) else item for key, item in value.items()})


Radios = list[Annotated[Any, BeforeValidator(_radio)]]


def check_radios(radios: Sequence[RadioConfig], drones: Sequence[str]) -> None:
    """Refuse radios that serve no drone, and drones with two.

    Args:
        radios: Of a mission.
        drones: Names of all drones.

    Raises:
        MissionError: With the key and what is wrong.
    """
    if radios:
        from crazychoir_fw.crtp.link_model.radios import assign

        try:
            assign(radios, drones)
        except CrazychoirError as error:
            raise MissionError(f"radios{error}") from None
