"""How a handler takes leave of a drone: what flies is landed or stopped, or left as it is."""

from __future__ import annotations

import time
from collections.abc import Callable

from crazychoir_fw.radio.flight import FlightState
from crazychoir_fw.radio.modes import Mode
from crazychoir_fw.radio.sender import Sender

_LAST_WORDS_S = 0.1  # cflib closes a radio link without waiting for what is still to be sent
_LONGEST_LANDING_S = 10.0
_LOOK_S = 0.05


def take_leave(
    flight: FlightState,
    sender: Sender,
    action: str,
    is_flying: Callable[[], bool | None],
    knows_position: bool,
    tick: Callable[[], object] | None,
) -> None:
    """Do what the option `on_close` says; blocks while the drone lands.

    Args:
        flight: What the drone does.
        sender: The way to it.
        action: ``land``, ``stop`` or ``leave``.
        is_flying: Asks its supervisor; None when that does not say.
        knows_position: Whether it has a position on board, which landings need; without, ``land`` levels out.
        tick: Sends what is due; None where a thread does.

    Raises:
        RadioError: If the link breaks meanwhile.
    """
    flies = flight.is_active and flight.mode in (Mode.READY, Mode.TAKING_OFF, Mode.LOST, Mode.LANDING)
    flies = flies and is_flying() is not False
    if action == "leave" and flies:
        return
    if flies and action == "land":
        if flight.mode is not Mode.LANDING:
            (flight.land if knows_position else flight.level_out)()
            sender.outbox.wake()
            flight.emit()
        _wait_for_landing(flight, sender, tick)
    elif flies:
        flight.stop("closed")
        sender.outbox.wake()
        flight.emit()
        sender.outbox.flush(_LAST_WORDS_S)
        time.sleep(_LAST_WORDS_S)
    with sender.lock:
        sender.stream.clear()
    # for the next program: without it the last set-point here would keep the planner on board from flying
    sender.post(sender.release)
    sender.outbox.flush(_LAST_WORDS_S)
    time.sleep(_LAST_WORDS_S)


def _wait_for_landing(flight: FlightState, sender: Sender, tick: Callable[[], object] | None) -> None:
    end = time.monotonic() + _LONGEST_LANDING_S
    while flight.mode is Mode.LANDING and sender.is_connected and time.monotonic() < end:
        if tick is not None:
            tick()
        time.sleep(_LOOK_S)
