"""The motor controls of a world: their classes, their rates, and what becomes of the drone of one that fails."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from difflib import get_close_matches
from types import ModuleType

from crazychoir_fw.common.errors import CrazychoirError, RangeError, StateError, UnknownNameError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.common.user_code import USER_ERRORS, describe, load_module
from crazychoir_fw.simulation import motor_ctrl
from crazychoir_fw.simulation.drone import Drone
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl import MotorCtrl
from crazychoir_fw.simulation.motor_ctrl_words import STOCK
from crazychoir_fw.simulation.world_base import WorldBase

FORMS = "package.module:Class, path/to/file.py:Class or one of " + ", ".join(STOCK)


class Pilots:
    """The motor controls of one world. A world without them pays nothing."""

    def __init__(self, world: WorldBase) -> None:
        """Find the classes that the drones name, bind one object of each, and put them on the agenda.

        Raises:
            CrazychoirError: If a class is not found or cannot begin; the message names the drone.
        """
        self._world = world
        self._cancel: list[Callable[[], None]] = []
        classes: dict[str, type[MotorCtrl]] = {}  # each file is executed once
        for drone in world.drones:
            if drone.config.motor_ctrl is not None and not world.is_replay:
                drone.motor_ctrl = _class_of(drone, classes)()
        self.begin()

    def begin(self) -> None:
        """Let every motor control begin: at the start, and when the world is reset."""
        for cancel in self._cancel:
            cancel()
        self._cancel.clear()
        by_period: dict[int, list[MotorCtrl]] = {}
        for drone in self._flown():
            control = drone.motor_ctrl
            try:
                control.attach(self._world, drone, drone.config.motor_ctrl_properties)
            except CrazychoirError:
                raise
            except USER_ERRORS as error:  # a user's code may raise anything
                raise StateError(f"{drone.id}: {type(control).__name__}.init failed: {describe(error)}") from error
            by_period.setdefault(TICKS_PER_SECOND // control.rate_hz, []).append(control)
        for period, controls in sorted(by_period.items()):
            # one appointment for all of a rate: the agenda looks through its appointments at every stop
            self._cancel.append(self._world.agenda.every(period, _calls(self, controls)))

    def restored(self) -> None:
        """Tell every motor control that the world went to another time."""
        for drone in self._flown():
            self._guarded(drone.motor_ctrl, drone.motor_ctrl.restored)

    def advance(self, controls: Iterable[MotorCtrl]) -> None:
        """Let some of them do one step."""
        for control in controls:
            self._guarded(control, control.advance)

    def _guarded(self, control: MotorCtrl, call: Callable[[], None]) -> None:
        try:
            call()
        except USER_ERRORS as error:  # a user's code may raise anything, and stops its own drone only
            self._fail(control, error)

    def _fail(self, control: MotorCtrl, error: BaseException) -> None:
        drone = control.drone
        if drone.failure is not None:
            return
        reason = f"{type(control).__name__}: {describe(error)}"
        # past the radio: this is no command, but it belongs into a journal of all that happened to the drone
        drone.uplink.dispatch("cf_fail_pilot", reason.encode())
        self._world.note("failure", drone.id, reason=reason)

    def _flown(self) -> list[Drone]:
        return [drone for drone in self._world.drones if drone.motor_ctrl is not None]


def _calls(pilots: Pilots, controls: list[MotorCtrl]) -> Callable[[], None]:
    return lambda: pilots.advance(controls)


def _class_of(drone: Drone, known: dict[str, type[MotorCtrl]]) -> type[MotorCtrl]:
    wanted = drone.config.motor_ctrl
    if not isinstance(wanted, str):
        return checked_class(wanted, f"{drone.id}: motor_ctrl")
    if wanted not in known:
        known[wanted] = find_class(wanted, drone.id)
    return known[wanted]


def find_class(name: str, who: str) -> type[MotorCtrl]:
    """Return the class that a name means. A module or a file that it names is executed.

    Args:
        name: ``MotorCtrlFPQR`` and its like, ``package.module:Class``, or ``path/to/file.py:Class``.
        who: The drone, for messages.

    Raises:
        UnknownNameError: If there is no such module, file or class.
        RangeError: If the class is no `MotorCtrl`.
        CrazychoirError: If the module raises while it is imported; the message has the exception and the line.
    """
    module_name, colon, wanted = name.rpartition(":")
    if not colon:
        if name not in STOCK:
            near = get_close_matches(name, STOCK, n=1)
            hint = f" (did you mean {near[0]}?)" if near else ""
            raise UnknownNameError(f"{who}: motor_ctrl is '{name}'{hint}, allowed: {FORMS}")
        return getattr(motor_ctrl, name)
    what = f"{who}: motor_ctrl '{name}'"
    module = load_module(module_name, what)
    found = getattr(module, wanted, None)
    if found is None:
        own = [value.__name__ for value in vars(module).values() if _is_own(value, module)]
        raise UnknownNameError(f"{what}: there is no such class, only {', '.join(own) or 'no motor control at all'}")
    return checked_class(found, what)


def _is_own(value: object, module: ModuleType) -> bool:
    return isinstance(value, type) and issubclass(value, MotorCtrl) and value.__module__ == module.__name__


def checked_class(found: object, what: str) -> type[MotorCtrl]:
    """Return a class that is a `MotorCtrl`.

    Raises:
        RangeError: If it is none.
    """
    if not (isinstance(found, type) and issubclass(found, MotorCtrl)):
        raise RangeError(f"{what}: {found!r} is no motor control, allowed: a subclass of MotorCtrl")
    return found
