"""What `crazychoir preflight` finds at drones over the radio, as lines of the page: GO or NO-GO before FLY."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.flight.backends import READY_TIMEOUT, build_world
from crazychoir_fw.flight.roll_call import Part
from crazychoir_fw.preflight.check import Check

if TYPE_CHECKING:
    from crazychoir_fw.gui.session import Session

_SEEN_ALL_THE_TIME = ("ready", "names", "kind", "starts", "safety area")
"""Checks that the page makes by itself, twice a second, and not only once."""


def radio_checks(session: Session) -> list[Check]:
    """Return what a look at the drones found; they are looked at once, before the first of them flies.

    Firmware, parameters, decks, self-tests, spread of positions, links and the radio's load do not change while the
    drones stand there. The look takes some seconds, in which the flight answers nothing else.
    """
    parts = getattr(getattr(session.experiment, "backend", None), "radio_parts", None)
    if not parts:
        return []
    if session.radio_checks is None:
        session.radio_checks = [one for one in _look(session, parts) if one.name not in _SEEN_ALL_THE_TIME]
    return [*session.radio_checks, *([] if session.tested is None else [session.tested])]


def _look(session: Session, parts: Sequence[Part]) -> list[Check]:
    from crazychoir_fw.preflight.drones import look

    try:
        world = build_world(session.mission, visuals=False)
        world.wait_until_ready(timeout_s=READY_TIMEOUT)
        return look(session.mission, parts, {drone.id: drone for drone in world.drones}).checks
    except CrazychoirError as error:
        return [Check("preflight", False, str(error))]
